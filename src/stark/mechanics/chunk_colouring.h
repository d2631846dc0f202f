// Chunks of elements that may be assembled at the same time: those of one colour share no block of unknowns,
// hence no atomics and one order of sums whatever the number of threads.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <stark/mechanics/kinematic_map.h>

namespace stark {

/// Elements [first, last).
struct Chunk {
  int64_t first, last;
};

/// Greedy colouring of consecutive chunks; stencils is [element_count][nodes] point sites.
std::vector<std::vector<Chunk>> colour_chunks(const KinematicMap& map, std::span<const int32_t> stencils,
                                              int nodes, int64_t chunk_elements);

}  // namespace stark
