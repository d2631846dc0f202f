#include <stark/sim/model/held_between.h>

#include <algorithm>
#include <numeric>
#include <set>
#include <vector>

namespace stark {

namespace {

/// What does not move but as prescribed: by the number of a scripted body; everything fixed moves as one.
constexpr int32_t kStill = -1;

/// Groups of bodies that hang together, and what holds each of them.
class Holds {
 public:
  Holds(const Scene& scene, const Model& model)
      : scene_(scene), leader_(scene.body_count()), holders_(scene.body_count()) {
    std::iota(leader_.begin(), leader_.end(), 0);
    // Pins of a body move as they like against each other.
    for (int32_t b = 0; b < scene.body_count(); ++b)
      if (!model.bodies()[b].pins.empty()) holders_[b] = {kStill, b};
  }

  void connect(int32_t a, int32_t b) {
    if (is_free(a) && is_free(b))
      join(a, b);
    else if (is_free(a))
      hold(a, holder(b));
    else if (is_free(b))
      hold(b, holder(a));
  }

  void connect(const std::set<int32_t>& bodies, bool is_held_by_world) {
    for (const int32_t body : bodies) {
      connect(*bodies.begin(), body);
      if (is_held_by_world && is_free(body)) hold(body, kStill);
    }
  }

  bool holds_twice() const {
    return std::ranges::any_of(holders_, [](const std::set<int32_t>& all) { return all.size() > 1; });
  }

 private:
  bool is_free(int32_t body) const { return scene_.motion(BodyId{body}) == Motion::Dynamic; }
  int32_t holder(int32_t body) const { return scene_.motion(BodyId{body}) == Motion::Fixed ? kStill : body; }
  int32_t find(int32_t body) const {
    while (leader_[body] != body) body = leader_[body];
    return body;
  }
  void hold(int32_t body, int32_t by) { holders_[find(body)].insert(by); }
  void join(int32_t a, int32_t b) {
    a = find(a), b = find(b);
    if (a == b) return;
    leader_[b] = a;
    holders_[a].merge(holders_[b]);
  }

  const Scene& scene_;
  std::vector<int32_t> leader_;
  std::vector<std::set<int32_t>> holders_;
};

bool is_at_world(const JointDescription& joint) {
  return joint.a.carrier == FrameDescription::Carrier::World ||
         joint.b.carrier == FrameDescription::Carrier::World;
}

bool is_at_world(const AttachmentDescription& attachment) {
  const auto is_world = [](const PointSet& points) { return points.kind == PointKind::WorldPoints; };
  return is_world(attachment.a) || std::ranges::any_of(attachment.b, is_world);
}

}  // namespace

bool is_something_between(const Scene& scene, const Model& model, std::span<const Contact> contacts) {
  if (!scene.energies().empty()) return true;
  Holds holds(scene, model);
  for (const Contact& contact : contacts) holds.connect(contact.group_a, contact.group_b);
  for (const JointDescription& joint : scene.joints())
    holds.connect(connected_bodies(joint), is_at_world(joint));
  for (const AttachmentDescription& attachment : scene.attachments())
    holds.connect(connected_bodies(attachment), is_at_world(attachment));
  return holds.holds_twice();
}

}  // namespace stark
