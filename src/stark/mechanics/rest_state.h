// Rest states that change while a simulation runs: growth, temperature and activation of a law's elements, as
// inputs that each element has a value of. A law in a rest state is a law again, of the elastic part of the
// deformation, so it runs on every element that its law runs on. Phase: model building. [theory eq. 15d to
// 15f]
#pragma once

#include <set>
#include <string>

#include <stark/mechanics/constitutive_law.h>
#include <stark/mechanics/rod_law.h>

namespace stark::rest_state {

/// Stretch of the rest shape: 9 numbers in solids, a tensor in the axes of the mesh, 1 in shells (of both
/// directions) and rods (of the length).
inline constexpr const char* kGrowth = "growth";
/// [K] above that of the rest shape; stretches it by 1 + thermal_expansion times temperature.
inline constexpr const char* kTemperature = "temperature";
inline constexpr const char* kThermalExpansion = "thermal_expansion";  ///< [1/K], a parameter
/// [Pa] of solids along fiber_direction: force over the area at rest.
inline constexpr const char* kActiveStress = "active_stress";
inline constexpr const char* kFiberDirection = "fiber_direction";  ///< of solids, in the axes of the mesh
/// [1/m] of rods, about d1 and d2, beside the curvature of the rest shape.
inline constexpr const char* kNaturalCurvature = "natural_curvature";
inline constexpr const char* kNaturalTwist = "natural_twist";  ///< [rad/m] of rods

/// The law with those of the fields above that `fields` names.
SolidLaw with_fields(const SolidLaw& law, const std::set<std::string>& fields);
ShellLaw with_fields(const ShellLaw& law, const std::set<std::string>& fields);
RodLaw with_fields(const RodLaw& law, const std::set<std::string>& fields);

}  // namespace stark::rest_state
