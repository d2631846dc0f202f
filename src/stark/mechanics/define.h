// Vocabulary for writing energies, joints and actuators: include this in a model file and write the formula
// in namespace stark::models.
#pragma once

#include <stark/mechanics/actuator.h>
#include <stark/mechanics/constitutive_law.h>
#include <stark/mechanics/joint.h>
#include <stark/mechanics/potential.h>
#include <stark/mechanics/rod_law.h>

namespace stark::models {

using namespace symbolic;
// Where both exist, the symbolic type is meant.
using symbolic::Mat3;
using symbolic::Vec3;

}  // namespace stark::models
