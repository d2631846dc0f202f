#include <stark/collision/distant_pairs.h>

#include <stark/collision/four_pairs.h>

namespace stark {

namespace {

constexpr int64_t kCandidatesPerTask = 2048;

// Marks the pairs to keep: an axis separates most of the others, and distances decide about the rest.
template <PairKind kind, typename Reach>
void mark_near(const SurfaceMesh& mesh, std::span<const PrimitivePair> pairs, const Reach& reach,
               std::span<const Vec3> x, ThreadPool& pool, std::vector<uint8_t>& out) {
  out.assign(pairs.size(), 0);
  pool.for_each_range(
      static_cast<int64_t>(pairs.size()), kCandidatesPerTask, [&](int64_t begin, int64_t end) {
        for (int64_t first = begin; first < end; first += detail::kPairs) {
          const detail::FourPairs<kind> four(mesh, pairs, first, end, reach);
          for (int open = four.find_open(std::array{x}); open != 0; open &= open - 1) {
            const int lane = __builtin_ctz(static_cast<unsigned>(open));
            typename PairRow<kind>::Positions at;
            for (size_t i = 0; i < at.size(); ++i) at[i] = x[four.ids[lane][i]];
            out[first + lane] = PairRow<kind>::squared_distance(at) <= four.limit[lane] * four.limit[lane];
          }
        }
      });
}

}  // namespace

void remove_distant(const SurfaceMesh& mesh, std::span<const double> group_reach, std::span<const Vec3> x,
                    ThreadPool& pool, CandidateList& candidates) {
  const auto reach = [&](int32_t a, int32_t b) { return group_reach[a] + group_reach[b]; };
  std::vector<uint8_t> is_near;
  for_each_pair_kind([&](auto kind) {
    std::vector<PrimitivePair>& pairs = candidates[kind];
    mark_near<kind.value>(mesh, pairs, reach, x, pool, is_near);
    size_t count = 0;
    for (size_t i = 0; i < pairs.size(); ++i)
      if (is_near[i]) pairs[count++] = pairs[i];
    pairs.resize(count);
  });
}

}  // namespace stark
