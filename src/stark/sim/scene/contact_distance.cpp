#include <stark/sim/scene/contact_distance.h>

#include <algorithm>

#include <stark/base/error.h>
#include <stark/sim/scene/body_checks.h>
#include <stark/sim/scene/thin_sheets.h>
#include <stark/sim/scene/validation.h>

namespace stark {

namespace {

constexpr double kLargest = 1e-3;     ///< [m] automatic contact distance of large bodies
constexpr double kPartOfSize = 0.01;  ///< most of the diagonal of a body
constexpr double kPartOfHeight =
    0.5;  ///< most of the smallest height of a triangle: farther ones touch at rest
constexpr double kSmallestForHeight = 0.1;  ///< of the distance without regard to heights

bool can_touch_itself(const Scene& scene, BodyId body, const Settings& settings) {
  return settings.contact.self_contact && scene.contact_enabled(body, body);
}

/// Of the surface of a cloth or a solid.
SmallestHeight smallest_height(const Scene& scene, BodyId body) {
  return find_smallest_height(scene.rest_vertices(body), scene.surface_triangles(body));
}

double automatic_distance(const Scene& scene, BodyId body, const Settings& settings) {
  const double by_size = std::min(kLargest, kPartOfSize * norm(box_size(scene.rest_vertices(body))));
  if (is_rigid(scene.kind(body)) || !can_touch_itself(scene, body, settings)) return by_size;
  const double by_height = kPartOfHeight * smallest_height(scene, body).height;
  return std::clamp(by_height, kSmallestForHeight * by_size, by_size);
}

}  // namespace

double contact_distance(const Scene& scene, BodyId body, const Settings& settings) {
  if (const std::optional<double> own = scene.contact_distance(body)) return *own;
  return settings.contact.distance > 0.0 ? settings.contact.distance
                                         : automatic_distance(scene, body, settings);
}

void check_resolved(const Scene& scene, BodyId body, const Settings& settings, std::span<const Vec3> x) {
  const double distance = contact_distance(scene, body, settings);
  if (!settings.contact.enabled || distance == 0.0) return;
  double farthest = 0.0;
  for (const Vec3& p : x) farthest = std::max(farthest, max_abs(p));
  const double least = kTouching * farthest;
  if (distance >= least) return;
  throw InvalidArgument(owner_text(scene.kind(body), scene.name(body)) + ": contact_distance = " +
                        quantity_text(distance, "m") + ": must be at least " + quantity_text(least, "m") +
                        ", a thousand times the rounding of its coordinates of up to " +
                        quantity_text(farthest, "m") + "; raise it, or move the scene to the origin");
}

std::vector<std::string> check_contact_distances(const Scene& scene, const Settings& settings) {
  if (!settings.contact.enabled) return {};
  std::vector<std::string> warnings = check_thin_sheets(scene, settings);
  for (int32_t i = 0; i < scene.body_count(); ++i) {
    const BodyId body{i};
    if (!can_touch_itself(scene, body, settings)) continue;
    if (has_nodes(scene.kind(body))) continue;  // what is near along a rod does not touch
    const double distance = contact_distance(scene, body, settings);
    const SmallestHeight smallest = smallest_height(scene, body);
    if (2.0 * distance <= smallest.height) continue;
    const bool is_automatic = !scene.contact_distance(body) && !(settings.contact.distance > 0.0);
    warnings.push_back(
        owner_text(scene.kind(body), scene.name(body)) + ": " +
        (is_automatic ? "its automatic contact_distance of " : "contact_distance = ") +
        quantity_text(distance, "m") + " is more than half the smallest height of its triangles, " +
        quantity_text(rough_below(smallest.height), "m") + " (triangle " + std::to_string(smallest.triangle) +
        "), so the body touches itself at rest; use at most " +
        quantity_text(rough_below(0.5 * smallest.height), "m") + ", a coarser mesh, or self_contact = false");
  }
  return warnings;
}

}  // namespace stark
