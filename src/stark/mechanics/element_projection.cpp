// See element_projection.h.
#include <stark/mechanics/element_projection.h>

#include <bit>

#include <stark/base/psd.h>

namespace stark {

using symbolic::kLanes;

int64_t project_blocks(const Potential& potential, int64_t block_count, double* out) {
  const int n = potential.kernel().unknown_count();
  const int outputs = potential.kernel().output_count(symbolic::Order::Hessian);
  const bool reduced =
      potential.is_translation_invariant() && n >= 6 && n <= 12;  // fewer dimensions, same result
  int64_t count = 0;
  for (int64_t block = 0; block < block_count; ++block) {
    double* upper = out + (block * outputs + 1 + n) * kLanes;
    if (const uint32_t mask = psd_test(upper, n); mask != 0) {
      psd_project(upper, n, mask, reduced);
      count += std::popcount(mask);
    }
  }
  return count;
}

}  // namespace stark
