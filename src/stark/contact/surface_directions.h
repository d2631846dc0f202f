// Directions on surfaces, such as the nap of a fabric or the grooves of a belt: tangents of triangles that
// are carried along with the material. They are the axes of anisotropic friction (step phase 2). [theory
// eq. 20b]
#pragma once

#include <array>
#include <span>
#include <vector>

#include <stark/base/math.h>
#include <stark/collision/candidates.h>
#include <stark/contact/contact_set.h>

namespace stark {

/// Components of a tangent of a triangle in its edges from vertex 0 to vertices 1 and 2 [1/m]: the same at
/// rest and deformed, so the tangent is pushed forward. Zero: no direction.
using TangentComponents = std::array<double, 2>;

/// Components of the unit vector in the plane of the triangle next to `direction`; zero where the direction
/// is normal to the triangle.
TangentComponents tangent_components(const Vec3& x0, const Vec3& x1, const Vec3& x2, const Vec3& direction);

class SurfaceDirections {
 public:
  SurfaceDirections() = default;
  /// components: by triangle of the mesh, or none when no surface has a direction. Edges and vertices have
  /// the mean of the triangles that they belong to, by the areas seen along the normal of the contact: at the
  /// corner of a box on a floor that is its lower face.
  SurfaceDirections(const SurfaceMesh& mesh, std::vector<TangentComponents> components);

  /// Direction of the side of a pair that is of the group, at site positions x, in the plane of a unit
  /// normal; unit length, its sign means nothing. A triangle decides where both sides are of the group, else
  /// the first edge. Zero where there is no direction in the plane.
  Vec3 of_pair(const SurfaceMesh& mesh, const PairKey& key, int32_t group, const Vec3& normal,
               std::span<const Vec3> x) const;

 private:
  Vec3 of_triangles(const SurfaceMesh& mesh, std::span<const int32_t> triangles, const Vec3& normal,
                    std::span<const Vec3> x) const;

  std::vector<TangentComponents> components_;
  std::vector<std::vector<int32_t>> triangles_of_vertex_, triangles_of_edge_;
};

}  // namespace stark
