// Simulation: prescribed vertices, prescribed frames of rods.
#include <cmath>

#include <stark/base/error.h>
#include <stark/sim/scene/validation.h>
#include <stark/sim/simulation.h>

namespace stark {

void Simulation::set_pin_targets(BodyId body, std::span<const Vec3> targets, std::optional<double> duration) {
  const std::string owner = "pin targets of body '" + scene_.name(body) + "'";
  const ModelBody& b = model_->bodies()[body.index];
  if (b.pins.size() != targets.size())
    throw InvalidArgument(owner + ": " + std::to_string(targets.size()) + " positions for " +
                          std::to_string(b.pins.size()) + " pinned vertices; give one position [m] for each");
  for (const Vec3& target : targets)
    if (!is_finite(target))
      throw InvalidArgument(owner + ": " + to_text(FieldValue(target)) + " m must be finite");
  const double remaining = checked_duration(owner, duration);
  if (has_nodes(b.kind)) {
    for (size_t k = 0; k < targets.size(); ++k) {
      state_.script_position[b.rigid_index + b.pins[k]] = targets[k];
      state_.script_remaining[b.rigid_index + b.pins[k]] = remaining;
    }
    return;
  }
  for (size_t k = 0; k < targets.size(); ++k) state_.pin_target[b.first_site + b.pins[k]] = targets[k];
  state_.pin_remaining = remaining;
}

std::vector<Vec3> Simulation::pin_targets(BodyId body) const {
  scene_.name(body);
  const ModelBody& b = model_->bodies()[body.index];
  std::vector<Vec3> targets;
  for (const int32_t pin : b.pins)
    targets.push_back(has_nodes(b.kind) ? state_.script_position[b.rigid_index + pin]
                                        : state_.pin_target[b.first_site + pin]);
  return targets;
}

std::vector<Mat3> Simulation::frames(BodyId body) const {
  const ModelBody& b = rod(body);
  const auto first = state_.body_rotation.begin() + b.rigid_index;
  return {first, first + b.site_count};
}

std::vector<Mat3> Simulation::frames(FibresId fibres) const {
  scene_.fibres(fibres);  // throws for ids of another scene
  const ModelFibres& nodes = model_->fibres()[fibres.index];
  const auto first = state_.body_rotation.begin() + nodes.first_frame;
  return {first, first + nodes.frame_count};
}

void Simulation::set_clamp_targets(BodyId body, std::span<const Mat3> targets,
                                   std::optional<double> duration) {
  const ModelBody& b = rod(body);
  const std::string owner = "clamp targets of body '" + scene_.name(body) + "'";
  if (b.clamped.size() != targets.size())
    throw InvalidArgument(owner + ": " + std::to_string(targets.size()) + " rotations for " +
                          std::to_string(b.clamped.size()) + " clamped nodes; give one rotation for each");
  for (const Mat3& target : targets) check_rotation(owner, target);
  const double remaining = checked_duration(owner, duration);
  for (size_t k = 0; k < targets.size(); ++k) {
    state_.script_rotation[b.rigid_index + b.clamped[k]] = targets[k];
    state_.script_remaining[b.rigid_index + b.clamped[k]] = remaining;
  }
}

std::vector<Mat3> Simulation::clamp_targets(BodyId body) const {
  const ModelBody& b = rod(body);
  std::vector<Mat3> targets;
  for (const int32_t node : b.clamped) targets.push_back(state_.script_rotation[b.rigid_index + node]);
  return targets;
}

const ModelBody& Simulation::rod(BodyId body) const {
  scene_.rod(body);  // throws for ids of another scene and other kinds of bodies
  return model_->bodies()[body.index];
}

}  // namespace stark
