#include <stark/mechanics/force_rounding.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace stark {

namespace {

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();

/// Frobenius norm of a block.
double norm_of_block(const BlockMatrix& hessian, int64_t slot) {
  double squared = 0.0;
  for (int k = 0; k < 9; ++k) squared += hessian.values[9 * slot + k] * hessian.values[9 * slot + k];
  return std::sqrt(squared);
}

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
      const double size = norm_of_block(hessian, slot);
      const int32_t j = pattern.column[slot];
      noise[i] += size * known[j];
      if (j != i) noise[j] += size * known[i];
    }
  return noise;
}

double energy_rounding(const BlockMatrix& hessian, std::span<const Vec3> block_positions,
                       const DofLayout& layout) {
  const BlockPattern& pattern = hessian.pattern;
  std::vector<char> is_point(static_cast<size_t>(pattern.block_count), 0);
  for (const int32_t block : layout.point_block)
    if (block != kNoBlock) is_point[block] = 1;
  double noise = 0.0;
  for (int32_t i = 0; i < pattern.block_count; ++i)
    for (int64_t slot = pattern.row_start[i]; slot < pattern.row_start[i + 1]; ++slot) {
      const int32_t j = pattern.column[slot];
      if (j == i || !is_point[i] || !is_point[j]) continue;
      const double size = norm(block_positions[i] - block_positions[j]);
      const double known = std::max(norm(block_positions[i]), norm(block_positions[j]));
      noise += norm_of_block(hessian, slot) * size * (size + known);
    }
  return kEpsilon * noise;
}

}  // namespace stark
