// Friction of a corner of a flat face that lies flat on another acts inside the face, where the pressure has
// its lever that the corner stands for (step phase 2; geometry/face_levers.h). It goes back to the corner as
// the face tilts, and stays where the other face is. [theory eq. 19d]
#pragma once

#include <array>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include <stark/contact/closest_features.h>
#include <stark/contact/contact_set.h>
#include <stark/geometry/pressed_area.h>

namespace stark {

/// A site inside a flat face of a rigid body, where friction of a vertex of its border acts.
struct LeverSite {
  int32_t vertex = 0, triangle = 0, site = 0;
};

/// A place of a triangle of a flat face, and a triangle of the other face that lies on it.
struct SharedPlace {
  Index3 face;
  std::array<double, 3> shares;  ///< of the corners of the triangle
  Index3 carrier;
};

/// Where friction acts: so much of the way from the vertex to the site; 0: at the vertex. Or, of faces that
/// lie on each other in part, at a place that both share.
struct LeverArm {
  int32_t site = 0;
  double part = 0.0;
  std::optional<SharedPlace> shared{};
};

/// Arms of contacts by their keys, which are in order.
class LeverArms {
 public:
  void clear() { arms_.clear(); }
  void append(const PairKey& key, const LeverArm& arm);
  /// That of a pair, or of the same point on another triangle of the same flat face; patch as in
  /// FrictionLevers.
  std::optional<LeverArm> find(const PairKey& key, std::span<const int32_t> patch) const;

 private:
  struct Entry {
    PairKey key;
    LeverArm arm;
  };
  std::vector<Entry> arms_;
};

/// What pairs of faces share at the same site positions, by their triangles.
using PressedAreas = std::map<Index2, std::optional<PressedArea>>;

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
  /// Of a contact between two flat faces that lie on each other with more than half of the smaller one: in
  /// what they share. None where arm() tells, for a vertex whose face lies inside of the other.
  std::optional<SharedPlace> shared_place(const SurfaceMesh& mesh, const Contact& contact,
                                          std::span<const Vec3> x, PressedAreas& areas) const;

 private:
  /// A flat face, by the triangle that names it.
  struct Face {
    int32_t triangle = -1;
    std::vector<int32_t> corners;
  };
  /// Two faces, and 1 where they lie flat on each other, 0 where they tilt.
  struct Flat {
    std::array<const Face*, 2> faces{};
    double part = 0.0;
  };
  /// Of those that have these vertices the two that lie flattest on each other, across a gap of this
  /// direction.
  Flat flattest_pair(const SurfaceMesh& mesh, std::span<const int32_t> of_a, std::span<const int32_t> of_b,
                     const Vec3& gap, std::span<const Vec3> x) const;
  /// Calls visit(face, normal) for the faces that have all these vertices and lie across the gap.
  template <class Visit>
  void visit_faces(const SurfaceMesh& mesh, std::span<const int32_t> vertices, const Vec3& gap,
                   std::span<const Vec3> x, const Visit& visit) const;
  /// The one of the face of the vertex that lies flattest, and 1 where that lies flat, 0 where none does.
  LeverArm flattest(const SurfaceMesh& mesh, int32_t vertex, const Vec3& normal,
                    std::span<const Vec3> x) const;
  /// Part of the way from a vertex to a site that is over the face of a triangle.
  double part_within(int32_t triangle, const Vec3& normal, const Vec3& from, const Vec3& to,
                     std::span<const Vec3> x) const;

  std::vector<LeverSite> sites_;  ///< by vertex
  std::vector<Face> faces_;
  std::vector<int32_t> face_of_;  ///< [site] -> index into faces_
  std::vector<int32_t> patch_;
  SurfaceCells borders_;  ///< of flat faces
};

}  // namespace stark
