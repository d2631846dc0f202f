// Sums of element gradients and Hessians into those of the system, straight from the lanes in which the
// kernels leave them (step phase 4e). For elements of points, whose map is the identity.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <stark/linalg/block_matrix.h>
#include <stark/mechanics/kinematic_map.h>

namespace stark {

/// Where the block of two nodes goes: twice the slot in the pattern, plus one where it is transposed, because
/// the pattern holds the upper triangle only; -1 where a node is prescribed.
using PairPlace = int32_t;

/// Places of all pairs of nodes p <= q of every element: [element][pair], row by row of the upper triangle.
std::vector<PairPlace> find_pair_places(const KinematicMap& map, std::span<const int32_t> stencils, int nodes,
                                        const BlockPattern& pattern);

/// Block of every node of every element: [element][node], kNoBlock where a node is prescribed.
std::vector<int32_t> find_node_blocks(const KinematicMap& map, std::span<const int32_t> stencils);

/// Which pairs of nodes are added: all, or each node with itself.
enum class ScatterPairs : uint8_t { All, Diagonal };

/// Adds the gradients of the first `lane_count` lanes of a block. `lanes` is [3 nodes][kLanes]; `blocks`
/// those of the nodes of the first lane's element; `padded` is [block][4], of which the last number stays.
void scatter_gradients(const double* lanes, int nodes, int64_t lane_count, const int32_t* blocks,
                       double* padded);

/// Adds the Hessians of the first `lane_count` lanes of a block. `upper` is [n(n+1)/2][kLanes], n = 3 nodes;
/// `places` those of the pairs of the first lane's element; `slot_of` maps slots of the places to those of
/// `matrix`.
void scatter_hessians(const double* upper, int nodes, int64_t lane_count, const PairPlace* places,
                      std::span<const int64_t> slot_of, BlockMatrix& matrix,
                      ScatterPairs pairs = ScatterPairs::All);

}  // namespace stark
