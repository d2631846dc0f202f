#include <stark/sim/exclusions.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <map>
#include <set>

namespace stark {

namespace {

constexpr double kHeld = 1.0;

/// Collects exclusions by body, vertex and other body.
class Collector {
 public:
  Collector(const Scene& scene, bool self_contact) : scene_(scene), self_contact_(self_contact) {}

  void add_joint(int32_t number) {
    const JointDescription& joint = scene_.joints()[number];
    if (joint.contact) return;
    if (Exclusion* e = whole(connected_bodies(joint))) e->joints.push_back(number);
  }

  void add_attachment(const AttachmentDescription& attachment, int32_t first_pair) {
    const auto count = static_cast<int32_t>(attachment.size());
    if (Exclusion* e = attachment.contact ? nullptr : whole(connected_bodies(attachment)))
      for (int32_t pair = 0; pair < count; ++pair) e->pairs.push_back(first_pair + pair);
    for (int32_t pair = 0; pair < static_cast<int32_t>(attachment.patches.size()); ++pair) {
      add_point(attachment.a, pair, attachment.patch_body, first_pair + pair);
      for (const int32_t v : attachment.patches[pair])
        add_vertex(attachment.patch_body, v, attachment.a.body, first_pair + pair);
    }
    int32_t pair = 0;
    for (const PointSet& b : attachment.b)
      for (int32_t k = 0; k < static_cast<int32_t>(b.size()); ++k, ++pair) {
        add_point(attachment.a, pair, b.body, first_pair + pair);
        add_point(b, k, attachment.a.body, first_pair + pair);
      }
  }

  std::vector<Exclusion> take() {
    std::vector<Exclusion> list;
    for (auto& [key, exclusion] : found_) {
      for (std::vector<int32_t>* owners : {&exclusion.joints, &exclusion.pairs}) {
        std::ranges::sort(*owners);
        owners->erase(std::ranges::unique(*owners).begin(), owners->end());
      }
      list.push_back(std::move(exclusion));
    }
    return list;
  }

 private:
  bool can_touch(int32_t a, int32_t b) const {
    return scene_.contact_possible(BodyId{a}, BodyId{b}) && (a != b || self_contact_);
  }

  Exclusion* whole(const std::set<int32_t>& bodies) {
    if (bodies.size() != 2 || !can_touch(*bodies.begin(), *bodies.rbegin())) return nullptr;
    return &at(*bodies.begin(), Exclusion::kWhole, *bodies.rbegin());
  }

  void add_vertex(BodyId body, int32_t vertex, BodyId other, int32_t pair) {
    if (other.index < 0 || !can_touch(body.index, other.index)) return;
    at(body.index, vertex, other.index).pairs.push_back(pair);
  }

  /// Of the points of bodies those that are vertices, or carried by some.
  void add_point(const PointSet& points, int32_t k, BodyId other, int32_t pair) {
    if (points.kind == PointKind::Vertices) add_vertex(points.body, points.vertices[k], other, pair);
    if (points.kind != PointKind::Embedded) return;
    for (size_t i = 0; i < 4; ++i)
      if (points.weights[k][i] != 0.0) add_vertex(points.body, points.supports[k][i], other, pair);
  }

  Exclusion& at(int32_t body, int32_t vertex, int32_t other) {
    const auto [entry, is_new] = found_.try_emplace({body, vertex, other});
    if (is_new) entry->second = {.body = body, .vertex = vertex, .other = other, .joints = {}, .pairs = {}};
    return entry->second;
  }

  const Scene& scene_;
  bool self_contact_;
  std::map<std::array<int32_t, 3>, Exclusion> found_;
};

}  // namespace

std::vector<Exclusion> find_exclusions(const Scene& scene, bool self_contact) {
  Collector collector(scene, self_contact);
  for (int32_t j = 0; j < static_cast<int32_t>(scene.joints().size()); ++j) collector.add_joint(j);
  int32_t first_pair = 0;
  for (const AttachmentDescription& attachment : scene.attachments()) {
    collector.add_attachment(attachment, first_pair);
    first_pair += static_cast<int32_t>(attachment.size());
  }
  return collector.take();
}

Exclusions::Exclusions(std::vector<Exclusion> list, PairFilter base, std::vector<int32_t> first_site)
    : list_(std::move(list)), base_(std::move(base)), first_site_(std::move(first_site)) {}

bool Exclusions::is_held(int64_t k, const State& state) const {
  const Exclusion& exclusion = (*this)[k];
  return std::ranges::any_of(exclusion.joints, [&](int32_t j) { return state.joint_enabled[j] == kHeld; }) ||
         std::ranges::any_of(exclusion.pairs, [&](int32_t p) { return state.attachment_held[p] == kHeld; });
}

std::vector<int64_t> Exclusions::released(const State& state) const {
  std::vector<int64_t> result;
  for (int64_t k = 0; k < size(); ++k)
    if (!is_held(k, state)) result.push_back(k);
  return result;
}

std::vector<int64_t> Exclusions::over(const State& state) const {
  std::vector<int64_t> result;
  std::ranges::set_intersection(released(state), state.contact_regained, std::back_inserter(result));
  return result;
}

int32_t Exclusions::site(int64_t k) const {
  const Exclusion& exclusion = (*this)[k];
  return exclusion.vertex == Exclusion::kWhole ? -1 : first_site_[exclusion.body] + exclusion.vertex;
}

void Exclusions::exclude_all_but(std::span<const int64_t> some, PairFilter& filter) const {
  for (int64_t k = 0; k < size(); ++k) {
    if (std::ranges::binary_search(some, k)) continue;
    const Exclusion& exclusion = (*this)[k];
    if (exclusion.vertex == Exclusion::kWhole)
      filter.set(exclusion.body, exclusion.other, false);
    else
      filter.exclude(site(k), exclusion.other);
  }
}

PairFilter Exclusions::filter(std::span<const int64_t> over) const {
  PairFilter filter = base_;
  exclude_all_but(over, filter);
  return filter;
}

PairFilter Exclusions::filter_between(std::span<const int64_t> some, std::span<const int64_t> over) const {
  PairFilter filter(base_.group_count(), false, false);
  for (const int64_t k : some) filter.set((*this)[k].body, (*this)[k].other, true);
  std::vector<int64_t> acting;
  std::ranges::set_union(some, over, std::back_inserter(acting));
  exclude_all_but(acting, filter);
  return filter;
}

}  // namespace stark
