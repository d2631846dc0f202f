// Comparison of friction limits before and after a refresh (step phase 2). [theory eq. 20a]
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <stark/contact/contact_set.h>

namespace stark {

/// Where friction of contacts acts: a pair of edges, or a point that touches a body. A point has one contact
/// with each side of a valley, one that an edge crosses at its end may be of either edge there, and one of
/// two points is of both: contacts of a place share its limit, which goes from one to the other while
/// friction stays what it is.
struct FrictionPlace {
  PairKey key;         ///< of a point: PairKey::kOther and the point
  int64_t bodies = 0;  ///< group_code()
  auto operator<=>(const FrictionPlace&) const = default;
};
/// Limit of friction of a contact.
struct FrictionLimit {
  FrictionPlace place;
  std::optional<FrictionPlace> other;  ///< another name of the place, of two points
  Vec3 normal;         ///< unit, to the first of two bodies; of one body: to the side of the point
  double limit = 0.0;  ///< mu lambda [N]
};
/// normal: unit, to side A.
FrictionLimit limit_of(const Contact& contact, const Vec3& normal, double limit);

/// Largest change of a limit and largest limit after it [N].
struct LimitChange {
  double largest_change = 0.0, largest_limit = 0.0;
};

/// Limits after a refresh that goes a share of the way from what each place had before to what it has now, in
/// the order of `now`: half of it to the mean. Places that are new keep theirs.
std::vector<double> damped_limits(const std::vector<FrictionLimit>& before,
                                  const std::vector<FrictionLimit>& now, double share = 0.5);

/// Which share of the way the refreshes of a step go.
class RefreshShares {
 public:
  void begin_step() { *this = {}; }
  /// After the first ones, which go all of it, half: limits that go back and forth meet in the middle. Where
  /// all of them go on in the same way instead, as those of a wedge do that friction presses harder, what the
  /// rest of the refreshes would add is foreseen from the last two [theory eq. 20f].
  double next(const std::vector<FrictionLimit>& before, const std::vector<FrictionLimit>& now, bool is_first);

 private:
  struct Change {
    FrictionPlace place;
    int side = 0;
    double change = 0.0;  ///< [N]
  };
  std::vector<Change> last_;  ///< in the order of their places
  double share_ = 1.0;
};

/// Limits before and after a refresh, compared place by place, and side by side of each place.
class LimitComparison {
 public:
  LimitComparison(const std::vector<FrictionLimit>& before, const std::vector<FrictionLimit>& now);

  LimitChange total() const { return total_; }
  /// Whether limits have settled, of all and between each two bodies.
  bool is_settled() const { return !unsettled(); }
  /// Those of all, or between two bodies, that have not.
  std::optional<LimitChange> unsettled() const;

 private:
  LimitChange total_;
  std::vector<LimitChange> bodies_;  ///< between each two; limits before the refresh, too
};

}  // namespace stark
