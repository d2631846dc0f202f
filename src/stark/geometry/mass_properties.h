// Volume, centre of mass and inertia of solids and shells given by triangle meshes, and principal axes.
// Volume integrals as sums over signed tetrahedra from a reference point (Tonon 2004, "Explicit exact
// formulas for the 3-D tetrahedron inertia tensor"). Used while a scene is built.
#pragma once

#include <span>
#include <tuple>

#include <stark/base/reading.h>
#include <stark/geometry/mesh.h>

namespace stark {

struct MassProperties {
  double measure = 0.0;  // volume [m^3] of a solid, area [m^2] of a shell
  double mass = 0.0;     // [kg]
  Vec3 centre;           // centre of mass [m]
  Mat3 inertia;          // about the centre of mass, in the axes of the mesh [kg m^2]
};
template <>
struct Readings<MassProperties> {
  using P = MassProperties;
  static constexpr std::tuple kAll{reading<&P::measure>("measure", "volume [m^3] or area [m^2]"),
                                   reading<&P::mass>("mass", "[kg]"),
                                   reading<&P::centre>("centre", "of mass [m]"),
                                   reading<&P::inertia>("inertia", "about the centre of mass [kg m^2]")};
};

/// Solid of uniform density [kg/m^3] inside a closed, outward oriented triangle mesh. The signed integral is
/// returned: negative volume means that the mesh is oriented inwards.
MassProperties compute_solid_mass_properties(std::span<const Vec3> vertices,
                                             std::span<const Index3> triangles, double density);

/// Thin shell of uniform area density [kg/m^2] on the triangles.
MassProperties compute_shell_mass_properties(std::span<const Vec3> vertices,
                                             std::span<const Index3> triangles, double area_density);

/// Eigenvalues in ascending order and eigenvectors as the columns of a rotation (determinant +1).
struct PrincipalAxes {
  Vec3 values;
  Mat3 axes;
};

/// Eigen decomposition of a symmetric matrix (cyclic Jacobi; the lower triangle is ignored). Deterministic:
/// columns have their component of largest magnitude positive (the first of equal ones), the last column
/// closes the frame.
PrincipalAxes compute_principal_axes(const Mat3& symmetric);

}  // namespace stark
