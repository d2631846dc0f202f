// Simulation: what is suspicious about a state before a step is taken.
#include <algorithm>
#include <map>
#include <utility>

#include <stark/sim/scene/body_checks.h>
#include <stark/sim/scene/contact_distance.h>
#include <stark/sim/simulation.h>
#include <stark/sim/step/element_strain.h>
#include <stark/sim/step/step_evidence.h>

namespace stark {

namespace {

/// Distance over contact distance below which bodies that start there are pushed apart (contact/pipeline).
constexpr double kOverlap = 0.01;
/// The same of a body with itself below which it gets thin without having been pressed.
constexpr double kThin = 0.5;
constexpr size_t kMostGaps = 10000, kMostElements = 1000;

/// One sentence for each pair of bodies, about the narrowest gap.
void warn_about_overlap(const std::vector<NarrowGap>& gaps, std::vector<std::string>& out) {
  std::map<std::pair<std::string, std::string>, std::pair<const NarrowGap*, int>> pairs;
  for (const NarrowGap& gap : gaps) {
    if (gap.ratio() > kOverlap || gap.a.body == gap.b.body) continue;
    auto [entry, is_new] = pairs.try_emplace(std::minmax(gap.a.body, gap.b.body), &gap, 0);
    ++entry->second.second;
  }
  for (const auto& [bodies, found] : pairs) {
    const auto& [gap, count] = found;
    out.push_back(place_text(gap->a) + " starts " + rough_text(gap->distance, "m") + " from " +
                  place_text(gap->b) + (count > 1 ? ", " + std::to_string(count) + " places in all" : "") +
                  ": within a hundredth of their contact distance of " +
                  rough_text(gap->contact_distance, "m") +
                  ", so contact throws them apart; move them apart, or give them a smaller contact_distance");
  }
}

/// One sentence about the narrowest gap of a body with itself, whose size `distance` [m] counts everywhere in
/// it, where that is much less than the two layers of its contact distance.
void warn_about_thin_layers(const std::vector<NarrowGap>& gaps, const std::string& body, double distance,
                            double layers, std::vector<std::string>& out) {
  if (distance >= kThin * layers) return;
  const auto narrow = std::ranges::find_if(
      gaps, [&](const NarrowGap& gap) { return gap.a.body == body && gap.b.body == body; });
  if (narrow == gaps.end()) return;
  out.push_back(
      place_text(narrow->a) + " starts " + rough_text(distance, "m") + " from " + place_text(narrow->b) +
      ": all its layers come as close as that, instead of " + rough_text(layers, "m") +
      ", until no part of it is near another; start it with wider folds, of at least a quarter of that "
      "where its surface or contact stiffness is given");
}

}  // namespace

std::vector<std::string> Simulation::check_state() const {
  std::vector<std::string> warnings;
  const std::vector<Vec3> x = site_positions();
  if (contact_) {
    const std::vector<NarrowGap> gaps =
        find_narrow_gaps(scene_, *model_, contact_->find_contacts_at(x), kMostGaps);
    warn_about_overlap(gaps, warnings);
    for (size_t k = 0; k < state_.contact_close_bodies.size(); ++k) {
      const auto [a, b] = groups_of_code(state_.contact_close_bodies[k]);
      const BodyId body{a};
      if (a == b)
        warn_about_thin_layers(gaps, owner_text(scene_.kind(body), scene_.name(body)),
                               state_.contact_close_distance[k],
                               2.0 * contact_distance(scene_, body, settings_), warnings);
    }
  }
  for (int32_t b = 0; b < scene_.body_count(); ++b) {
    if (!scene_.solid_mesh(BodyId{b}) || scene_.solid(BodyId{b}).initial_positions.empty())
      continue;  // at rest: checked when it was added
    const std::vector<StrainedElement> elements =
        find_strained_elements(scene_, BodyId{b}, positions(BodyId{b}), kMostElements);
    if (elements.empty() || elements.front().size > 0.0) continue;
    warnings.push_back("element " + std::to_string(elements.front().element) + " of " +
                       place_text(elements.front().at) +
                       " starts inverted; check initial_positions and the order of its vertices");
  }
  return warnings;
}

}  // namespace stark
