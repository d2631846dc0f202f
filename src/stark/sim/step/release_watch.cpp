// Contact of what joints and attachments have released comes back once it is apart (step phase
// 0).
#include <algorithm>
#include <array>
#include <functional>
#include <iterator>
#include <map>
#include <set>
#include <utility>

#include <stark/base/error.h>
#include <stark/collision/intersection.h>
#include <stark/geometry/intersection.h>
#include <stark/geometry/topology.h>
#include <stark/sim/scene/body_checks.h>
#include <stark/sim/scene/contact_distance.h>
#include <stark/sim/step/release_watch.h>

namespace stark {

namespace {

/// Gap over contact distance below which bodies push each other by more than nothing.
constexpr double kPushing = 0.99;

using Numbers = std::vector<int64_t>;

Numbers without(const Numbers& all, const Numbers& some) {
  Numbers rest;
  std::ranges::set_difference(all, some, std::back_inserter(rest));
  return rest;
}

Numbers together(const Numbers& a, const Numbers& b) {
  Numbers all;
  std::ranges::set_union(a, b, std::back_inserter(all));
  return all;
}

/// Vertices of one primitive and its body.
struct Side {
  std::vector<int32_t> vertices;
  int32_t body = 0;
};

Side side_of(const SurfaceMesh& mesh, PrimitiveKind kind, int32_t id) {
  const std::span<const int32_t> vertices = vertices_of(mesh, kind, id);
  return {{vertices.begin(), vertices.end()}, groups_of(mesh, kind)[id]};
}

std::pair<Side, Side> sides_of(const SurfaceMesh& mesh, const PairKey& key) {
  return {side_of(mesh, first_kind(key.kind), key.first), side_of(mesh, second_kind(key.kind), key.second)};
}

/// Exclusions by what they are about, to find those that a pair of primitives belongs to.
class ByPlace {
 public:
  ByPlace(const Exclusions& exclusions, const Numbers& some) : exclusions_(exclusions), some_(some) {
    for (const int64_t k : some) places_.insert({place(k), k});
  }

  void block(const Side& a, const Side& b, std::set<int64_t>& out) const {
    add({-1, std::min(a.body, b.body), std::max(a.body, b.body)}, b, out);
    for (const int32_t v : a.vertices) add({v, b.body, 0}, b, out);
    for (const int32_t v : b.vertices) add({v, a.body, 0}, a, out);
  }

  /// All that are about two bodies.
  void block(int32_t body_a, int32_t body_b, std::set<int64_t>& out) const {
    for (const int64_t k : some_) {
      const Exclusion& e = exclusions_[k];
      if (std::minmax(e.body, e.other) == std::minmax(body_a, body_b)) out.insert(k);
    }
  }

 private:
  using Place = std::array<int32_t, 3>;

  Place place(int64_t k) const {
    const Exclusion& e = exclusions_[k];
    return e.vertex == Exclusion::kWhole ? Place{-1, e.body, e.other}
                                         : Place{exclusions_.site(k), e.other, 0};
  }

  void add(const Place& at, const Side& other, std::set<int64_t>& out) const {
    const auto found = places_.find(at);
    if (found != places_.end() && exclusions_.concerns(found->second, other.vertices))
      out.insert(found->second);
  }

