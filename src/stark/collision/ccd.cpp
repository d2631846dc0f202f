// Conservative advancement along separating planes and by the coplanarity cubic. See ccd.h.
#include <stark/collision/ccd.h>

#include <algorithm>
#include <cmath>

#include <stark/geometry/distance.h>

namespace stark {

namespace {

// Rounding errors of one gap n . (a - b), relative to the sizes of the position and motion differences: three
// roundings per component of a - b and of its motion, three of the dot product, three of n; 32 is ample.
constexpr double kGapError = 32.0 * 0x1p-53;

double norm1(const Vec3& a) { return std::fabs(a.x) + std::fabs(a.y) + std::fabs(a.z); }

// Unit vector, or zero if the length underflows.
Vec3 unit_or_zero(const Vec3& a) {
  const double length = norm(a);
  return length > 1e-150 ? a / length : Vec3{};
}

// Direction from the line (e0, e1) to p: perpendicular to the edge. The projection is repeated because the
// first one leaves an error relative to |p - e0|, which can be much more than the distance.
Vec3 line_to_point(const Vec3& p, const Vec3& e0, const Vec3& e1) {
  const Vec3 e = e1 - e0;
  const double length2 = squared_norm(e);
  Vec3 r = p - e0;
  if (!(length2 > 0.0)) return r;
  r -= e * (dot(r, e) / length2);
  return r - e * (dot(r, e) / length2);
}

// Normal of two directions, towards the side of w.
Vec3 normal_towards(const Vec3& u, const Vec3& v, const Vec3& w) {
  const Vec3 normal = common_normal(u, v);
  return dot(normal, w) < 0.0 ? -normal : normal;
}

Vec3 edge_to_point(const Vec3& p, const Vec3& e0, const Vec3& e1) {
  switch (point_edge_type(p, e0, e1)) {
    case PointEdgeType::P_E0:
      return p - e0;
    case PointEdgeType::P_E1:
      return p - e1;
    case PointEdgeType::P_E:
      break;
  }
  return line_to_point(p, e0, e1);
}

// Spanning vectors u, v of the two primitives and a vector w between them: |w . (u x v)| / |u x v| is the
// distance of the lines or of the point from the plane, which bounds the distance of the primitives from
// below.
struct Frame {
  Vec3 w, u, v;
};

// The two primitives of each kind, A before B, and the direction from the closest point of B to that of A.
struct PointPoint {
  static constexpr int kA = 1, kB = 1;
  static constexpr bool kHasVolume = false;
  static Vec3 direction(const std::array<Vec3, 2>& x) { return x[0] - x[1]; }
  template <typename Body>
  static void for_each_direction(const std::array<Vec3, 2>& x, Body&& body) {
    body(x[0] - x[1]);
  }
};

struct PointEdge {
  static constexpr int kA = 1, kB = 2;
  static constexpr bool kHasVolume = false;
  static Vec3 direction(const std::array<Vec3, 3>& x) { return edge_to_point(x[0], x[1], x[2]); }
  template <typename Body>
  static void for_each_direction(const std::array<Vec3, 3>& x, Body&& body) {
    body(line_to_point(x[0], x[1], x[2]));
    body(x[0] - x[1]);
    body(x[0] - x[2]);
  }
};

struct PointTriangle {
  static constexpr int kA = 1, kB = 3;
  static constexpr bool kHasVolume = true;
  static Frame frame(const std::array<Vec3, 4>& x) { return {x[0] - x[1], x[2] - x[1], x[3] - x[1]}; }
  static Vec3 direction(const std::array<Vec3, 4>& x) {
    using enum PointTriangleType;
    const auto& [p, t0, t1, t2] = x;
    switch (point_triangle_type(p, t0, t1, t2)) {
      case P_T0:
        return p - t0;
      case P_T1:
        return p - t1;
      case P_T2:
        return p - t2;
      case P_E0:
        return line_to_point(p, t0, t1);
      case P_E1:
        return line_to_point(p, t1, t2);
      case P_E2:
        return line_to_point(p, t2, t0);
      case P_T:
        break;
    }
    return normal_towards(t1 - t0, t2 - t0, p - t0);
  }
  template <typename Body>
  static void for_each_direction(const std::array<Vec3, 4>& x, Body&& body) {
    const auto& [p, t0, t1, t2] = x;
    const Vec3 normal = normal_towards(t1 - t0, t2 - t0, p - t0);
    body(normal);
    body(-normal);
    body(line_to_point(p, t0, t1));
    body(line_to_point(p, t1, t2));
    body(line_to_point(p, t2, t0));
    body(p - t0);
    body(p - t1);
    body(p - t2);
  }
};

struct EdgeEdge {
  static constexpr int kA = 2, kB = 2;
  static constexpr bool kHasVolume = true;
  static Frame frame(const std::array<Vec3, 4>& x) { return {x[0] - x[2], x[1] - x[0], x[3] - x[2]}; }
  static Vec3 direction(const std::array<Vec3, 4>& x) {
    using enum EdgeEdgeType;
    const auto& [a0, a1, b0, b1] = x;
    switch (edge_edge_type(a0, a1, b0, b1)) {
      case EA0_EB0:
        return a0 - b0;
      case EA0_EB1:
        return a0 - b1;
      case EA1_EB0:
        return a1 - b0;
      case EA1_EB1:
        return a1 - b1;
      case EA_EB0:
        return -line_to_point(b0, a0, a1);
      case EA_EB1:
        return -line_to_point(b1, a0, a1);
      case EA0_EB:
        return line_to_point(a0, b0, b1);
      case EA1_EB:
        return line_to_point(a1, b0, b1);
      case EA_EB:
        break;
    }
    return normal_towards(a1 - a0, b1 - b0, a0 - b0);
  }
  template <typename Body>
  static void for_each_direction(const std::array<Vec3, 4>& x, Body&& body) {
    const auto& [a0, a1, b0, b1] = x;
    const Vec3 normal = normal_towards(a1 - a0, b1 - b0, a0 - b0);
    body(normal);
    body(-normal);
    body(-edge_to_point(b0, a0, a1));
    body(-edge_to_point(b1, a0, a1));
    body(edge_to_point(a0, b0, b1));
    body(edge_to_point(a1, b0, b1));
    body(-line_to_point(b0, a0, a1));
    body(-line_to_point(b1, a0, a1));
    body(line_to_point(a0, b0, b1));
    body(line_to_point(a1, b0, b1));
  }
};

// Differences of all vertex pairs: position at the start and motion, relative so that large coordinates and
// common motion drop out.
template <typename Kind>
struct Motion {
  static constexpr int kCount = Kind::kA + Kind::kB, kPairs = Kind::kA * Kind::kB;
  using Stencil = std::array<Vec3, kCount>;

