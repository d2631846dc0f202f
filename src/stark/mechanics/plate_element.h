// Triangles that bend like plates: the fold angles of the hinges around a triangle determine its curvature
// tensor, exactly for every surface of constant curvature and on every mesh. Phase: model building.
//
// A triangle and the three vertices opposite to its edges are six points, as many as a quadratic surface has
// coefficients [as in the rotation-free triangles of Onate and Zarate 2000]. Affine functions fold no hinge,
// so that the three fold angles theta = C k correspond to the three curvatures k = (k11, k22, 2 k12). The
// energy of the triangle, with the smallest curvature energy that has these angles,
//     E = D/2 theta^T S theta,   S = (C (A P)^-1 C^T)^-1,   P = [1 nu 0; nu 1 0; 0 0 (1 - nu)/2],
// is that of a plate with rigidity D and area A. At the boundary, hinges between triangles of fewer
// neighbours are
// compared with the angle that a whole triangle next to them predicts, E = D/2 |e|^2/(A_1 + A_2) (theta_4 - c
// C^-1 theta)^2, which is zero for constant curvature.
#pragma once

#include <array>
#include <span>
#include <vector>

#include <stark/geometry/mesh.h>

namespace stark {

/// Hinges 0 to 2 are at the edges of the triangle, hinge k from vertex k to k + 1 with vertex 3 + k beyond.
/// A fourth one is at the edge from vertex 0 to 3, between the triangle (0, 3, 1) and vertex 6.
struct PlateElement {
  int hinge_count = 0;                  ///< 1 to 4
  std::array<int32_t, 7> vertices{};    ///< of the triangle, then those beyond the hinges
  std::array<double, 4> rest_angles{};  ///< fold angles of the hinges in the rest shape [rad]
  std::array<double, 10> form{};        ///< S by rows of the upper triangle of 4 x 4 [1]
  /// Of elements with a hinge or three for each edge, not of those with four:
  double area = 0.0;  ///< A [m^2]
  /// By rows, the curvatures (k11 + k22)/2^(1/2), (k11 - k22)/2^(1/2), 2 k12 of unit fold angles that have
  /// the energy S [1/m].
  std::array<double, 9> curvature{};
  int32_t triangle = -1;  ///< whose plane it is unfolded into
  /// By hinge, its fold angle over the entries xx, yy, zz, yz, xz, xy of a curvature tensor in the axes of
  /// the mesh, whose positive values bend the surface towards its normal [m].
  std::array<std::array<double, 6>, 4> angle_of_curvature{};
  /// S less the form of these curvatures, as `form`: zero, except where points are near a conic section.
  std::array<double, 10> remaining_form{};
};

/// Vertices of a hinge of an element: the two of the edge, then the one on either side.
std::array<int, 4> plate_hinge(int hinge);

/// Signed angle between the normals of the triangles (a, b, c) and (b, a, d), as models/shells/hinge.h has it
/// [rad].
double fold_angle(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d);

/// Elements that carry the bending of a surface in its rest shape `X` [m]. Triangles with a hinge at each
/// edge stand for themselves and for the areas of neighbours at the boundary, whose curvature cannot be
/// told; where there is no such triangle, as in strips of one cell, elements have the hinges there are.
/// Edges of more than two triangles do not bend. Every element is unfolded into its plane, so that X may be
/// curved.
std::vector<PlateElement> find_plate_elements(std::span<const Vec3> X, std::span<const Index3> triangles,
                                              double poissons_ratio);

}  // namespace stark
