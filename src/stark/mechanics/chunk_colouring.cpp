// See chunk_colouring.h.
#include <stark/mechanics/chunk_colouring.h>

#include <algorithm>
#include <bit>

namespace stark {

std::vector<std::vector<Chunk>> colour_chunks(const KinematicMap& map, std::span<const int32_t> stencils,
                                              int nodes, int64_t chunk_elements) {
  std::vector<std::vector<Chunk>> colours;
  // Bit c of a block says that a chunk of colour c touches it.
  std::vector<uint64_t> used(map.layout().block_count, 0);
  const int64_t count = static_cast<int64_t>(stencils.size()) / nodes;
  for (int64_t first = 0; first < count; first += chunk_elements) {
    const Chunk chunk{first, std::min(first + chunk_elements, count)};
    const auto sites = stencils.subspan(chunk.first * nodes, (chunk.last - chunk.first) * nodes);
    uint64_t taken = 0;
    for (const int32_t site : sites)
      if (const int32_t block = map.point_block(site); block != kNoBlock) taken |= used[block];
    size_t colour = static_cast<size_t>(std::countr_one(taken));
    if (colour < 64) {
      for (const int32_t site : sites)
        if (const int32_t block = map.point_block(site); block != kNoBlock)
          used[block] |= uint64_t{1} << colour;
    } else {
      colour = std::max<size_t>(64, colours.size());  // a colour of its own
    }
    if (colours.size() <= colour) colours.resize(colour + 1);
    colours[colour].push_back(chunk);
  }
  return colours;
}

}  // namespace stark
