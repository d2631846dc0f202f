// Chunks of elements that may be assembled at the same time: those of one colour share no block of unknowns,
// hence no atomics and one order of sums whatever the number of threads.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <stark/linalg/block_matrix.h>
#include <stark/mechanics/kinematic_map.h>

namespace stark {

/// Elements [first, last).
struct Chunk {
  int64_t first, last;
};

/// Greedy colouring of consecutive chunks; stencils is [element_count][nodes] point sites.
std::vector<std::vector<Chunk>> colour_chunks(const KinematicMap& map, std::span<const int32_t> stencils,
                                              int nodes, int64_t chunk_elements);

/// Slot of every pair of nodes p <= q of every element in the pattern, -1 where one of them is prescribed.
std::vector<int32_t> pair_slots(const KinematicMap& map, std::span<const int32_t> stencils, int nodes,
                                const BlockPattern& pattern);

}  // namespace stark
