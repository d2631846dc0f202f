// What can be read of a scene, row by row (base/reading.h).
#pragma once

#include <tuple>

#include <stark/base/reading.h>
#include <stark/sim/scene/scene.h>

namespace stark {

template <>
struct Readings<RigidInertia> {
  static constexpr std::tuple kAll{reading<&RigidInertia::mass>("mass", "[kg]"),
                                   reading<&RigidInertia::center_of_mass>("center_of_mass", "[m]"),
                                   reading<&RigidInertia::tensor>("tensor", "[kg m^2]")};
};

}  // namespace stark
