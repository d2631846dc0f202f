// Friction of a corner of a flat face that lies flat on another acts inside the face, where the pressure has
// its lever that the corner stands for (step phase 2; geometry/face_levers.h). It goes back to the corner as
// the face tilts, and stays where the other face is. [theory eq. 19d]
#pragma once

#include <span>
#include <vector>

#include <stark/contact/closest_features.h>
#include <stark/contact/contact_set.h>

namespace stark {

/// A site inside a flat face of a rigid body, where friction of a vertex of its border acts.
struct LeverSite {
  int32_t vertex = 0, triangle = 0, site = 0;
};

/// Where friction acts: so much of the way from the vertex to the site; 0: at the vertex.
struct LeverArm {
  int32_t site = 0;
  double part = 0.0;
};

class FrictionLevers {
 public:
  FrictionLevers() = default;
  /// patch: by triangle the lowest of its flat face; none: each is one.
  FrictionLevers(const SurfaceMesh& mesh, std::vector<LeverSite> sites, std::vector<int32_t> patch);

  bool empty() const { return sites_.empty(); }
  /// Of a contact of a vertex with a triangle of a rigid body of this number and unit normal, at site
  /// positions x.
  LeverArm arm(const SurfaceMesh& mesh, const Contact& contact, int32_t triangle, const Vec3& normal,
               std::span<const Vec3> x) const;

 private:
  /// The one of the face of the vertex that lies flattest, and 1 where that lies flat, 0 where none does.
  LeverArm flattest(const SurfaceMesh& mesh, int32_t vertex, const Vec3& normal,
                    std::span<const Vec3> x) const;
  /// Part of the way from a vertex to a site that is over the face of a triangle.
  double part_within(int32_t triangle, const Vec3& normal, const Vec3& from, const Vec3& to,
                     std::span<const Vec3> x) const;

  std::vector<LeverSite> sites_;  ///< by vertex
  std::vector<int32_t> patch_;
  SurfaceCells borders_;  ///< of flat faces
};

}  // namespace stark
