#include <stark/contact/pressed_sheets.h>

#include <algorithm>

namespace stark {

namespace {

/// Cosine of the angle between two forces from which they count as parallel.
constexpr double kParallel = 0.5;

/// What a vertex touches, how far away, and the force on it.
struct Touch {
  int32_t group = 0;
  double distance = 0.0;  ///< [m]
  Vec3 force;             ///< [N]
};

/// Positive where they are parallel, negative where they are opposite, 0 where they are neither.
int alignment(const Vec3& a, const Vec3& b) {
  const double along = dot(a, b), most = kParallel * norm(a) * norm(b);
  return along > most ? 1 : along < -most ? -1 : 0;
}

}  // namespace

std::vector<PressedSheet> find_pressed_sheets(const AreaWeights& areas, std::span<const Contact> contacts,
                                              std::span<const Vec3> forces) {
  std::vector<PressedSheet> found;
  const auto is_sheet = [&](int32_t group) { return !areas.is_directed(group); };
  const auto add = [&](int32_t sheet, int32_t a, int32_t b) {
    if (a != b && !is_sheet(a) && !is_sheet(b)) found.push_back({sheet, std::min(a, b), std::max(a, b)});
  };
  std::vector<Touch> touches;  // of one vertex
  for (size_t c = 0; c < contacts.size();) {
    const PairKey& key = contacts[c].key;
    const int32_t own = contacts[c].group_a;
    if (key.kind != PairKind::PointTriangle) break;
    touches.clear();
    for (; c < contacts.size() && contacts[c].key.kind == key.kind && contacts[c].key.first == key.first; ++c)
      if (contacts[c].stiffness > 0.0 && contacts[c].group_b != own)
        touches.push_back({contacts[c].group_b, contacts[c].distance, forces[c]});
    for (const Touch& one : touches) {
      for (const Touch& other : touches) {
        if (one.group == other.group) continue;
        const int along = alignment(one.force, other.force);
        if (is_sheet(own) && along < 0) add(own, one.group, other.group);
        if (is_sheet(one.group) && along > 0 && one.distance < other.distance)
          add(one.group, own, other.group);
      }
    }
  }
  std::ranges::sort(found);
  found.erase(std::ranges::unique(found).begin(), found.end());
  return found;
}

}  // namespace stark
