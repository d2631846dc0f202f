// Conservative advancement along separating planes, and its minimum over a candidate list. See ccd.h.
#include <stark/collision/ccd.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <stark/base/error.h>
#include <stark/geometry/distance.h>

namespace stark {

namespace {

// Rounding errors of one gap n . (a - b), relative to the sizes of the position and motion differences: three roundings
// per component of a - b and of its motion, three of the dot product, three of n; 32 is ample.
constexpr double kGapError = 32.0 * 0x1p-53;

double norm1(const Vec3& a) { return std::fabs(a.x) + std::fabs(a.y) + std::fabs(a.z); }

// Unit vector, or zero if the length underflows.
Vec3 unit_or_zero(const Vec3& a) {
  const double length = norm(a);
  return length > 1e-150 ? a / length : Vec3{};
}

// Direction from the line (e0, e1) to p: perpendicular to the edge. The projection is repeated because the first one
// leaves an error relative to |p - e0|, which can be much more than the distance.
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
    case PointEdgeType::P_E0: return p - e0;
    case PointEdgeType::P_E1: return p - e1;
    case PointEdgeType::P_E: break;
  }
  return line_to_point(p, e0, e1);
}

// The two primitives of each kind, A before B, and the direction from the closest point of B to that of A.
struct PointPoint {
  static constexpr int kA = 1, kB = 1;
  static Vec3 direction(const std::array<Vec3, 2>& x) { return x[0] - x[1]; }
  template <typename Body>
  static void for_each_direction(const std::array<Vec3, 2>& x, Body&& body) {
    body(x[0] - x[1]);
  }
};

