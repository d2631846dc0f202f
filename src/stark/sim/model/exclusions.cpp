#include <stark/sim/model/exclusions.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <map>
#include <set>

namespace stark {

namespace {

constexpr double kHeld = 1.0, kBroken = -1.0;

/// Edges between what carries an attached vertex of its own body and what the vertex is still kept from.
constexpr int kRings = 2;

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
    is_sewn_ = attachment.sewn;
    if (Exclusion* e = attachment.contact ? nullptr : whole(connected_bodies(attachment)))
      for (int32_t pair = 0; pair < count; ++pair) add_pair(*e, first_pair + pair);
    for (int32_t pair = 0; pair < static_cast<int32_t>(attachment.patches.size()); ++pair) {
      const Index3& patch = attachment.patches[pair];
      add(carriers_of(attachment.a, pair), {attachment.patch_body, {patch.begin(), patch.end()}},
          first_pair + pair);
    }
    int32_t pair = 0;
    for (const PointSet& b : attachment.b)
      for (int32_t k = 0; k < static_cast<int32_t>(b.size()); ++k, ++pair)
        add(carriers_of(attachment.a, pair), carriers_of(b, k), first_pair + pair);
  }

  std::vector<Exclusion> take() {
    std::vector<Exclusion> list;
    for (auto& [key, exclusion] : found_) {
      for (std::vector<int32_t>* numbers :
           {&exclusion.joints, &exclusion.pairs, &exclusion.sewn, &exclusion.near}) {
        std::ranges::sort(*numbers);
        numbers->erase(std::ranges::unique(*numbers).begin(), numbers->end());
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

  /// One end of a pair: its body, and the vertices that it is, or that carry it.
  struct End {
    BodyId body;
    std::vector<int32_t> vertices{};
  };

  static End carriers_of(const PointSet& points, int32_t k) {
    if (points.kind == PointKind::Vertices) return {points.body, {points.vertices[k]}};
    End end{points.body};
    if (points.kind != PointKind::Embedded) return end;
    for (size_t i = 0; i < 4; ++i)
      if (points.weights[k][i] != 0.0) end.vertices.push_back(points.supports[k][i]);
    return end;
  }

  void add(const End& a, const End& b, int32_t pair) {
    add_vertices(a, b, pair);
    add_vertices(b, a, pair);
  }

  void add_vertices(const End& end, const End& other, int32_t pair) {
    if (end.body.index < 0 || other.body.index < 0 || !can_touch(end.body.index, other.body.index)) return;
    for (const int32_t v : end.vertices) {
      Exclusion& exclusion = at(end.body.index, v, other.body.index);
      add_pair(exclusion, pair);
      if (end.body.index == other.body.index)
        exclusion.near.insert(exclusion.near.end(), other.vertices.begin(), other.vertices.end());
    }
  }

  void add_pair(Exclusion& exclusion, int32_t pair) const {
    exclusion.pairs.push_back(pair);
    if (is_sewn_) exclusion.sewn.push_back(pair);
  }

  Exclusion& at(int32_t body, int32_t vertex, int32_t other) {
    const auto [entry, is_new] = found_.try_emplace({body, vertex, other});
    if (is_new)
      entry->second = {
          .body = body, .vertex = vertex, .other = other, .joints = {}, .pairs = {}, .sewn = {}, .near = {}};
    return entry->second;
  }

  const Scene& scene_;
  bool self_contact_;
  bool is_sewn_ = false;  // the attachment that is being added
  std::map<std::array<int32_t, 3>, Exclusion> found_;
};

}  // namespace

namespace {

using Neighbours = std::vector<std::vector<int32_t>>;  ///< by vertex

Neighbours find_neighbours(const ModelBody& body) {
  Neighbours neighbours(body.site_count);
  const auto connect = [&](int32_t a, int32_t b) {
    neighbours[a].push_back(b);
    neighbours[b].push_back(a);
  };
  for (const Index3& t : body.triangles)
    for (int k = 0; k < 3; ++k) connect(t[k], t[(k + 1) % 3]);
  for (const Index2& edge : body.edges) connect(edge[0], edge[1]);
  return neighbours;
}

void add_rings(const Neighbours& neighbours, std::vector<int32_t>& vertices) {
  std::set<int32_t> found(vertices.begin(), vertices.end());
  std::vector<int32_t> rim = vertices;
  for (int ring = 0; ring < kRings; ++ring) {
    std::vector<int32_t> next;
    for (const int32_t v : rim)
      for (const int32_t other : neighbours[v])
        if (found.insert(other).second) next.push_back(other);
    rim = std::move(next);
  }
  vertices.assign(found.begin(), found.end());
}

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

Exclusions::Exclusions(std::vector<Exclusion> list, PairFilter base, std::span<const ModelBody> bodies)
    : list_(std::move(list)), base_(std::move(base)) {
  for (const ModelBody& body : bodies) first_site_.push_back(body.first_site);
  std::map<int32_t, Neighbours> neighbours;  // of bodies that are attached to themselves
  for (Exclusion& exclusion : list_) {
    if (exclusion.near.empty()) continue;
    const auto [of_body, is_new] = neighbours.try_emplace(exclusion.body);
    if (is_new) of_body->second = find_neighbours(bodies[exclusion.body]);
    add_rings(of_body->second, exclusion.near);
  }
}

bool Exclusions::concerns(int64_t k, std::span<const int32_t> sites) const {
  const Exclusion& exclusion = (*this)[k];
  return exclusion.near.empty() || std::ranges::any_of(sites, [&](int32_t site) {
           return std::ranges::binary_search(exclusion.near, site - first_site_[exclusion.body]);
         });
}

bool Exclusions::is_held(int64_t k, const State& state) const {
  const Exclusion& exclusion = (*this)[k];
  return std::ranges::any_of(exclusion.joints, [&](int32_t j) { return state.joint_enabled[j] == kHeld; }) ||
         std::ranges::any_of(exclusion.pairs, [&](int32_t p) { return state.attachment_held[p] == kHeld; }) ||
         std::ranges::any_of(exclusion.sewn, [&](int32_t p) { return state.attachment_held[p] != kBroken; });
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
    if (exclusion.vertex == Exclusion::kWhole) {
      filter.set(exclusion.body, exclusion.other, false);
    } else if (exclusion.near.empty()) {
      filter.exclude(site(k), exclusion.other);
    } else {
      std::vector<int32_t> sites = exclusion.near;
      for (int32_t& v : sites) v += first_site_[exclusion.body];
      filter.exclude_from(site(k), std::move(sites));
    }
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
