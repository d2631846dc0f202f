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

#include <stark/base/thread_pool.h>
#include <stark/mechanics/dof_layout.h>
#include <stark/mechanics/site.h>
#include <stark/mechanics/whole_turn.h>

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
  bool is_rotation = false;  ///< J = -[r]x of the lever of the site; otherwise J = weight * I
  double weight = 1.0;
};

/// Points and weights that a site follows.
struct SiteSupport {
  std::span<const int32_t> points;
  std::span<const double> weights;
};

/// Sum of weights times values of points.
inline Vec3 point_sum(const SiteSupport& support, std::span<const Vec3> by_point) {
  Vec3 sum;
  for (size_t k = 0; k < support.points.size(); ++k) sum += by_point[support.points[k]] * support.weights[k];
  return sum;
}

struct SiteJacobian {
  int term_count = 0;
  std::array<JacobianTerm, 4> terms;
  /// Of embedded sites, which have no terms: blocks of their support, kNoBlock among them, and weights.
  std::span<const int32_t> support_blocks;
  std::span<const double> support_weights;
  int32_t body = -1;  ///< free rigid body whose rotation the site follows, or -1
  Vec3 lever{};       ///< world lever of that body [m]

  bool is_embedded() const { return !support_blocks.empty(); }
  bool is_zero() const { return term_count == 0 && !is_embedded(); }

  /// J of a term.
  Mat3 matrix(const JacobianTerm& term) const {
    return term.is_rotation ? skew(-lever) : Mat3::identity() * term.weight;
  }
  /// J^T f of a term.
  Vec3 pull_back(const JacobianTerm& term, const Vec3& f) const {
    return term.is_rotation ? cross(lever, f) : f * term.weight;
  }
};

class KinematicMap {
 public:
  KinematicMap() = default;
  /// What turns as a whole in a Newton step.
  const std::vector<TurningRange>& turning() const { return turning_; }
  /// Sites come in the order of the points, then others: site i is where point i is. `turning`: what
  /// retract() turns as a whole.
  KinematicMap(DofLayout layout, std::vector<Site> sites, EmbeddedPoints embedded = {},
               std::vector<TurningRange> turning = {});

  int32_t site_count() const { return static_cast<int32_t>(sites_.size()); }
  const DofLayout& layout() const { return layout_; }
  const Site& site(int32_t i) const { return sites_[i]; }

  /// Points and weights of a barycentric or embedded site, nothing of others.
  SiteSupport support(int32_t site) const;
  bool is_embedded(int32_t site) const { return sites_[site].kind == SiteKind::Embedded; }
  /// Number of the support of an embedded site, and blocks of a support, kNoBlock for prescribed points.
  int32_t support_index(int32_t site) const { return embedded_.support[sites_[site].index]; }
  std::span<const int32_t> support_blocks(int32_t support) const {
    return {support_block_.data() + embedded_.first_point[support],
            static_cast<size_t>(embedded_.first_point[support + 1] - embedded_.first_point[support])};
  }
  /// Sets the values of points that follow others, as embedded vertices do, to the sums over those; values
  /// are positions, velocities or displacements by point.
  void follow(std::span<Vec3> by_point) const;

  /// Positions of all sites [m]; prescribed ones included. pool: for many sites. resting: by body, whether
  /// out_x has the positions of its sites; empty where it has none.
  void positions(const Configuration& configuration, std::span<Vec3> out_x, ThreadPool* pool = nullptr,
                 std::span<const uint8_t> resting = {}) const;

  /// True when no unknown moves the site.
  bool is_prescribed(int32_t site) const { return prescribed_[site]; }
  /// Block of a Point site, kNoBlock when it is prescribed; Point sites have an identity map.
  bool is_point(int32_t site) const { return sites_[site].kind == SiteKind::Point; }
  int32_t point_block(int32_t site) const { return layout_.point_block[sites_[site].index]; }

  SiteJacobian jacobian(int32_t site, const Configuration& configuration) const;

  /// Blocks that move the site, appended to out_blocks.
  void append_blocks(int32_t site, std::vector<int32_t>& out_blocks) const;

  /// Whether points go straight, or bodies of points turn as a whole.
  enum class Way : uint8_t { Straight, Turning };
  /// out = configuration retracted by alpha * direction, direction being [block_count][3]. Returns Straight
  /// where no body of points has turned, bodies with rotations aside.
  Way retract(const Configuration& configuration, std::span<const double> direction, double alpha, Way way,
              Configuration& out) const;

 private:
  /// Sites [begin, end) of one kind: consecutive points from `index` on, or sites of the body `index`.
  struct Run {
    SiteKind kind;
    int32_t begin, end, index;
  };

  void find_runs();
  void place(const Run& run, const Configuration& configuration, std::span<Vec3> out_x) const;
  Way turn(const Configuration& from, std::span<const double> direction, double alpha,
           Configuration& out) const;

  DofLayout layout_;
  std::vector<Site> sites_;
  std::vector<Run> runs_;    ///< of points and of sites of bodies, which are most
  std::vector<Vec3> local_;  ///< by site, if there are bodies: what sites_ has, close together [m]
  EmbeddedPoints embedded_;
  std::vector<int32_t> support_block_;  ///< by entry of embedded_.points
  std::vector<int32_t> followers_;      ///< points that are embedded sites
  std::vector<bool> prescribed_;
  std::vector<TurningRange> turning_;
};

}  // namespace stark