  Stencil start, motion;  // relative to the last vertex
  std::array<Vec3, kPairs> pair_start, pair_motion;
  double error = 0.0;  // bound of the rounding error of a gap [m]

  Motion(const Stencil& x0, const Stencil& x1) {
    for (int k = 0; k < kCount; ++k) {
      start[k] = x0[k] - x0[kCount - 1];
      motion[k] = (x1[k] - x0[k]) - (x1[kCount - 1] - x0[kCount - 1]);
    }
    double size = 0.0, total = 0.0;
    for (int i = 0; i < Kind::kA; ++i) {
      for (int j = 0; j < Kind::kB; ++j) {
        const int a = i, b = Kind::kA + j, k = i * Kind::kB + j;
        pair_start[k] = x0[a] - x0[b];
        pair_motion[k] = (x1[a] - x0[a]) - (x1[b] - x0[b]);
        const double pair_size = norm1(pair_start[k]) + norm1(x1[a] - x0[a]) + norm1(x1[b] - x0[b]);
        size = std::max(size, pair_size);
        total += pair_size;
      }
    }
    // Comparisons drop numbers that are not finite, the sum does not.
    error = std::isfinite(total) ? kGapError * size : HUGE_VAL;
  }

  Stencil at(double t) const {
    Stencil x;
    for (int k = 0; k < kCount; ++k) x[k] = start[k] + motion[k] * t;
    return x;
  }

