// The whole public interface in one include, for programs that use the library. Never included inside it.
#pragma once

#include <stark/base/error.h>
#include <stark/base/math.h>
#include <stark/base/reading.h>
#include <stark/base/rotation.h>
#include <stark/base/settings.h>
#include <stark/geometry/lattice.h>
#include <stark/geometry/mass_properties.h>
#include <stark/geometry/mesh.h>
#include <stark/geometry/shapes.h>
#include <stark/geometry/topology.h>
#include <stark/mechanics/actuator.h>
#include <stark/mechanics/constitutive_law.h>
#include <stark/mechanics/define.h>
#include <stark/mechanics/formula.h>
#include <stark/sim/scene/actuator.h>
#include <stark/sim/scene/energy.h>
#include <stark/sim/scene/joint.h>
#include <stark/sim/scene/materials.h>
#include <stark/sim/scene/point_set.h>
#include <stark/sim/scene/registry.h>
#include <stark/sim/scene/scene.h>
#include <stark/sim/scene/settings.h>
#include <stark/sim/simulation.h>
#include <stark/sim/step/report_readings.h>
#include <stark/sim/step/step_report.h>
