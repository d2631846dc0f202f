// What a step measures velocities from, and what the next one needs to know of it
// (mechanics/time_integrator.h).
#include <cmath>

#include <stark/sim/simulation.h>

namespace stark {

namespace {

/// An approach of a contact pair within a step, over its contact distance, that counts as an impact:
/// velocities jump there, and a history that is smooth by assumption would throw the bodies apart again.
constexpr double kImpactApproach = 0.1;

template <typename T>
void extrapolate(const TimeStencil& stencil, const std::vector<T>& now, const std::vector<T>& before,
                 std::vector<T>& out) {
  out = now;
  if (stencil.history == 0.0) return;
  for (size_t i = 0; i < out.size(); ++i) out[i] = stencil.reference(now[i], before[i]);
}

}  // namespace

void Simulation::set_reference(double h) {
  const State& s = state_;
  const bool has_history = settings_.time.integrator == Integrator::Bdf2 && s.previous_time_step > 0.0 &&
                           h <= kLargestBdf2Ratio * s.previous_time_step;
  Reference& r = reference_;
  r.stencil = has_history ? bdf2(h, s.previous_time_step) : implicit_euler(h);
  extrapolate(r.stencil, s.point_position, s.previous_point_position, r.place.point_position);
  extrapolate(r.stencil, s.body_position, s.previous_body_position, r.place.body_position);
  extrapolate(r.stencil, s.body_rotation, s.previous_body_rotation, r.place.body_rotation);
  extrapolate(r.stencil, s.point_velocity, s.previous_point_velocity, r.point_velocity);
  extrapolate(r.stencil, s.body_velocity, s.previous_body_velocity, r.body_velocity);
  set_free_rotations(h);
  extrapolate(r.stencil, s.joint_rate, s.previous_joint_rate, r.joint_rate);
  r.sites.resize(model_->map().site_count());
  model_->map().positions(r.place, r.sites);
  r.before.clear();
  r.beyond.clear();
  if (r.stencil.history == 0.0) return;
  r.before.resize(r.sites.size());
  model_->map().positions({s.previous_point_position, s.previous_body_position, s.previous_body_rotation},
                          r.before);
  const double way = std::sqrt(r.stencil.history * (1.0 + r.stencil.history));
  for (size_t i = 0; i < r.sites.size(); ++i)
    r.beyond.push_back(r.sites[i] + (step_start_[i] - r.before[i]) * way);
}

std::vector<double> Simulation::reference_coordinates() const {
  const ConstraintSet& constraints = model_->constraints();
  if (reference_.before.empty()) return constraints.coordinates(reference_.sites);
  std::vector<double> result = constraints.coordinates(step_start_);
  const std::vector<double> before = constraints.coordinates(reference_.before);
  for (int32_t j = 0; j < constraints.joint_count(); ++j) {
    const ConstraintSet::Place& place = constraints.place(j);
    const auto& coordinates = constraints.groups()[place.group].joint->coordinates();
    for (size_t k = 0; k < coordinates.size(); ++k) {
      const size_t q = place.coordinate + k;
      const double change = result[q] - before[q];
      result[q] +=
          reference_.stencil.history * (coordinates[k].unit == "rad" ? shortest_turn(change) : change);
    }
  }
  return result;
}

void Simulation::remember_state(double h) {
  if (settings_.time.integrator != Integrator::Bdf2) return;
  const bool impact =
      contact_ && contact_->largest_approach(step_start_, potential_->site_positions()) > kImpactApproach;
  state_.previous_time_step = impact ? 0.0 : h;
  state_.previous_point_position = state_.point_position;
  state_.previous_point_velocity = state_.point_velocity;
  state_.previous_body_position = state_.body_position;
  state_.previous_body_velocity = state_.body_velocity;
  state_.previous_body_rotation = state_.body_rotation;
  state_.previous_body_angular_velocity = state_.body_angular_velocity;
  state_.previous_joint_rate = state_.joint_rate;
}

}  // namespace stark
