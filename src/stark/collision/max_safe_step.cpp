// Smallest safe step over a candidate list: four pairs at a time are tested for an axis that separates them
// on the whole motion, the rest go through conservative advancement. See max_safe_step.h.
#include <algorithm>
#include <cmath>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include <stark/base/error.h>
#include <stark/collision/four_pairs.h>
#include <stark/collision/max_safe_step.h>

namespace stark {

namespace {

using detail::kPairs;

struct Limit {
  double step = 1.0;
  int64_t candidate = -1;
  int64_t tested = 0;
};

// Gap above a separation, over it, from which a pair with a core has come to it: its barrier is next to what
// it is at the separation.
constexpr double kArrived = 1e-5;

// Candidates per unit of parallel work; fixed, so that the result does not depend on the threads.
constexpr int64_t kGrain = 1024;

// Sharper iterations of pairs with a core: they rest hardly above their separation.
constexpr int kCoreIterations = 128;

// What a pair at x keeps: its separation, or, with a core, what is left of it.
struct Kept {
  double separation;
  int sharper_iterations = 0;
};

template <PairKind kind, typename Separation>
Kept kept(const SurfaceMesh& mesh, const PrimitivePair& pair, const typename PairRow<kind>::Positions& x,
          double from_afar, const Separation& separation) {
  if constexpr (std::is_same_v<std::remove_cvref_t<Separation>, Separations>) {
    if (separation.core.empty()) return {from_afar};
    const PrimitivePair groups = PairRow<kind>::groups(mesh, pair);
    if (!separation.is_core(groups.first, groups.second)) return {from_afar};
    const bool has_come = std::sqrt(PairRow<kind>::squared_distance(x)) < (1.0 + kArrived) * from_afar;
    return {has_come ? separation.core_part * from_afar : from_afar, kCoreIterations};
  } else {
    return {from_afar};
  }
}

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
    for (int64_t first = begin; first < end; first += kPairs) {
      const detail::FourPairs<kind> four(mesh, pairs, first, end, separation);
      int open = four.find_open(std::array{x0, x1});
      for (; open != 0; open &= open - 1) {
        const int lane = __builtin_ctz(static_cast<unsigned>(open));
        std::array<Vec3, kCount> a, b;
        for (int i = 0; i < kCount; ++i) {
          a[i] = x0[four.ids[lane][i]];
          b[i] = x1[four.ids[lane][i]];
        }
        ++limit.tested;
        const Kept near = kept<kind>(mesh, pairs[first + lane], a, four.limit[lane], separation);
        bounded.sharper_iterations = near.sharper_iterations;
        const double step = Row::kCcd(a, b, near.separation, bounded);
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

bool Separations::is_core(int32_t group_a, int32_t group_b) const {
  return !core.empty() && core[group_a] + core[group_b] > 0.0;
}

double max_safe_step(const SurfaceMesh& mesh, const CandidateList& candidates, std::span<const Vec3> x0,
                     std::span<const Vec3> x1, const Separations& separations, ThreadPool& pool,
                     CcdReport* out_report, const CcdSettings& settings) {
  return find_step(mesh, candidates, x0, x1, separations, pool, out_report, settings);
}

}  // namespace stark
