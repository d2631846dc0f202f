// Where friction acts (step phase 2). The closest points of a pair are a gap apart, so friction between them
// would be a couple. It acts at the closest point of one side on both: the triangle of the other side carries
// a point there, as if it were fixed to it. Total force and torque of the pair are zero then (theory eq.
// 19a). Two rods that cross have no triangles, but a common normal: their gap turns with it (theory eq. 19e).
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include <stark/base/math.h>
#include <stark/collision/candidates.h>
#include <stark/contact/contact_set.h>
#include <stark/contact/friction_levers.h>

namespace stark {

/// Largest number of points of a friction stencil: two triangles.
inline constexpr int kFrictionPoints = 6;

/// Motion of side A against side B at the point of friction, linear in the motions d_i of the sites:
///     u = sum_i weight_i d_i + slope_i (facing . d_i).
struct FrictionStencil {
  int8_t point_count = 0;
  std::array<int32_t, kFrictionPoints> sites{};
  std::array<double, kFrictionPoints> weights{};  ///< sum to zero
  std::array<Vec3, kFrictionPoints> slopes{};     ///< sum to zero; the turning of the triangle or the gap
  Vec3 facing;                                    ///< its unit normal, or that of two edges; zero without
  Vec3 shift;                                     ///< of the point from the closest one [m]
  LeverArm arm;                                   ///< that shifts it
  int8_t own_count = 0;  ///< of the first sites, which have the point; the others carry it

  bool is_carried() const { return own_count > 0; }
  /// Whether vertices bear more than the force at the closest points.
  bool turns() const { return squared_norm(facing) > 0.0; }
  Vec3 point(std::span<const Vec3> x) const;
  /// Of the same contact whose sides are named the other way round.
  FrictionStencil swapped() const;

  Vec3 motion(std::span<const Vec3> x, std::span<const Vec3> reference) const;
};

/// The closest points of a contact as they are, a gap apart.
FrictionStencil closest_points(const Contact& contact);

/// Triangles of the surfaces that carry points of friction.
class FrictionCarriers {
 public:
  FrictionCarriers() = default;
  /// rigid_sites: by site, whether its body is rigid; none where it is empty.
  explicit FrictionCarriers(const SurfaceMesh& mesh, std::vector<bool> rigid_sites = {},
                            FrictionLevers levers = {});

  /// Stencil of a contact at site positions x. Points against triangles, and edges of which one is of a rigid
  /// body; otherwise the closest points as they are.
  /// arm: to be kept; none: by the positions.
  FrictionStencil stencil(const SurfaceMesh& mesh, const Contact& contact, std::span<const Vec3> x,
                          std::optional<LeverArm> arm = {}) const {
    PressedAreas areas;
    return stencil(mesh, contact, x, arm, areas);
  }
  /// areas: what faces share at these positions, as far as it is known.
  FrictionStencil stencil(const SurfaceMesh& mesh, const Contact& contact, std::span<const Vec3> x,
                          const std::optional<LeverArm>& arm, PressedAreas& areas) const;

 private:
  struct Carrier {
    std::optional<Index3> triangle;
    std::array<int32_t, 2> other{-1, -1};  ///< vertices of the primitive of the other side
  };
  Carrier carrier_of(const SurfaceMesh& mesh, const Contact& contact, std::span<const Vec3> x) const;
  /// Of the two at an edge the one that faces the gap.
  int32_t triangle_at_edge(const SurfaceMesh& mesh, int32_t edge, const Vec3& gap,
                           std::span<const Vec3> x) const;

  /// Vertices between which a rod runs where its vertices, one or two, are touched: the ends of the edge, or
  /// the vertices beside the one; -1 where they are none of a rod.
  Index2 chord_of(std::span<const int32_t> touched) const;

  /// Of the surface that a point touches.
  std::optional<Index3> triangle_at_point(const SurfaceMesh& mesh, const Contact& contact) const;

  /// Where friction of a corner of a rigid body acts that touches this triangle of unit normal.
  LeverArm arm_of(const SurfaceMesh& mesh, const Contact& contact, const Index3& triangle, const Vec3& normal,
                  std::span<const Vec3> x) const;

  bool is_rigid(int32_t site) const { return !rigid_sites_.empty() && rigid_sites_[site]; }

  std::vector<bool> rigid_sites_;
  std::vector<Index2> triangles_of_edge_;    ///< -1 where there is none
  std::vector<int32_t> triangle_of_vertex_;  ///< one of them, -1 where there is none
  std::vector<Index2> chord_of_vertex_;      ///< of rods those beside it, or an end itself; else -1
  FrictionLevers levers_;
};

}  // namespace stark
