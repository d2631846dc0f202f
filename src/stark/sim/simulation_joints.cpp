// Simulation: joints. Stiffness of their sides, coordinates, reactions, enabling.
#include <algorithm>
#include <cmath>
#include <numbers>

#include <stark/base/error.h>
#include <stark/sim/model/held_places.h>
#include <stark/sim/scene/joint_wrench.h>
#include <stark/sim/simulation_parts.h>

namespace stark {

namespace {

std::string owner_text(const JointDescription& joint) { return "joint '" + joint.name + "'"; }

/// How far the frames of a joint are apart in what it holds, in one unit, beyond the tolerance.
struct Gap {
  double size, tolerance;  // [m, rad]
  ResidualUnit unit;
};

/// Of a joint with these residuals; empty where it agrees within the tolerances.
std::vector<Gap> gaps_of(const Joint& joint, std::span<const double> C, const JointSettings& settings) {
  std::vector<Gap> gaps;
  size_t r = 0;
  for (const int rows : joint.hold_sizes()) {
    const ResidualUnit unit = joint.units()[r];
    double squared = 0.0;
    for (int k = 0; k < rows; ++k, ++r) {
      const double off = joint.one_sided()[r] != 0 ? std::max(0.0, C[r]) : C[r];
      squared += off * off;
    }
    const double tolerance =
        unit == ResidualUnit::Length ? joint_tolerance(settings).length : joint_tolerance(settings).angle;
    if (!(std::sqrt(squared) <= tolerance)) gaps.push_back({std::sqrt(squared), tolerance, unit});
  }
  return gaps;
}

/// In three digits where these show that it is beyond its tolerance.
std::string size_text(const Gap& gap) {
  const char* unit = unit_of(gap.unit);
  return gap.size > 1.01 * gap.tolerance ? rough_text(gap.size, unit) : quantity_text(gap.size, unit);
}

}  // namespace

void Simulation::check_joints() {
  if (scene_.joints().empty()) return;
  const std::vector<Vec3> x = site_positions();
  for (ConstraintGroup& group : energies_.constraints.groups()) group.batch.set_previous(x);
  const std::vector<double> C = energies_.constraints.residuals(x);
  std::vector<std::vector<double>> derivatives;
  for (const ConstraintGroup& group : energies_.constraints.groups())
    derivatives.push_back(group.batch.evaluate(symbolic::Order::Hessian, x));
  for (int32_t j = 0; j < static_cast<int32_t>(scene_.joints().size()); ++j) {
    if (!scene_.joints()[j].enabled) continue;
    const ConstraintSet::Place& place = energies_.constraints.place(j);
    const ConstraintGroup& group = energies_.constraints.groups()[place.group];
    const Joint& joint = *group.joint;
    const size_t outputs = derivatives[place.group].size() / static_cast<size_t>(group.batch.size());
    const auto first =
        derivatives[place.group].begin() + static_cast<std::ptrdiff_t>(place.element * outputs);
    if (!std::all_of(first, first + static_cast<std::ptrdiff_t>(outputs),
                     [](double v) { return std::isfinite(v); }))
      throw InvalidArgument(
          owner_text(scene_.joints()[j]) +
          ": its residuals or their derivatives are not finite at time 0: must be; look for the norm "
          "of a zero vector, a division by zero, or the root or logarithm of a negative number there");
    for (const Gap& gap : gaps_of(joint, std::span(C).subspan(place.residual), settings_.joints)) {
      if (scene_.joints()[j].definition->name == "distance")
        throw InvalidArgument(
            owner_text(scene_.joints()[j]) +
            ": length = " + quantity_text(scene_.joints()[j].values.at("length").values.front(), "m") +
            " differs by " + size_text(gap) + " from the distance of its points at time 0: must be within " +
            residual_text(gap.tolerance, gap.unit) +
            "; leave it out to keep that distance, or add the joint with enabled = false");
      throw InvalidArgument(
          owner_text(scene_.joints()[j]) + ": its frames differ by " + size_text(gap) +
          " at time 0: must be within " + residual_text(gap.tolerance, gap.unit) +
          (gap.unit == ResidualUnit::Length
               ? "; place both frames at the same point of the world"
               : "; turn both frames alike (where one side has a frame of its own, leave out anchor, axis "
                 "and rotation: the other side takes that frame)") +
          ", or add the joint with enabled = false");
    }
  }
}

void Simulation::check_joint_agrees(JointId joint) const {
  const JointDescription& description = scene_.joint(joint);
  if (state_.joint_enabled[joint.index] != kReleased) return;
  const std::vector<double> C = joint_residuals(joint);
  const Joint& formula =
      *energies_.constraints.groups()[energies_.constraints.place(joint.index).group].joint;
  std::string differ, allowed;
  for (const Gap& gap : gaps_of(formula, C, settings_.joints)) {
    differ += (differ.empty() ? "" : " and ") + size_text(gap);
    allowed += (allowed.empty() ? "" : " and ") + residual_text(gap.tolerance, gap.unit);
  }
  if (differ.empty()) return;
  throw InvalidArgument(owner_text(description) + ": its frames differ by " + differ +
                        " now: must be within " + allowed +
                        " to be held again, as the next step would throw the bodies together; place them "
                        "where they agree first, or pull_together() if that is meant");
}

void Simulation::set_joint_enabled(JointId joint, bool enabled) {
  scene_.joint(joint);
  const ConstraintSet::Place& place = energies_.constraints.place(joint.index);
  double& state = state_.joint_enabled[joint.index];
  if (state == kBroken || (state == kHeld) == enabled) return;
  state = enabled ? kHeld : kReleased;
  parts_->joints.forget_history();
  const size_t count = energies_.constraints.groups()[place.group].joint->units().size();
  let_go(state_, place.residual, count);
}

const HeldPlace* Simulation::find_held_place(int32_t constraint) const {
  const std::vector<HeldPlace>& places = model_->held_places();
  const auto place = std::ranges::lower_bound(places, constraint, {}, &HeldPlace::constraint);
  return place != places.end() && place->constraint == constraint ? &*place : nullptr;
}

int64_t Simulation::first_held_place(JointId joint) const {
  const HeldPlace* place = find_held_place(joint.index);
  return place ? place->first : -1;
}
int64_t Simulation::first_held_place(AttachmentId attachment) const {
  const HeldPlace* place = find_held_place(model_->attachments()[attachment.index].first_constraint);
  return place ? place->first : -1;
}

void Simulation::take_place(const HeldPlace& place, std::span<const Vec3> x) {
  if (state_.held_place.empty()) state_.held_place = model_->initial_places();
  const std::vector<double> numbers = find_place(energies_.constraints, place, x);
  std::ranges::copy(numbers, state_.held_place.begin() + place.first);
  const ConstraintSet::Place& at = energies_.constraints.place(place.constraint);
  set_place(energies_.constraints.groups()[at.group].batch, at.element, numbers);
}

void Simulation::hold_joint_here(JointId joint) {
  const JointDescription& description = scene_.joint(joint);
  const HeldPlace* place = find_held_place(joint.index);
  if (!place)
    throw InvalidArgument(
        owner_text(description) + " of the kind '" + description.definition->name + "', " +
        (description.enabled ? "held" : "released") +
        " at time 0: only fixed and ball joints that are added with enabled = false, and whose "
        "side b is a rigid body, a node of a rod or the world, can hold what they find");
  if (state_.joint_enabled[joint.index] == kBroken)
    throw InvalidArgument(owner_text(description) +
                          " has broken: it cannot hold anything any more; rewind, or "
                          "add another joint");
  take_place(*place, site_positions());
  set_joint_enabled(joint, true);
}

bool Simulation::joint_enabled(JointId joint) const {
  scene_.joint(joint);
  return state_.joint_enabled[joint.index] == kHeld;
}

bool Simulation::joint_broken(JointId joint) const {
  scene_.joint(joint);
  return state_.joint_enabled[joint.index] == kBroken;
}

std::vector<Joint::Coordinate> Simulation::joint_coordinate_names(JointId joint) const {
  scene_.joint(joint);
  return energies_.constraints.groups()[energies_.constraints.place(joint.index).group].joint->coordinates();
}

std::vector<double> Simulation::joint_coordinates(JointId joint) const {
  scene_.joint(joint);
  const ConstraintSet::Place& place = energies_.constraints.place(joint.index);
  const size_t count = energies_.constraints.groups()[place.group].joint->coordinates().size();
  const auto first = state_.joint_coordinate.begin() + place.coordinate;
  return {first, first + static_cast<std::ptrdiff_t>(count)};
}

std::vector<double> Simulation::joint_rates(JointId joint) const {
  scene_.joint(joint);
  const ConstraintSet::Place& place = energies_.constraints.place(joint.index);
  const size_t count = energies_.constraints.groups()[place.group].joint->coordinates().size();
  const auto first = state_.joint_rate.begin() + place.coordinate;
  return {first, first + static_cast<std::ptrdiff_t>(count)};
}

std::vector<double> Simulation::joint_residuals(JointId joint) const {
  scene_.joint(joint);
  return energies_.constraints.residuals_of(joint.index, 1, site_positions());
}

Wrench Simulation::joint_reaction(JointId joint) const {
  return joint_wrench(scene_.joint(joint), energies_.constraints, joint.index, site_positions());
}

}  // namespace stark
