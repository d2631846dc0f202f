// Comparison of friction limits before and after a refresh (step phase 2). [theory eq. 20a]
#pragma once

#include <cstdint>
#include <vector>

#include <stark/contact/contact_set.h>

namespace stark {

/// Limit of friction of a contact.
struct FrictionLimit {
  PairKey key;
  int32_t group_a = 0, group_b = 0;
  Vec3 normal;         ///< unit, to side A
  double limit = 0.0;  ///< mu lambda [N]
};

/// Largest change of a limit and largest limit after it [N].
struct LimitChange {
  double largest_change = 0.0, largest_limit = 0.0;
};

/// Limits before and after a refresh, compared place by place. A place is a pair of edges, or one side of a
/// point that touches a body there: above a valley the contact of a point splits into one for each side of
/// the valley, which share the limit, and joins again, while the friction stays what it is.
class LimitComparison {
 public:
  LimitComparison(const std::vector<FrictionLimit>& before, const std::vector<FrictionLimit>& now);

  LimitChange total() const { return total_; }
  /// Whether limits have settled, of all and between each two bodies.
  bool is_settled() const;

 private:
  struct OfBodies {
    double change = 0.0, limit = 0.0;  ///< largest; limits before the refresh and after it [N]
  };
  LimitChange total_;
  std::vector<OfBodies> bodies_;
};

}  // namespace stark
