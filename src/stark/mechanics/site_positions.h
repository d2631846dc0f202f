// Positions of all sites together with what is known not to have changed in them: terrain has far more sites
// than what moves on it, and need not be compared or copied again and again.
#pragma once

#include <concepts>
#include <cstdint>
#include <span>
#include <vector>

#include <stark/base/math.h>

namespace stark {

/// Sites [begin, end).
struct SiteRange {
  int32_t begin = 0, end = 0;
};

struct SitePositions {
  SitePositions(std::span<const Vec3> x) : all(x) {}
  SitePositions(const std::vector<Vec3>& x) : all(x) {}
  SitePositions(std::span<const Vec3> x, std::span<const SiteRange> moving_ranges, uint64_t still_number)
      : all(x), moving(moving_ranges), still(still_number) {}

  std::span<const Vec3> all;  ///< [m]
  /// Sites beyond these have the same positions wherever `still` is the same; nothing is known where it is 0.
  std::span<const SiteRange> moving{};
  uint64_t still = 0;
};

}  // namespace stark
