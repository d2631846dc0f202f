#include <stark/contact/friction_limits.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <span>
#include <tuple>

namespace stark {

namespace {

/// Change of the limits below which friction counts as up to date, over the largest one of all.
constexpr double kLimitTolerance = 1e-3;

/// The same for two bodies, over the largest limit between them: a press must not hide how a box slides
/// beside it. Bodies that hardly graze each other are left out: part of the largest limit of all.
constexpr double kPairTolerance = 1e-2, kGrazing = 1e-6;

/// Cosine between two changes of all limits above which they go the same way, and the largest share of the
/// way that is foreseen then.
constexpr double kSameWay = 0.9, kLargestShare = 4.0;

/// Part of a new limit that a share of the way leaves at least.
constexpr double kLeastLimit = 0.5;

/// Part of an edge within which a contact is at its end.
constexpr double kEnd = 1e-2;

/// One side of a place.
struct Sum {
  double before = 0.0, now = 0.0;
};

struct Entry {
  FrictionPlace place;
  bool is_now = false;
  const FrictionLimit* limit;
  double sign = 1.0;  ///< of its normal, seen from the place
};

using Sides = std::array<Sum, 2>;

int side_of(const Entry& entry, const Entry& first) {
  return entry.sign * first.sign * dot(entry.limit->normal, first.limit->normal) >= 0.0 ? 0 : 1;
}

/// The lowest names of places that have several, each with the side on which its normals are there: where two
/// points of a body touch, what is above for one of them is below for the other.
class LowestNames {
 public:
  struct Name {
    FrictionPlace place;
    double sign = 1.0;
  };

  Name find(const FrictionPlace& place) const {
    Name name{place};
    for (auto found = lower_.find(name.place); found != lower_.end(); found = lower_.find(name.place))
      name = {found->second.place, name.sign * found->second.sign};
    return name;
  }
  void join(const FrictionPlace& one, const FrictionPlace& other) {
    const Name a = find(one), b = find(other);
    // Two bodies have one side each, whatever the name.
    const auto [first, second] = groups_of_code(one.bodies);
    const double sign = (first == second ? -1.0 : 1.0) * a.sign * b.sign;
    if (a.place != b.place) lower_[std::max(a.place, b.place)] = {std::min(a.place, b.place), sign};
  }
  bool empty() const { return lower_.empty(); }

