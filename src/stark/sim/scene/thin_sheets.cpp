#include <stark/sim/scene/thin_sheets.h>

#include <algorithm>

#include <stark/collision/bounds.h>
#include <stark/sim/scene/body_checks.h>
#include <stark/sim/scene/contact_distance.h>

namespace stark {

namespace {

constexpr double kThin = 0.5;    ///< thickness over the contact distance, below
constexpr double kAround = 0.1;  ///< of the diagonal of a sheet: what is nearer lies over it
constexpr size_t kStack = 3;     ///< fewest sheets

struct Sheet {
  BodyId body;
  double distance;  ///< [m]
  Bounds around{};
};

/// Cloths much thinner than their automatic contact distance.
std::vector<Sheet> find_thin(const Scene& scene, const Settings& settings) {
  std::vector<Sheet> found;
  for (int32_t i = 0; i < scene.body_count(); ++i) {
    const BodyId body{i};
    if (scene.kind(body) != BodyKind::Cloth || scene.contact_distance(body)) continue;
    const ClothDescription& cloth = scene.cloth(body);
    if (cloth.fields.contains("thickness")) continue;
    const double distance = contact_distance(scene, body, settings);
    if (cloth.material.thickness >= kThin * distance) continue;
    const std::vector<Vec3> x = scene.initial_positions(body);
    Sheet sheet{body, distance};
    for (const Vec3& p : x) sheet.around.add(p);
    sheet.around = enlarged(sheet.around, 0.5 * kAround * norm(box_size(x)));
    found.push_back(sheet);
  }
  return found;
}

}  // namespace

std::vector<std::string> check_thin_sheets(const Scene& scene, const Settings& settings) {
  if (settings.contact.distance > 0.0 || scene.cloths().size() < kStack) return {};
  const std::vector<Sheet> sheets = find_thin(scene, settings);
  for (const Sheet& sheet : sheets) {
    const auto count = std::ranges::count_if(sheets, [&](const Sheet& other) {
      return &other == &sheet ||
             (scene.contact_enabled(sheet.body, other.body) && sheet.around.overlaps(other.around));
    });
    if (static_cast<size_t>(count) < kStack) continue;
    return {
        owner_text(BodyKind::Cloth, scene.name(sheet.body)) + ": one of at least " + std::to_string(count) +
        " sheets that lie over each other, " +
        quantity_text(scene.cloth(sheet.body).material.thickness, "m") +
        " thick. Their automatic contact_distance of " + quantity_text(sheet.distance, "m") +
        " keeps them twice that apart: the stack is too thick, and slow when something presses on it. Give "
        "them a surface, such as stark.surfaces.paper, or a contact_distance of half their thickness"};
  }
  return {};
}

}  // namespace stark
