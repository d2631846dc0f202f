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
/// [Pa] of solids and shells along fiber_direction: force over the area at rest.
inline constexpr const char* kActiveStress = "active_stress";
/// Of solids and shells, in the axes of the mesh; what of it lies in the triangle of a shell.
inline constexpr const char* kFiberDirection = "fiber_direction";
inline constexpr const char* kActiveForce = "active_force";  ///< [N] of rods, along the rod
/// [1/m] beside the curvature of the rest shape: of rods 2 numbers, about d1 and d2, of shells a tensor of 9
/// in the axes of the mesh, what of it lies in the triangle.
inline constexpr const char* kNaturalCurvature = "natural_curvature";
inline constexpr const char* kNaturalTwist = "natural_twist";  ///< [rad/m] of rods

/// The law with those of the fields above that `fields` names.
SolidLaw with_fields(const SolidLaw& law, const std::set<std::string>& fields);
ShellLaw with_fields(const ShellLaw& law, const std::set<std::string>& fields);
RodLaw with_fields(const RodLaw& law, const std::set<std::string>& fields);

/// Those of the fields that change the shape at rest: growth and temperature.
std::set<std::string> stretching(const std::set<std::string>& fields);

/// What the rest shape of an edge has become: its vector, and the volume that it stands for over that in the
/// mesh. Of solids growth is a tensor, of shells a number.
struct GrownEdge {
  symbolic::Vec3 vector;
  symbolic::Scalar volume_ratio;
};
GrownEdge grown_edge(PotentialBuilder& b, const std::set<std::string>& fields, const symbolic::Vec3& edge,
                     bool is_solid);

}  // namespace stark::rest_state
