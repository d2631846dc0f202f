// Chain rule for embedded sites, which follow 8 or 27 points (step phase 4e). Elements add their blocks to
// pairs of sites first, whatever the number of contacts a pair is in. All pairs of the same two cells are
// then summed in a small dense matrix of the points of these cells, which goes to the system once:
//     H_ab += w_ka w_lb H_kl   for all points a of site k and b of site l. [theory eq. 6a]
#pragma once

#include <cstdint>
#include <unordered_map>
#include <utility>
#include <vector>

#include <stark/linalg/block_matrix.h>
#include <stark/mechanics/kinematic_map.h>

namespace stark {

/// Hessian blocks of pairs of sites of which at least one is embedded. Sums and their order depend on the
/// order of the elements only.
class SitePairs {
 public:
  /// Adds the block of the sites p and q, in this order; that of q and p, its transpose, is not added.
  void add(int32_t p, int32_t q, const Mat3& H);
  /// Adds all pairs to the matrix and forgets them.
  void scatter(const KinematicMap& map, const Configuration& configuration, BlockMatrix& hessian);
  bool empty() const { return pairs_.empty(); }

 private:
  struct Pair {
    int32_t p, q;
    Mat3 H;
  };
  std::vector<Pair> pairs_;
  std::unordered_map<uint64_t, size_t> places_;
};

/// Pairs of blocks that embedded sites couple, gathered by supports: sites in one cell share theirs.
class SupportPairs {
 public:
  explicit SupportPairs(const KinematicMap& map) : map_(map) {}
  /// Takes the sites of a stencil; those that are not embedded by their blocks.
  void add(std::span<const int32_t> stencil);
  /// Appends (low, high) block pairs.
  void append_to(std::vector<std::pair<int32_t, int32_t>>& out);

 private:
  /// Blocks first, supports behind them.
  std::span<const int32_t> blocks_of(int32_t group, int32_t& storage) const;

  const KinematicMap& map_;
  std::vector<std::pair<int32_t, int32_t>> groups_;
  std::vector<int32_t> of_stencil_, blocks_;
};

}  // namespace stark
