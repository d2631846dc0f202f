#include <stark/sim/step/verdict.h>

#include <algorithm>

#include <stark/base/error.h>

namespace stark {

std::string listed(const std::vector<std::string>& names) {
  std::string text;
  for (size_t k = 0; k < names.size(); ++k)
    text += (k == 0 ? "" : (k + 1 == names.size() ? " and " : ", ")) + names[k];
  return text;
}

namespace {

Verdict judge_steep_energy(const StepEvidence& e) {
  if (!e.steep) return {};
  return {
      FailureCause::SingularEnergy,
      "energy '" + e.steep->energy + "' is singular: its force on " + place_text(e.steep->at) + " is " +
          rough_text(e.steep->force, "N") + ", about " + rough_text(e.steep->length, "m") +
          " from where the energy grows without bound or, like a norm at zero, has a kink",
      "give the energy a bound, such as the root of r^2 + c^2 for a distance r with a length c that steps "
      "can resolve, or hold its points apart",
      {e.steep->at.body}};
}

Verdict judge_rough_energy(const StepEvidence& e) {
  const bool stuck =
      e.solve.status == SolveStatus::MaxIterations || e.solve.status == SolveStatus::LineSearchFailed;
  if (!e.rough || !stuck) return {};
  const RoughEnergy& rough = *e.rough;
  const std::string energy = "energy '" + rough.energy + "'", at = place_text(rough.at);
  const std::string check = "; print(energy.check()) looks for such places";
  if (rough.jump > 0.0)
    return {FailureCause::RoughEnergy,
            energy + " jumps by " + rough_text(rough.jump, "J") + " where " + at +
                " is, so that no step down its slope lowers it",
            "let both sides of where, minimum and maximum in its formula meet at the same value" + check,
            {rough.at.body}};
  std::string left;
  if (!e.forces.empty()) left = ", where " + rough_text(e.forces.front().force, "N") + " are out of balance";
  return {
      FailureCause::RoughEnergy,
      energy + " has a kink where " + at + " is: its force jumps there by " + rough_text(rough.force, "N") +
          left,
      "round the kink off: abs, minimum, maximum, where and norms in its formula, as the root of d^2 + c^2 "
      "does |d|, with a length, or speed, c that steps can resolve" +
          check,
      {rough.at.body}};
}

/// Ends of a sentence about a stiffness; empty without an element that is nearly gone.
std::string collapsed_text(const StepEvidence& e) {
  const auto collapsed = std::ranges::find_if(e.elements, [&](const StrainedElement& element) {
    return element.at.body == e.stiffest && (element.size < kFlat || element.stretch < kFlat);
  });
  return collapsed == e.elements.end() ? "" : ": " + element_text(*collapsed);
}

}  // namespace

std::string element_text(const StrainedElement& element) {
  return "element " + std::to_string(element.element) + " of " + place_text(element.at) +
         (element.size <= 0.0 ? " is inverted, at " : " has ") + rough_text(element.size, "1") +
         " times its size at rest, with edges " +
         (element.stretch < 1.0 ? "shortened to " : "stretched by up to ") +
         rough_text(element.stretch, "1") + (element.stretch < 1.0 ? " of theirs" : "");
}

Verdict judge_contrast(const StepEvidence& e) {
  const std::string ratio = rough_text(e.stiffness_ratio, "1"), acting = acting_text(e);
  if (e.stiffest != e.softest)
    return {FailureCause::StiffnessContrast,
            e.stiffest + " is " + ratio + " times as stiff as " + e.softest +
                ", too much for double precision" + collapsed_text(e),
            "make stiff parts softer or rigid bodies, soft and light parts stiffer or heavier",
            {e.stiffest, e.softest}};
  return {FailureCause::StiffnessContrast,
          "one part of " + e.stiffest + " is " + ratio +
              " times as stiff as another, too much for double precision" + collapsed_text(e),
          "load it less there, in smaller steps or over more vertices, and look for elements that are much "
          "smaller than others, and for values of a material that differ too much" +
              (acting.empty() ? "" : "; " + acting),
          {e.stiffest}};
}

Verdict judge_users_energies(const StepEvidence& e) {
  Verdict steep = judge_steep_energy(e);
  return steep.cause != FailureCause::None ? steep : judge_rough_energy(e);
}

std::string acting_text(const StepEvidence& e) {
  if (e.acting.empty()) return "";
  std::vector<std::string> names;
  for (const std::string& name : e.acting) names.push_back("'" + name + "'");
  return (names.size() == 1 ? "energy " : "energies ") + listed(names) +
         (names.size() == 1 ? " acts" : " act") +
         " there: print(energy.check()) tells kinks, jumps and scales that do not fit";
}

}  // namespace stark
