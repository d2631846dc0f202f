#include <stark/contact/friction_limits.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

namespace stark {

namespace {

/// Change of the limits below which friction counts as up to date, over the largest one of all.
constexpr double kLimitTolerance = 1e-3;

/// The same for two bodies, over the largest limit between them: a press must not hide how a box slides
/// beside it. Bodies that hardly graze each other are left out: part of the largest limit of all.
constexpr double kPairTolerance = 1e-2, kGrazing = 1e-6;

/// What contacts of one place have in common: the point and the bodies, or the pair of primitives.
struct Place {
  bool is_of_point = false;
  PairKey key;
  int64_t bodies = 0;
  auto operator<=>(const Place&) const = default;
};

Place place_of(const FrictionLimit& limit) {
  const PairKey& key = limit.key;
  const bool of_point =
      key.kind == PairKind::PointTriangle || key.kind == PairKind::PointEdge || key.kind == PairKey::kOther;
  const int64_t bodies = group_code(limit.group_a, limit.group_b);
  return of_point ? Place{true, {PairKey::kOther, key.first, 0}, bodies} : Place{false, key, bodies};
}

/// One side of a place.
struct Sum {
  double before = 0.0, now = 0.0;
};

struct Entry {
  Place place;
  bool is_now = false;
  const FrictionLimit* limit;
};

}  // namespace

LimitComparison::LimitComparison(const std::vector<FrictionLimit>& before,
                                 const std::vector<FrictionLimit>& now) {
  std::vector<Entry> entries;
  entries.reserve(before.size() + now.size());
  for (const FrictionLimit& limit : before) entries.push_back({place_of(limit), false, &limit});
  for (const FrictionLimit& limit : now) entries.push_back({place_of(limit), true, &limit});
  // In the order of the lists at each place, without the memory that stable sorts take.
  std::ranges::sort(entries, {}, [](const Entry& e) { return std::tuple(e.place, e.is_now, e.limit); });
  std::map<int64_t, OfBodies> of_bodies;
  for (size_t i = 0, end = 0; i < entries.size(); i = end) {
    std::array<Sum, 2> sides;
    for (end = i; end < entries.size() && entries[end].place == entries[i].place; ++end) {
      const FrictionLimit& limit = *entries[end].limit;
      Sum& sum = sides[dot(limit.normal, entries[i].limit->normal) >= 0.0 ? 0 : 1];
      (entries[end].is_now ? sum.now : sum.before) += limit.limit;
    }
    OfBodies& pair = of_bodies[entries[i].place.bodies];
    for (const Sum& sum : sides) {
      const double change = std::fabs(sum.now - sum.before);
      pair.change = std::max(pair.change, change);
      pair.limit = std::max({pair.limit, sum.before, sum.now});
      total_.largest_change = std::max(total_.largest_change, change);
      total_.largest_limit = std::max(total_.largest_limit, sum.now);
    }
  }
  for (const auto& [bodies, pair] : of_bodies) bodies_.push_back(pair);
}

bool LimitComparison::is_settled() const {
  if (!(total_.largest_change <= kLimitTolerance * total_.largest_limit)) return false;
  return std::ranges::all_of(bodies_, [&](const OfBodies& pair) {
    return pair.limit <= kGrazing * total_.largest_limit || pair.change <= kPairTolerance * pair.limit;
  });
}

}  // namespace stark
