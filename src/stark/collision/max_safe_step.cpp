// Smallest safe step over a candidate list: four pairs at a time are tested for an axis that separates them
// on the whole motion, the rest go through conservative advancement. See max_safe_step.h.
#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include <stark/base/error.h>
#include <stark/collision/max_safe_step.h>

namespace stark {

namespace {

constexpr int kLanes = 4;
using Double4 = double __attribute__((vector_size(32)));
using Long4 = int64_t __attribute__((vector_size(32)));

struct Vec3x4 {
  Double4 x, y, z;
};

Vec3x4 operator+(const Vec3x4& a, const Vec3x4& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
Vec3x4 operator-(const Vec3x4& a, const Vec3x4& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
Double4 dot(const Vec3x4& a, const Vec3x4& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
Vec3x4 cross(const Vec3x4& a, const Vec3x4& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
Double4 min(const Double4& a, const Double4& b) { return a < b ? a : b; }
Double4 max(const Double4& a, const Double4& b) { return a > b ? a : b; }
Double4 abs(const Double4& a) { return max(a, -a); }

int lane_mask(const Long4& lanes) {
#if defined(__AVX__)
  return __builtin_ia32_movmskpd256(reinterpret_cast<Double4>(lanes));
#else
  int mask = 0;
  for (int k = 0; k < kLanes; ++k) mask |= static_cast<int>(lanes[k] & 1) << k;
  return mask;
#endif
}

// A direction that may separate the primitives, besides the coordinate axes and the line of centres: the
// normal of a triangle, or the common normal of two edges.
template <PairKind kind, size_t count, typename Test>
void try_normal(const Vec3x4 (&x)[count], Test&& test) {
  if constexpr (kind == PairKind::PointTriangle) test(cross(x[2] - x[1], x[3] - x[1]));
  if constexpr (kind == PairKind::EdgeEdge) test(cross(x[1] - x[0], x[3] - x[2]));
}

// Rounding errors of a projected gap relative to the size of the differences, as in ccd.cpp.
constexpr double kGapError = 32.0 * 0x1p-53;

// Lanes whose primitives one axis keeps apart by more than the separation at both ends of the motion, hence,
// gaps of vertex pairs along an axis being linear in time, on all of it.
template <PairKind kind, size_t kCount>
int find_separated(const Vec3x4 (&x0)[kCount], const Vec3x4 (&x1)[kCount], const Double4& separation) {
  constexpr int kA = PairRow<kind>::kFirstCount, kB = PairRow<kind>::kSecondCount, kGaps = 2 * kA * kB;
  Vec3x4 gaps[kGaps];
  for (int i = 0; i < kA; ++i) {
    for (int j = 0; j < kB; ++j) {
      gaps[2 * (i * kB + j)] = x0[i] - x0[kA + j];
      gaps[2 * (i * kB + j) + 1] = x1[i] - x1[kA + j];
    }
  }
  Vec3x4 low = gaps[0], high = gaps[0];
  for (int k = 1; k < kGaps; ++k) {
    low = {min(low.x, gaps[k].x), min(low.y, gaps[k].y), min(low.z, gaps[k].z)};
    high = {max(high.x, gaps[k].x), max(high.y, gaps[k].y), max(high.z, gaps[k].z)};
  }
  const Double4 size =
      max(abs(low.x), abs(high.x)) + max(abs(low.y), abs(high.y)) + max(abs(low.z), abs(high.z));
  const Double4 margin = separation + 2.0 * kGapError * size;
  Long4 separated = (low.x > margin) | (low.y > margin) | (low.z > margin) | (-high.x > margin) |
                    (-high.y > margin) | (-high.z > margin);
  // Comparisons drop numbers that are not finite; the sum of all gaps does not.
  Vec3x4 centre = gaps[0];
  for (int k = 1; k < kGaps; ++k) centre = centre + gaps[k];
  const Long4 finite = 0.0 * centre.x + 0.0 * centre.y + 0.0 * centre.z == 0.0;
  separated &= finite;
  if (lane_mask(separated) == (1 << kLanes) - 1) return lane_mask(separated);
  // An axis n of any length: the squares of gap and margin are compared.
  const Double4 margin2 = margin * margin * (1.0 + 1e-12);
  const auto test = [&](const Vec3x4& n) {
    Double4 smallest = dot(n, gaps[0]), largest = smallest;
    for (int k = 1; k < kGaps; ++k) {
      const Double4 gap = dot(n, gaps[k]);
      smallest = min(smallest, gap);
      largest = max(largest, gap);
    }
    const Double4 limit = margin2 * dot(n, n);
    separated |= (smallest > 0.0) & (smallest * smallest > limit);
    separated |= (largest < 0.0) & (largest * largest > limit);
  };
  Vec3x4 middle[kCount];
  for (size_t k = 0; k < kCount; ++k) middle[k] = x0[k] + x1[k];
  test(centre);
  try_normal<kind>(middle, test);
  return lane_mask(separated & finite);
}

Vec3x4 gather(std::span<const Vec3> x, const int32_t (&ids)[kLanes]) {
  const Vec3 &a = x[ids[0]], &b = x[ids[1]], &c = x[ids[2]], &d = x[ids[3]];
  return {Double4{a.x, b.x, c.x, d.x}, Double4{a.y, b.y, c.y, d.y}, Double4{a.z, b.z, c.z, d.z}};
}

struct Limit {
  double step = 1.0;
  int64_t candidate = -1;
  int64_t tested = 0;
};

// Candidates per unit of parallel work; fixed, so that the result does not depend on the threads.
constexpr int64_t kGrain = 1024;

// Smallest step over the pairs of one kind; separation(a, b): what two groups keep.
template <PairKind kind, typename Separation>
Limit find_limit(const SurfaceMesh& mesh, const std::vector<PrimitivePair>& pairs, std::span<const Vec3> x0,
                 std::span<const Vec3> x1, Separation&& separation, const CcdSettings& settings,
                 ThreadPool& pool, std::vector<Limit>& chunks) {
  using Row = PairRow<kind>;
  constexpr int kCount = Row::kFirstCount + Row::kSecondCount;
  const auto count = static_cast<int64_t>(pairs.size());
  chunks.assign((count + kGrain - 1) / kGrain, Limit{});
  const double keep = 1.0 - settings.time_margin;
  pool.for_each_range(count, kGrain, [&](int64_t begin, int64_t end) {
    Limit limit;
    CcdSettings bounded = settings;
    for (int64_t first = begin; first < end; first += kLanes) {
      std::array<int32_t, kCount> ids[kLanes];
      double minimum[kLanes];
      for (int lane = 0; lane < kLanes; ++lane) {
        const PrimitivePair& pair = pairs[std::min(first + lane, end - 1)];
        const PrimitivePair groups = Row::groups(mesh, pair);
        ids[lane] = Row::vertices(mesh, pair);
        minimum[lane] = separation(groups.first, groups.second);
      }
      Vec3x4 start[kCount], finish[kCount];
      for (int i = 0; i < kCount; ++i) {
        const int32_t lanes[kLanes] = {ids[0][i], ids[1][i], ids[2][i], ids[3][i]};
        start[i] = gather(x0, lanes);
        finish[i] = gather(x1, lanes);
      }
      const Double4 minima{minimum[0], minimum[1], minimum[2], minimum[3]};
      int open =
          ~find_separated<kind>(start, finish, minima) & ((1 << std::min<int64_t>(kLanes, end - first)) - 1);
      for (; open != 0; open &= open - 1) {
        const int lane = __builtin_ctz(static_cast<unsigned>(open));
        std::array<Vec3, kCount> a, b;
        for (int i = 0; i < kCount; ++i) {
          a[i] = x0[ids[lane][i]];
          b[i] = x1[ids[lane][i]];
        }
        ++limit.tested;
        const double step = Row::kCcd(a, b, minimum[lane], bounded);
        if (step < limit.step) {
          limit.step = step;
          limit.candidate = first + lane;
          // Later impacts of this range cannot lower the minimum.
          if (keep > 0.0) bounded.horizon = std::min(settings.horizon, step / keep);
        }
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
double find_step(const SurfaceMesh& mesh, const CandidateList& list, std::span<const Vec3> x0,
                 std::span<const Vec3> x1, Separation&& separation, ThreadPool& pool, CcdReport* out_report,
                 const CcdSettings& settings) {
  if (x0.size() < static_cast<size_t>(mesh.vertex_count) ||
      x1.size() < static_cast<size_t>(mesh.vertex_count)) {
    throw InvalidArgument("max_safe_step: " + std::to_string(std::min(x0.size(), x1.size())) +
                          " positions for " + std::to_string(mesh.vertex_count) + " vertices; give one each");
  }
  std::vector<Limit> chunks;
  CcdReport report;
  for_each_pair_kind([&](auto tag) {
    const std::vector<PrimitivePair>& pairs = list[tag];
    const Limit limit = find_limit<tag.value>(mesh, pairs, x0, x1, separation, settings, pool, chunks);
    report.tested += limit.tested;
    if (limit.candidate < 0 || !(limit.step < report.step)) return;
    const PrimitivePair& pair = pairs[limit.candidate];
    report = {limit.step, tag.value, limit.candidate, pair.first, pair.second, report.tested};
  });
  if (out_report != nullptr) *out_report = report;
  return report.step;
}

}  // namespace

double max_safe_step(const SurfaceMesh& mesh, const CandidateList& candidates, std::span<const Vec3> x0,
                     std::span<const Vec3> x1, double min_separation, ThreadPool& pool, CcdReport* out_report,
                     const CcdSettings& settings) {
  return find_step(
      mesh, candidates, x0, x1, [&](int32_t, int32_t) { return min_separation; }, pool, out_report, settings);
}

double Separations::operator()(int32_t group_a, int32_t group_b) const {
  if (!by_pair.empty()) {
    const std::pair<int32_t, int32_t> groups = std::minmax(group_a, group_b);
    const auto found =
        std::ranges::lower_bound(by_pair, groups, {}, [](const Pair& p) { return std::pair(p.low, p.high); });
    if (found != by_pair.end() && std::pair(found->low, found->high) == groups) return found->separation;
  }
  return by_group[group_a] + by_group[group_b];
}

double max_safe_step(const SurfaceMesh& mesh, const CandidateList& candidates, std::span<const Vec3> x0,
                     std::span<const Vec3> x1, const Separations& separations, ThreadPool& pool,
                     CcdReport* out_report, const CcdSettings& settings) {
  return find_step(mesh, candidates, x0, x1, separations, pool, out_report, settings);
}

}  // namespace stark
