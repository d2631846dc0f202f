// Simulation: rewinding to a state, going on from that of another simulation.
#include <algorithm>
#include <utility>

#include <stark/base/error.h>
#include <stark/sim/model/held_places.h>
#include <stark/sim/model/internal_variables.h>
#include <stark/sim/model/state_history.h>
#include <stark/sim/simulation_parts.h>

namespace stark {

namespace {

std::string count_text(const State& state) {
  return std::to_string(state.point_position.size()) + " points, " +
         std::to_string(state.body_position.size()) + " rigid bodies, " +
         std::to_string(state.joint_enabled.size()) + " joints, " +
         std::to_string(state.actuator_enabled.size()) + " actuators and " +
         std::to_string(state.attachment_held.size()) + " attached points";
}

/// Whether everything is at the same time and place, bit for bit.
bool same_places(const State& a, const State& b) {
  State c = a;
  c.time = b.time;
  c.step_count = b.step_count;
  c.point_position = b.point_position;
  c.body_position = b.body_position;
  c.body_rotation = b.body_rotation;
  return a == c;
}

/// Place of a rigid body, now and a step ago.
void copy_place(const State& from, int32_t body, State& to) {
  to.body_position[body] = from.body_position[body];
  to.body_rotation[body] = from.body_rotation[body];
  if (from.previous_body_position.empty()) return;
  to.previous_body_position[body] = from.previous_body_position[body];
  to.previous_body_rotation[body] = from.previous_body_rotation[body];
}

}  // namespace

void Simulation::set_state(const State& given) {
  parts_->placing.require_closed("the state");
  // That of another integrator may have more, or less.
  State next = with_history(given, has_history(settings_.time.integrator));
  // Older versions kept nothing nearer to what joints pull with.
  if (next.joint_force.empty()) next.joint_force = next.joint_multiplier;
  if (has_history(settings_.time.integrator) && next.joint_carried.empty())
    next.joint_carried = next.joint_force;
  // Until a constraint holds what it finds, states keep no places; after that, they keep all.
  State like = state_;
  like.held_place = next.held_place.empty() ? next.held_place : model_->initial_places();
  if (const std::string field = first_length_difference(next, like); !field.empty())
    throw InvalidArgument("state has " + count_text(next) + ", the simulation has " + count_text(state_) +
                          " ('" + field + "' is not as long); use a state of the same scene");
  if (const std::string what = find_invalid_number(next); !what.empty())
    throw InvalidArgument("state: " + what + "; use a state that a simulation has been in");
  // What belongs to the scene and its settings, not to time: walls may stand elsewhere, steps be shorter.
  next.time_step = std::min(next.time_step, settings_.time.step);
  set_mark_step(next, settings_.time.step);
  for (int32_t b = 0; b < scene_.body_count(); ++b)
    if (scene_.motion(BodyId{b}) == Motion::Fixed)
      copy_place(model_->initial_state(), model_->bodies()[b].rigid_index, next);
  parts_->watch.check(next);
  if (contact_) check_state_clear(next, model_->site_positions(next), "in this state");
  state_ = std::move(next);
  parts_->placing.forget();
  forget_last_step();
}

void Simulation::check_state_clear(const State& state, std::span<const Vec3> x, const std::string& when) {
  const std::vector<int64_t> filtered = parts_->watch.filtered();
  parts_->watch.set_regained(parts_->watch.exclusions().over(state));
  // Of a state that is set again and again, as at the start of each episode of learning, this is known.
  ClearPlaces& known = parts_->known_clear;
  if (known.regained == parts_->watch.filtered() && std::ranges::equal(known.places, x)) return;
  try {
    check_clear(x, when);
  } catch (...) {
    parts_->watch.set_regained(filtered);
    throw;
  }
  known.regained = parts_->watch.filtered();
  known.places.assign(x.begin(), x.end());
}

void Simulation::reset() {
  parts_->placing.require_closed("the state");
  state_ = start_state_;
  parts_->placing.forget();
  if (contact_) parts_->watch.set_regained(parts_->watch.exclusions().over(state_));
  forget_last_step();
}

void Simulation::forget_last_step() {
  step_start_.clear();
  energies_.constraints.set_forces(state_.joint_force);
  set_places(energies_.constraints, model_->held_places(), held_places());
  const std::vector<Vec3> x = site_positions();
  for (PotentialBatch* batch : energies_.all_batches()) batch->set_previous(x);
  for (int32_t k = 0; k < static_cast<int32_t>(scene_.energies().size()); ++k)  // as sensors see them
    energies_.batches[model_->energy_batch({k})].batch.set_time(settings_.time.step, state_.time);
  set_internal(energies_, state_.internal_variable);
}

bool Simulation::resume(const State& before, double max_time_step, const State& state, double placed) {
  set_state(state);  // refuses it before anything else happens
  set_state(before);
  parts_->placing.forget();
  parts_->placing.add_energy(placed);
  step(max_time_step);
  if (report().failed() || !same_places(state_, state)) {
    set_state(state);
    return false;
  }
  state_ = state;  // with what was set since that step
  set_mark_step(state_, settings_.time.step);
  return true;
}

}  // namespace stark
