// One level of the multilevel method: pairs of nodes joined by heavy edges become one node (Karypis and Kumar
// 1998). Phase: ordering of the linear solver.
#pragma once

#include <cstdint>
#include <vector>

#include <stark/linalg/vertex_separator.h>

namespace stark {

/// A fixed sequence of pseudo-random numbers, the same on every platform.
class PseudoRandom {
 public:
  int32_t below(int32_t limit) {
    state_ = state_ * 6364136223846793005ull + 1442695040888963407ull;
    return static_cast<int32_t>((state_ >> 33) % static_cast<uint64_t>(limit));
  }

 private:
  uint64_t state_ = 0x853c49e6748fea9bull;
};

/// match[i] is the partner of node i, or i if it stays alone. Partners weigh at most `weight_limit` together.
void match_heavy_edges(const WeightedGraph& graph, int32_t weight_limit, PseudoRandom& random,
                       std::vector<int32_t>& match);

/// Graph of the pairs: weights are summed, edges inside a pair vanish. coarse_of[i] is the coarse node of i.
void contract(const WeightedGraph& fine, const std::vector<int32_t>& match, WeightedGraph& coarse,
              std::vector<int32_t>& coarse_of);

}  // namespace stark
