#include <stark/linalg/screening_length.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace stark {

double find_screening_length(const BlockMatrix& matrix) {
  const BlockPattern& pattern = matrix.pattern;
  if (pattern.block_count == 0) return 0.0;
  const auto trace = [&](int64_t slot) {
    const double* a = matrix.values.data() + 9 * slot;
    return a[0] + a[4] + a[8];
  };
  std::vector<double> share(pattern.block_count, 0.0);
  for (int32_t i = 0; i < pattern.block_count; ++i) {
    for (int64_t slot = pattern.row_start[i]; slot < pattern.row_start[i + 1]; ++slot) {
      share[i] += trace(slot);
      if (pattern.column[slot] != i) share[pattern.column[slot]] += trace(slot);
    }
  }
  for (int32_t i = 0; i < pattern.block_count; ++i) share[i] /= trace(pattern.row_start[i]);
  const auto middle = share.begin() + pattern.block_count / 2;
  std::nth_element(share.begin(), middle, share.end());
  return *middle > 0.0 ? 1.0 / std::sqrt(*middle) : INFINITY;
}

}  // namespace stark