 private:
  std::map<FrictionPlace, Name> lower_;
};

/// Order of entries, in numbers that compare fast: of a place 3 bits of its kind, 31 of each index and 62 of
/// its bodies, and then whether it is now; and the limit.
struct Rank {
  unsigned __int128 code;
  const FrictionLimit* limit;
  size_t entry;
  auto operator<=>(const Rank&) const = default;
};

Rank rank_of(const Entry& entry, size_t index) {
  const FrictionPlace& place = entry.place;
  const auto [first, second] = groups_of_code(place.bodies);
  unsigned __int128 code = static_cast<uint8_t>(place.key.kind);
  for (const int32_t part : {place.key.first, place.key.second, first, second})
    code = code << 31 | static_cast<uint32_t>(part);
  return {code << 1 | static_cast<unsigned>(entry.is_now), entry.limit, index};
}

/// By place, those before the refresh first, in the order of the lists.
void sort_by_place(std::vector<Entry>& entries) {
  std::vector<Rank> ranks;
  ranks.reserve(entries.size());
  for (size_t k = 0; k < entries.size(); ++k) ranks.push_back(rank_of(entries[k], k));
  std::ranges::sort(ranks);
  std::vector<Entry> sorted;
  sorted.reserve(entries.size());
  for (const Rank& rank : ranks) sorted.push_back(entries[rank.entry]);
  entries = std::move(sorted);
}

std::vector<Entry> sorted_entries(const std::vector<FrictionLimit>& before,
                                  const std::vector<FrictionLimit>& now) {
  std::vector<Entry> entries;
  entries.reserve(before.size() + now.size());
  for (const FrictionLimit& limit : before) entries.push_back({limit.place, false, &limit});
  for (const FrictionLimit& limit : now) entries.push_back({limit.place, true, &limit});
  sort_by_place(entries);
  LowestNames names;
  for (const Entry& entry : entries)
    if (entry.limit->other) names.join(entry.place, *entry.limit->other);
  if (names.empty()) return entries;
  for (Entry& entry : entries) {
    const LowestNames::Name name = names.find(entry.place);
    entry.place = name.place;
    entry.sign = name.sign;
  }
  sort_by_place(entries);
  return entries;
}

/// Visits places with their entries and their sums.
template <typename Visit>
void for_each_place(const std::vector<FrictionLimit>& before, const std::vector<FrictionLimit>& now,
                    const Visit& visit) {
  const std::vector<Entry> entries = sorted_entries(before, now);
  for (size_t i = 0, end = 0; i < entries.size(); i = end) {
    Sides sides;
    for (end = i; end < entries.size() && entries[end].place == entries[i].place; ++end) {
      Sum& sum = sides[side_of(entries[end], entries[i])];
      (entries[end].is_now ? sum.now : sum.before) += entries[end].limit->limit;
    }
    visit(std::span<const Entry>(entries.data() + i, end - i), sides);
  }
}

/// The only point of a side that a contact is at, from its first to its last point.
std::optional<int32_t> only_point(const Contact& contact, int first, int last) {
  std::optional<int32_t> point;
  for (int p = first; p < last; ++p) {
    if (std::fabs(contact.weights[p]) <= kEnd) continue;
    if (point) return {};
    point = contact.sites[p];
  }
  return point;
}

}  // namespace

FrictionLimit limit_of(const Contact& contact, const Vec3& normal, double limit) {
  const PairKey& key = contact.key;
  const int64_t bodies = group_code(contact);
  const auto of_point = [&](int32_t point) { return FrictionPlace{{PairKey::kOther, point, 0}, bodies}; };
  const bool of_edges = key.kind == PairKind::EdgeEdge, of_points = key.kind == PairKind::PointPoint;
  auto a = only_point(contact, 0, contact.side_a_count);
  auto b = only_point(contact, contact.side_a_count, contact.point_count);
  if (!of_edges && !of_points) a = key.first;
  const bool is_of_one = contact.group_a == contact.group_b;
  const double side = is_of_one ? (a || !b ? 1.0 : -1.0) : side_of_first(contact, bodies);
  FrictionLimit result{{key, bodies}, {}, normal * side, limit};
  if (!a && !b) return result;
  result.place = of_point(a ? *a : *b);
  if (a && b && *a != *b) result.other = of_point(*b);
  return result;
}

std::vector<double> damped_limits(const std::vector<FrictionLimit>& before,
                                  const std::vector<FrictionLimit>& now, double share) {
  std::vector<double> damped;
  damped.reserve(now.size());
  for (const FrictionLimit& limit : now) damped.push_back(limit.limit);
  for_each_place(before, now, [&](std::span<const Entry> entries, const Sides& sides) {
    for (const Entry& entry : entries) {
      const Sum& sum = sides[side_of(entry, entries.front())];
      if (!entry.is_now || !(sum.before > 0.0) || !(sum.now > 0.0)) continue;
      const double part = ((1.0 - share) * sum.before + share * sum.now) / sum.now;
      damped[static_cast<size_t>(entry.limit - now.data())] *= std::max(part, kLeastLimit);
    }
  });
  return damped;
}

double RefreshShares::next(const std::vector<FrictionLimit>& before, const std::vector<FrictionLimit>& now,
                           bool is_first) {
  std::vector<Change> changes;
  for_each_place(before, now, [&](std::span<const Entry> entries, const Sides& sides) {
    for (const int side : {0, 1}) {
      const double change = sides[side].now - sides[side].before;
      if (change != 0.0) changes.push_back({entries.front().place, side, change});
    }
  });
  const auto name = [](const Change& c) { return std::tuple(c.place, c.side); };
  double along = 0.0, squared = 0.0, last_squared = 0.0;
  for (const Change& c : last_) last_squared += c.change * c.change;
  auto last = last_.begin();
  for (const Change& c : changes) {
    squared += c.change * c.change;
    while (last != last_.end() && name(*last) < name(c)) ++last;
    if (last != last_.end() && name(*last) == name(c)) along += last->change * c.change;
  }
  last_ = std::move(changes);
  double foreseen = 0.0;
  if (along > kSameWay * std::sqrt(squared * last_squared))
    foreseen = along < last_squared ? share_ / (1.0 - along / last_squared) : kLargestShare;
  if (is_first)
    share_ = 1.0;
  else
    share_ = foreseen > 1.0 ? std::min(foreseen, kLargestShare) : 0.5;
  return share_;
}

LimitComparison::LimitComparison(const std::vector<FrictionLimit>& before,
                                 const std::vector<FrictionLimit>& now) {
  std::map<int64_t, LimitChange> of_bodies;
  for_each_place(before, now, [&](std::span<const Entry> entries, const Sides& sides) {
    LimitChange& pair = of_bodies[entries.front().place.bodies];
    for (const Sum& sum : sides) {
      const double change = std::fabs(sum.now - sum.before);
      pair.largest_change = std::max(pair.largest_change, change);
      pair.largest_limit = std::max({pair.largest_limit, sum.before, sum.now});
      total_.largest_change = std::max(total_.largest_change, change);
      total_.largest_limit = std::max(total_.largest_limit, sum.now);
    }
  });
  for (const auto& [bodies, pair] : of_bodies) bodies_.push_back(pair);
}

std::optional<LimitChange> LimitComparison::unsettled() const {
  if (!(total_.largest_change <= kLimitTolerance * total_.largest_limit)) return total_;
  for (const LimitChange& pair : bodies_)
    if (pair.largest_limit > kGrazing * total_.largest_limit &&
        pair.largest_change > kPairTolerance * pair.largest_limit)
      return pair;
  return {};
}

}  // namespace stark
