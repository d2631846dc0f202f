// Sums of vectors by site. What pushes few sites of a fine mesh costs as much as those few: only parts that
// something is added to are looked at and cleared again.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include <stark/base/math.h>

namespace stark {

class SiteSums {
 public:
  /// Zeros for `count` sites.
  void begin(size_t count) {
    if (values_.size() != count) {
      values_.assign(count, Vec3{});
      used_.assign((count + kPart - 1) / kPart, 0);
      return;
    }
    for_each_part([&](size_t first, size_t last) {
      std::fill(values_.begin() + first, values_.begin() + last, Vec3{});
    });
    std::ranges::fill(used_, 0);
  }

  /// These may be added to.
  void use(std::span<const int32_t> sites) {
    for (const int32_t site : sites) used_[site / kPart] = 1;
  }

  /// By site; zero where none is used.
  std::span<Vec3> values() { return values_; }

  /// Calls body(site, sum) for all sites that are used, and for some beside them, in ascending order.
  template <typename Body>
  void for_each(Body&& body) const {
    for_each_part([&](size_t first, size_t last) {
      for (size_t i = first; i < last; ++i) body(static_cast<int32_t>(i), values_[i]);
    });
  }

 private:
  static constexpr size_t kPart = 512;

  template <typename Body>
  void for_each_part(Body&& body) const {
    for (size_t part = 0; part < used_.size(); ++part)
      if (used_[part] != 0) body(kPart * part, std::min(kPart * (part + 1), values_.size()));
  }

  std::vector<Vec3> values_;
  std::vector<uint8_t> used_;  ///< by part
};

}  // namespace stark