  // Gap of each pair along n at time t, lowered by the error bound; returns the smallest.
  double gaps(const Vec3& n, double t, std::array<double, kPairs>& out) const {
    double smallest = HUGE_VAL;
    for (int k = 0; k < kPairs; ++k) {
      out[k] = dot(n, pair_start[k] + pair_motion[k] * t) - error;
      smallest = std::min(smallest, out[k]);
    }
    return smallest;
  }
};

/// How the area |u x v| of a frame on its way is bounded: by |u| |v|, or by its Bernstein coefficients, which
/// takes longer and tells where primitives turn at a gap hardly above the separation: each plane is left at
/// once there, though they do not come nearer.
enum class AreaBound : uint8_t { Lengths, Coefficients };

// The cubic w . (u x v) keeps its sign and stays above `separation` times the area from frame `a` to frame
// `b`, both moving linearly: its Bernstein coefficients, values of the blossom, bound it.
bool volume_stays_positive(const Frame& a, const Frame& b, double separation, double error, AreaBound bound) {
  const Vec3 aa = cross(a.u, a.v), ab = cross(a.u, b.v), ba = cross(b.u, a.v), bb = cross(b.u, b.v);
  const Vec3 mixed = ab + ba;
  const double c0 = dot(a.w, aa), c1 = (dot(b.w, aa) + dot(a.w, mixed)) / 3.0;
  const double c2 = (dot(b.w, mixed) + dot(a.w, bb)) / 3.0, c3 = dot(b.w, bb);
  const double smallest = c0 > 0.0 ? std::min({c0, c1, c2, c3}) : std::min({-c0, -c1, -c2, -c3});
  const double u = std::sqrt(std::max(squared_norm(a.u), squared_norm(b.u)));
  const double v = std::sqrt(std::max(squared_norm(a.v), squared_norm(b.v)));
  const double w = std::sqrt(std::max(squared_norm(a.w), squared_norm(b.w)));
  const double area = bound == AreaBound::Lengths ? u * v : std::max({norm(aa), 0.5 * norm(mixed), norm(bb)});
  return smallest > (separation * area) * (1.0 + 1e-12) + 8.0 * error * (u * v + v * w + w * u);
}

// A time step from t longer than `step`, safe by the volume; or `step`. Long primitives at a small gap that
// turn against each other leave a separating plane at once although they do not meet; the volume sees that.
template <typename Kind>
double extend_by_volume(const Motion<Kind>& motion, double t, double step, double separation,
                        AreaBound bound) {
  const Frame now = Kind::frame(motion.at(t));
  for (double longer = 1.0 - t; longer > 2.0 * step; longer *= 0.25) {
    if (volume_stays_positive(now, Kind::frame(motion.at(t + longer)), separation, motion.error, bound))
      return longer;
  }
  return step;
}

/// Pairs that start nearer than the separation keep this part of their gap.
constexpr double kKeptGap = 0.5;

/// What all pairs keep of their gap where the separation is no bound.
constexpr double kSoftGap = 0.1;

/// Part of the separation by which a pair may be below it because positions are rounded.
constexpr double kPositionRounding = 1e-4;

// What a pair keeps, whose distance is between its gap and that with twice the error. One that has come to
// the separation stays there: were it to count as nearer because of rounding, gaps would shrink motion by
// motion.
double separation_to_keep(double min_separation, double gap, double error, bool is_bound) {
  if (!is_bound) return std::min(min_separation, kSoftGap * gap);
  const bool is_there = gap + 2.0 * error > (1.0 - kPositionRounding) * min_separation;
  return is_there ? min_separation : kKeptGap * gap;
}

template <typename Kind>
double advance(const std::array<Vec3, Kind::kA + Kind::kB>& x0,
               const std::array<Vec3, Kind::kA + Kind::kB>& x1, double min_separation,
               const CcdSettings& settings) {
  const Motion<Kind> motion(x0, x1);
  if (!std::isfinite(motion.error)) return 0.0;
  std::array<double, Motion<Kind>::kPairs> gaps;
  Vec3 n = unit_or_zero(Kind::direction(motion.start));
  double gap = motion.gaps(n, 0.0, gaps);
  if (!(gap > 0.0)) {
    // Nearly degenerate primitives can have a wrong closest feature: the best of all candidate directions.
    Kind::for_each_direction(motion.start, [&](const Vec3& direction) {
      const Vec3 other = unit_or_zero(direction);
      const double other_gap = motion.gaps(other, 0.0, gaps);
      if (other_gap > gap) {
        gap = other_gap;
        n = other;
      }
    });
    if (!(gap > 0.0)) return 0.0;
    motion.gaps(n, 0.0, gaps);
  }
  const double separation = separation_to_keep(min_separation, gap, motion.error, settings.is_bound);
  const double stop = separation + settings.tolerance * (gap - separation);
  const double keep = 1.0 - settings.time_margin;
  double t = 0.0;
  const int iterations = settings.max_iterations + (Kind::kHasVolume ? settings.sharper_iterations : 0);
  for (int iteration = 0; iteration < iterations; ++iteration) {
    if (iteration > 0) {
      n = unit_or_zero(Kind::direction(motion.at(t)));
      if (!(motion.gaps(n, t, gaps) > stop)) return keep * t;
    }
    double step = HUGE_VAL;
    for (int k = 0; k < Motion<Kind>::kPairs; ++k) {
      const double rate = dot(n, motion.pair_motion[k]);
      if (rate < 0.0) step = std::min(step, std::max(0.0, gaps[k] - separation) / -rate);
    }
    if (t + step >= settings.horizon) return 1.0;
    if constexpr (Kind::kHasVolume) {
      step = extend_by_volume(
          motion, t, step, separation,
          iteration < settings.max_iterations ? AreaBound::Lengths : AreaBound::Coefficients);
      if (t + step >= settings.horizon) return 1.0;
    }
    if (!(t + step > t)) return keep * t;
    t += step;
  }
  return keep * t;
}

}  // namespace

double point_point_ccd(const std::array<Vec3, 2>& x0, const std::array<Vec3, 2>& x1, double min_separation,
                       const CcdSettings& settings) {
  return advance<PointPoint>(x0, x1, min_separation, settings);
}

double point_edge_ccd(const std::array<Vec3, 3>& x0, const std::array<Vec3, 3>& x1, double min_separation,
                      const CcdSettings& settings) {
  return advance<PointEdge>(x0, x1, min_separation, settings);
}

double point_triangle_ccd(const std::array<Vec3, 4>& x0, const std::array<Vec3, 4>& x1, double min_separation,
                          const CcdSettings& settings) {
  return advance<PointTriangle>(x0, x1, min_separation, settings);
}

double edge_edge_ccd(const std::array<Vec3, 4>& x0, const std::array<Vec3, 4>& x1, double min_separation,
                     const CcdSettings& settings) {
  return advance<EdgeEdge>(x0, x1, min_separation, settings);
}

}  // namespace stark
