#include <stark/mechanics/force_rounding.h>

#include <cmath>
#include <limits>

namespace stark {

namespace {

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();

}  // namespace

std::vector<double> force_rounding(const BlockMatrix& hessian, std::span<const Vec3> block_positions,
                                   const DofLayout& layout) {
  std::vector<double> known(block_positions.size());
  for (size_t b = 0; b < known.size(); ++b) known[b] = kEpsilon * norm(block_positions[b]);
  for (const int32_t block : layout.rotation_block)
    if (block != kNoBlock) known[block] = kEpsilon;
  std::vector<double> noise(known.size(), 0.0);
  const BlockPattern& pattern = hessian.pattern;
  for (int32_t i = 0; i < pattern.block_count; ++i)
    for (int64_t slot = pattern.row_start[i]; slot < pattern.row_start[i + 1]; ++slot) {
      double squared = 0.0;
      for (int k = 0; k < 9; ++k) squared += hessian.values[9 * slot + k] * hessian.values[9 * slot + k];
      const int32_t j = pattern.column[slot];
      noise[i] += std::sqrt(squared) * known[j];
      if (j != i) noise[j] += std::sqrt(squared) * known[i];
    }
  return noise;
}

}  // namespace stark