  const Exclusions& exclusions_;
  const Numbers& some_;
  std::map<Place, int64_t> places_;
};

/// Pairs of bodies, by group_code(), that push each other.
std::set<int64_t> find_pushing(const std::vector<Contact>& contacts, const CloseBodies& close) {
  std::set<int64_t> pushing;
  for (const Contact& contact : contacts) {
    const int64_t code = group_code(contact);
    if (contact.distance < kPushing * close.of(code).value_or(contact.contact_distance)) pushing.insert(code);
  }
  return pushing;
}

}  // namespace

bool is_touching(const Contact& contact, std::span<const Vec3> x) {
  double size = 0.0;
  for (int p = 0; p < contact.point_count; ++p) {
    const Vec3& at = x[contact.sites[p]];
    size = std::fmax(size, std::fmax(std::fabs(at.x), std::fmax(std::fabs(at.y), std::fabs(at.z))));
  }
  return contact.distance <= kTouching * size;
}

void ReleaseWatch::set_regained(const Numbers& regained) {
  if (regained == filtered_) return;
  contact_->set_filter(exclusions_.filter(regained));
  filtered_ = regained;
}

void ReleaseWatch::check(const State& state) const {
  const Numbers& regained = state.contact_regained;
  const bool is_sorted = std::ranges::adjacent_find(regained, std::ranges::greater_equal{}) == regained.end();
  const bool in_range = regained.empty() || (regained.front() >= 0 && regained.back() < exclusions_.size());
  if (!is_sorted || !in_range)
    throw InvalidArgument("state: contact_regained: must be numbers of exclusions in [0, " +
                          std::to_string(exclusions_.size()) +
                          "), sorted; use a state that a simulation has been in");
}

void ReleaseWatch::begin_step() {
  watch_ = {.close = {state_.contact_close_bodies, state_.contact_close_distance}};
  if (!contact_) return;
  watch_.regained = exclusions_.over(state_);
  watch_.overlapping = without(exclusions_.released(state_), watch_.regained);
  if (watch_.overlapping.empty()) return set_regained(watch_.regained);
  const PhaseTimer::Scope scope(timer_, Phase::BroadPhase);
  const std::vector<Vec3> x = model_.site_positions(state_);
  set_regained(watch_.regained);
  const std::set<int64_t> pushing = find_pushing(contact_->find_contacts_at(x), watch_.close);
  const Numbers apart = without(watch_.overlapping, find_overlapping(watch_.overlapping, x));
  watch_.overlapping = without(watch_.overlapping, apart);
  watch_.regained = together(watch_.regained, apart);
  set_regained(watch_.regained);
  if (!apart.empty()) soften_new_contact(pushing, x);
  if (!watch_.overlapping.empty() && settings_.contact.released_overlap == ReleasedOverlap::Refuse)
    throw InitialIntersection(overlap_text() +
                              "; move them apart before they are released, or set "
                              "contact.released_overlap = 'report'");
}

Numbers ReleaseWatch::find_overlapping(const Numbers& released, std::span<const Vec3> x) {
  const ByPlace by_place(exclusions_, released);
  std::set<int64_t> blocked;
  const PairFilter between = exclusions_.filter_between(released, watch_.regained);
  for (const EdgeTriangleIntersection& pair : find_intersections(surface_mesh_, x, between, pool_))
    by_place.block(side_of(surface_mesh_, PrimitiveKind::Edge, pair.edge),
                   side_of(surface_mesh_, PrimitiveKind::Triangle, pair.triangle), blocked);
  for (const ContainedGroup& pair : find_contained_groups(surface_mesh_, x, between, pool_, is_filled_))
    by_place.block(pair.inner, pair.outer, blocked);
  for (const int64_t k : released)
    if (!blocked.contains(k) && is_vertex_inside(k, x)) blocked.insert(k);
  // Those nearer than collision detection keeps bodies apart: barriers would be infinite, or noise.
  set_regained(together(watch_.regained, without(released, {blocked.begin(), blocked.end()})));
  for (const Contact& contact : contact_->find_contacts_at(x)) {
    const double kept =
        std::max(contact.least_distance, settings_.contact.min_separation_factor * contact.contact_distance);
    if (contact.distance >= kept && !is_touching(contact, x)) continue;
    const auto [a, b] = sides_of(surface_mesh_, contact.key);
    by_place.block(a, b, blocked);
  }
  return {blocked.begin(), blocked.end()};
}

bool ReleaseWatch::is_vertex_inside(int64_t exclusion, std::span<const Vec3> x) const {
  const int32_t site = exclusions_.site(exclusion);
  const ModelBody& other = model_.bodies()[exclusions_[exclusion].other];
  const int32_t filled = exclusions_[exclusion].other;
  if (site < 0 || exclusions_[exclusion].body == filled || !is_filled_[filled] || !is_closed(other.triangles))
    return false;
  const std::span<const Vec3> of_other = x.subspan(other.first_site, other.site_count);
  return locate_point(x[site], of_other, other.triangles) == PointLocation::Inside;
}

void ReleaseWatch::soften_new_contact(const std::set<int64_t>& pushing, std::span<const Vec3> x) {
  // As at time 0: what is within its contact distance is not thrown apart. Bodies that push each other
  // elsewhere keep their contact distance, or would fall by what it lost.
  const CloseBodies now = contact_->find_close_bodies(x);
  for (size_t k = 0; k < now.bodies.size(); ++k)
    if (!pushing.contains(now.bodies[k])) watch_.close.set(now.bodies[k], now.distance[k]);
}

std::string ReleaseWatch::overlap_text() const {
  std::set<std::pair<int32_t, int32_t>> pairs;
  for (const int64_t k : watch_.overlapping)
    pairs.insert(std::minmax({exclusions_[k].body, exclusions_[k].other}));
  constexpr size_t kNamed = 3;
  std::string text;
  size_t named = 0;
  for (const auto& [a, b] : pairs) {
    if (named++ == kNamed) break;
    text += (text.empty() ? "'" : ", '") + scene_.name(BodyId{a}) + "' and '" + scene_.name(BodyId{b}) + "'";
  }
  if (pairs.size() > kNamed) text += " and " + std::to_string(pairs.size() - kNamed) + " more pairs";
  return text + " overlap or touch where " + releaser_text(exclusions_[watch_.overlapping.front()]) +
         " released them";
}

std::string ReleaseWatch::releaser_of(const std::string& a, const std::string& b) const {
  const auto named = [&](int32_t body) {
    return owner_text(scene_.kind(BodyId{body}), scene_.name(BodyId{body}));
  };
  for (const int64_t k : exclusions_.released(state_)) {
    const std::string body = named(exclusions_[k].body), other = named(exclusions_[k].other);
    if ((body == a && other == b) || (body == b && other == a)) return releaser_text(exclusions_[k]);
  }
  return "";
}

std::string ReleaseWatch::releaser_text(const Exclusion& first) const {
  if (!first.joints.empty()) return "joint '" + scene_.joints()[first.joints.front()].name + "'";
  const auto after =
      std::ranges::upper_bound(model_.attachments(), first.pairs.front(), {}, &ModelAttachment::first_pair);
  return "attachment '" + scene_.attachments()[after - model_.attachments().begin() - 1].name + "'";
}

}  // namespace stark