struct PointEdge {
  static constexpr int kA = 1, kB = 2;
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
  static Vec3 direction(const std::array<Vec3, 4>& x) {
    using enum PointTriangleType;
    const auto& [p, t0, t1, t2] = x;
    switch (point_triangle_type(p, t0, t1, t2)) {
      case P_T0: return p - t0;
      case P_T1: return p - t1;
      case P_T2: return p - t2;
      case P_E0: return line_to_point(p, t0, t1);
      case P_E1: return line_to_point(p, t1, t2);
      case P_E2: return line_to_point(p, t2, t0);
      case P_T: break;
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
  static Vec3 direction(const std::array<Vec3, 4>& x) {
    using enum EdgeEdgeType;
    const auto& [a0, a1, b0, b1] = x;
    switch (edge_edge_type(a0, a1, b0, b1)) {
      case EA0_EB0: return a0 - b0;
      case EA0_EB1: return a0 - b1;
      case EA1_EB0: return a1 - b0;
      case EA1_EB1: return a1 - b1;
      case EA_EB0: return -line_to_point(b0, a0, a1);
      case EA_EB1: return -line_to_point(b1, a0, a1);
      case EA0_EB: return line_to_point(a0, b0, b1);
      case EA1_EB: return line_to_point(a1, b0, b1);
      case EA_EB: break;
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

// Differences of all vertex pairs: position at the start and motion, relative so that large coordinates and common
// motion drop out.
template <typename Kind>
struct Motion {
  static constexpr int kCount = Kind::kA + Kind::kB, kPairs = Kind::kA * Kind::kB;
  using Stencil = std::array<Vec3, kCount>;

  Stencil start, motion;                      // relative to the last vertex
  std::array<Vec3, kPairs> pair_start, pair_motion;
  double error = 0.0;                         // bound of the rounding error of a gap [m]

  Motion(const Stencil& x0, const Stencil& x1) {
    for (int k = 0; k < kCount; ++k) {
      start[k] = x0[k] - x0[kCount - 1];
      motion[k] = (x1[k] - x0[k]) - (x1[kCount - 1] - x0[kCount - 1]);
    }
    double size = 0.0;
    for (int i = 0; i < Kind::kA; ++i) {
      for (int j = 0; j < Kind::kB; ++j) {
        const int a = i, b = Kind::kA + j, k = i * Kind::kB + j;
        pair_start[k] = x0[a] - x0[b];
        pair_motion[k] = (x1[a] - x0[a]) - (x1[b] - x0[b]);
        size = std::max(size, norm1(pair_start[k]) + norm1(x1[a] - x0[a]) + norm1(x1[b] - x0[b]));
      }
    }
    error = kGapError * size;
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

// The segments of motion stay apart by more than `separation` along a coordinate axis.
template <typename Kind>
bool boxes_stay_apart(const std::array<Vec3, Kind::kA + Kind::kB>& x0, const std::array<Vec3, Kind::kA + Kind::kB>& x1,
                      double separation) {
  const auto extend = [](Vec3& low, Vec3& high, const Vec3& p) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  };
  constexpr int kCount = Kind::kA + Kind::kB;
  Vec3 low_a = x0[0], high_a = x0[0], low_b = x0[Kind::kA], high_b = x0[Kind::kA];
  for (int k = 1; k < Kind::kA; ++k) extend(low_a, high_a, x0[k]);
  for (int k = Kind::kA + 1; k < kCount; ++k) extend(low_b, high_b, x0[k]);
  for (int k = 0; k < Kind::kA; ++k) extend(low_a, high_a, x1[k]);
  for (int k = Kind::kA; k < kCount; ++k) extend(low_b, high_b, x1[k]);
  // A difference is rounded once; a zero separation still needs a strictly positive gap.
  const double gap = std::max({low_a.x - high_b.x, low_b.x - high_a.x, low_a.y - high_b.y, low_b.y - high_a.y,
                               low_a.z - high_b.z, low_b.z - high_a.z});
  return gap > separation * (1.0 + 1e-14);
}

template <typename Kind>
double advance(const std::array<Vec3, Kind::kA + Kind::kB>& x0, const std::array<Vec3, Kind::kA + Kind::kB>& x1,
               double min_separation, const CcdSettings& settings) {
  const Motion<Kind> motion(x0, x1);
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
  const double separation = std::min(min_separation, 0.1 * gap);
  const double stop = separation + settings.tolerance * (gap - separation);
  const double keep = 1.0 - settings.time_margin;
  double t = 0.0;
  for (int iteration = 0; iteration < settings.max_iterations; ++iteration) {
    if (iteration > 0) {
      n = unit_or_zero(Kind::direction(motion.at(t)));
      if (!(motion.gaps(n, t, gaps) > stop)) return keep * t;
    }
    double step = HUGE_VAL;
    for (int k = 0; k < Motion<Kind>::kPairs; ++k) {
      const double rate = dot(n, motion.pair_motion[k]);
      if (rate < 0.0) step = std::min(step, (gaps[k] - separation) / -rate);
    }
    if (t + step >= 1.0) return 1.0;
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

namespace {

struct Limit {
  double step = 1.0;
  int64_t candidate = -1;
  int64_t tested = 0;
};

// Candidates per unit of parallel work; fixed, so that the result does not depend on the threads.
constexpr int64_t kGrain = 1024;

// Smallest step over candidates [0, count): vertices(k) lists the stencil, separation(k) the pair's minimum.
template <typename Kind, typename Vertices, typename Separation>
Limit find_limit(int64_t count, std::span<const Vec3> x0, std::span<const Vec3> x1, Vertices&& vertices,
                 Separation&& separation, const CcdSettings& settings, ThreadPool& pool, std::vector<Limit>& chunks) {
  constexpr int kCount = Kind::kA + Kind::kB;
  chunks.assign((count + kGrain - 1) / kGrain, Limit{});
  pool.for_each_range(count, kGrain, [&](int64_t begin, int64_t end) {
    Limit limit;
    for (int64_t k = begin; k < end; ++k) {
      const std::array<int32_t, kCount> ids = vertices(k);
      std::array<Vec3, kCount> start, finish;
      for (int i = 0; i < kCount; ++i) {
        start[i] = x0[ids[i]];
        finish[i] = x1[ids[i]];
      }
      const double minimum = separation(k);
      if (boxes_stay_apart<Kind>(start, finish, minimum)) continue;
      ++limit.tested;
      const double step = advance<Kind>(start, finish, minimum, settings);
      if (step < limit.step) {
        limit.step = step;
        limit.candidate = k;
      }
    }
    chunks[begin / kGrain] = limit;
  });
  Limit total;
  for (const Limit& limit : chunks) {
    total.tested += limit.tested;
    if (limit.step < total.step) {
      total.step = limit.step;
      total.candidate = limit.candidate;
    }
  }
  return total;
}

// Separation by a functor of the two groups; see the public overloads.
template <typename Separation>
double find_step(const SurfaceMesh& mesh, const CandidateList& list, std::span<const Vec3> x0, std::span<const Vec3> x1,
                 Separation&& separation, ThreadPool& pool, CcdReport* out_report, const CcdSettings& settings) {
  if (x0.size() < static_cast<size_t>(mesh.vertex_count) || x1.size() < static_cast<size_t>(mesh.vertex_count)) {
    throw InvalidArgument("max_safe_step: " + std::to_string(std::min(x0.size(), x1.size())) + " positions for " +
                          std::to_string(mesh.vertex_count) + " vertices; give one each");
  }
  std::vector<Limit> chunks;
  CcdReport report;
  const auto consider = [&](CandidateKind kind, const Limit& limit, auto&& ids) {
    report.tested += limit.tested;
    if (limit.candidate < 0 || !(limit.step < report.step)) return;
    report.step = limit.step;
    report.kind = kind;
    report.candidate = limit.candidate;
    const auto& [first, second] = ids(limit.candidate);
    report.first = first;
    report.second = second;
  };
  const auto& edges = mesh.edges;
  {
    const auto& pairs = list.point_triangle;
    consider(CandidateKind::PointTriangle,
             find_limit<PointTriangle>(
                 static_cast<int64_t>(pairs.size()), x0, x1,
                 [&](int64_t k) {
                   const Index3& t = mesh.triangles[pairs[k].triangle];
                   return Index4{pairs[k].point, t[0], t[1], t[2]};
                 },
                 [&](int64_t k) {
                   return separation(mesh.vertex_group[pairs[k].point], mesh.triangle_group[pairs[k].triangle]);
                 },
                 settings, pool, chunks),
             [&](int64_t k) { return pairs[k]; });
  }
  {
    const auto& pairs = list.edge_edge;
    consider(CandidateKind::EdgeEdge,
             find_limit<EdgeEdge>(
                 static_cast<int64_t>(pairs.size()), x0, x1,
                 [&](int64_t k) {
                   const Index2 &a = edges[pairs[k].edge_a], &b = edges[pairs[k].edge_b];
                   return Index4{a[0], a[1], b[0], b[1]};
                 },
                 [&](int64_t k) {
                   return separation(mesh.edge_group[pairs[k].edge_a], mesh.edge_group[pairs[k].edge_b]);
                 },
                 settings, pool, chunks),
             [&](int64_t k) { return pairs[k]; });
  }
  {
    const auto& pairs = list.point_edge;
    consider(CandidateKind::PointEdge,
             find_limit<PointEdge>(
                 static_cast<int64_t>(pairs.size()), x0, x1,
                 [&](int64_t k) {
                   return Index3{pairs[k].point, edges[pairs[k].edge][0], edges[pairs[k].edge][1]};
                 },
                 [&](int64_t k) {
                   return separation(mesh.vertex_group[pairs[k].point], mesh.edge_group[pairs[k].edge]);
                 },
                 settings, pool, chunks),
             [&](int64_t k) { return pairs[k]; });
  }
  {
    const auto& pairs = list.point_point;
    consider(CandidateKind::PointPoint,
             find_limit<PointPoint>(
                 static_cast<int64_t>(pairs.size()), x0, x1,
                 [&](int64_t k) { return Index2{pairs[k].point_a, pairs[k].point_b}; },
                 [&](int64_t k) {
                   return separation(mesh.vertex_group[pairs[k].point_a], mesh.vertex_group[pairs[k].point_b]);
                 },
                 settings, pool, chunks),
             [&](int64_t k) { return pairs[k]; });
  }
  if (out_report != nullptr) *out_report = report;
  return report.step;
}

}  // namespace

double max_safe_step(const SurfaceMesh& mesh, const CandidateList& candidates, std::span<const Vec3> x0,
                     std::span<const Vec3> x1, double min_separation, ThreadPool& pool, CcdReport* out_report,
                     const CcdSettings& settings) {
  return find_step(mesh, candidates, x0, x1, [&](int32_t, int32_t) { return min_separation; }, pool, out_report,
                   settings);
}

double max_safe_step(const SurfaceMesh& mesh, const CandidateList& candidates, std::span<const Vec3> x0,
                     std::span<const Vec3> x1, std::span<const double> group_separation, ThreadPool& pool,
                     CcdReport* out_report, const CcdSettings& settings) {
  return find_step(mesh, candidates, x0, x1,
                   [&](int32_t a, int32_t b) { return group_separation[a] + group_separation[b]; }, pool, out_report,
                   settings);
}

}  // namespace stark
