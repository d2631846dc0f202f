// Positions of sites and the chain rule from sites to unknowns (step phases 4a and 4e). The only place,
// inertia and importers aside, that knows kinds of bodies.
//
// With retraction coordinates x(dt, dw) = t + dt + exp([dw]x) R r at dt = dw = 0 the Jacobian of a rigid
// point is [I, -[r]x] with the world lever r, and the curvature of the map adds, per body,
//     K = sym(M) - tr(M) I,   M = sum_sites g_i r_i^T,
// to the rotational block: nine multiply-adds a site and one 3x3 a body, whatever the number of contacts.
// [theory eq. 3 to 6]
#pragma once

#include <span>
#include <vector>

#include <stark/mechanics/dof_layout.h>
#include <stark/mechanics/site.h>

namespace stark {

/// Positions of everything that moves, without velocities: what a Newton iterate is.
struct Configuration {
  std::vector<Vec3> point_position;  ///< [m]
  std::vector<Vec3> body_position;   ///< [m]
  std::vector<Mat3> body_rotation;
};

/// One term of a site's Jacobian: the site moves by J * (unknown of `block`).
struct JacobianTerm {
  int32_t block = kNoBlock;
  bool is_identity = true;  ///< J = weight * I
  double weight = 1.0;
  Mat3 J{};  ///< used when not is_identity
};

struct SiteJacobian {
  int term_count = 0;
  std::array<JacobianTerm, 4> terms;
  int32_t body = -1;  ///< free rigid body whose rotation the site follows, or -1
  Vec3 lever{};       ///< world lever of that body [m]
};

class KinematicMap {
 public:
  KinematicMap() = default;
  KinematicMap(DofLayout layout, std::vector<Site> sites);

  int32_t site_count() const { return static_cast<int32_t>(sites_.size()); }
  const DofLayout& layout() const { return layout_; }
  const Site& site(int32_t i) const { return sites_[i]; }

  /// Positions of all sites [m]; prescribed ones included.
  void positions(const Configuration& configuration, std::span<Vec3> out_x) const;

  /// True when no unknown moves the site.
  bool is_prescribed(int32_t site) const { return prescribed_[site]; }
  /// Block of a Point site, kNoBlock when it is prescribed; Point sites have an identity map.
  bool is_point(int32_t site) const { return sites_[site].kind == SiteKind::Point; }
  int32_t point_block(int32_t site) const { return layout_.point_block[sites_[site].index]; }

  SiteJacobian jacobian(int32_t site, const Configuration& configuration) const;

  /// Blocks that move the site, appended to out_blocks.
  void append_blocks(int32_t site, std::vector<int32_t>& out_blocks) const;

  /// out = configuration retracted by alpha * direction, direction being [block_count][3].
  void retract(const Configuration& configuration, std::span<const double> direction, double alpha,
               Configuration& out) const;

 private:
  DofLayout layout_;
  std::vector<Site> sites_;
  std::vector<bool> prescribed_;
};

}  // namespace stark
