// What the bodies have after a step: positions, velocities, rotations, and what the next step needs to know
// (step phase 6).
#include <stark/sim/model/script_phase.h>
#include <stark/sim/step/step_motion.h>

namespace stark {

namespace {

/// Relative difference of times below which a remaining time counts as used up.
constexpr double kTimeRounding = 1e-12;

}  // namespace

void StepMotion::commit(double h) {
  const std::vector<Vec3> torque = torques();
  const Configuration& end = potential_.configuration();
  const DofLayout& layout = model_.map().layout();
  const Configuration& from = reference_.place;
  const double s = reference_.stencil.duration;
  const bool has_memory = has_history(settings_.time.integrator);
  const bool has_rates = has_inertia(settings_.time.integrator);
  reference_.contact_velocity.assign(end.body_position.size(), Vec3{});
  Motions before;
  Impulses impulses;
  if (has_memory) {
    before = motions();
    impulses = contact_impulses();
    remember_state(h);
  }
  for (size_t p = 0; p < end.point_position.size(); ++p) {
    const bool is_at_rest = !has_rates && layout.point_block[p] != kNoBlock;
    state_.point_velocity[p] = is_at_rest ? Vec3{} : (end.point_position[p] - from.point_position[p]) / s;
    state_.point_position[p] = end.point_position[p];
  }
  const auto arrived = [&](double remaining) { return remaining - h <= kTimeRounding * (state_.time + h); };
  if (!has_rates) model_.map().follow(state_.point_velocity);
  for (size_t b = 0; b < end.body_position.size(); ++b) {
    const ScriptPhase phase = script_phase(state_.script_remaining[b]);
    if (layout.body_block[b] != kNoBlock)
      state_.body_velocity[b] = has_rates ? (end.body_position[b] - from.body_position[b]) / s : Vec3{};
    else if (phase != ScriptPhase::Velocity)
      state_.body_velocity[b] = (end.body_position[b] - state_.body_position[b]) / h;
    state_.body_position[b] = end.body_position[b];
    commit_rotation(static_cast<int32_t>(b), torque[b], h);
    if (phase == ScriptPhase::Moving)
      state_.script_remaining[b] =
          arrived(state_.script_remaining[b]) ? kRestsAtPose : state_.script_remaining[b] - h;
  }
  commit_frames(h);
  if (has_memory) remember_increments(before, impulses, h);
  if (state_.pin_remaining > 0.0)
    state_.pin_remaining = arrived(state_.pin_remaining) ? 0.0 : state_.pin_remaining - h;
}

std::vector<Vec3> StepMotion::site_velocities() const {
  const KinematicMap& map = model_.map();
  std::vector<Vec3> v(map.site_count());
  for (int32_t i = 0; i < map.site_count(); ++i) {
    const Site& site = map.site(i);
    if (site.kind == SiteKind::RigidPoint)
      v[i] = state_.body_velocity[site.index] + turning_velocity(site.index, site.local);
    else if (site.kind == SiteKind::Point)
      v[i] = state_.point_velocity[site.index];
    else if (site.kind == SiteKind::Embedded)
      v[i] = point_sum(map.support(i), state_.point_velocity);
  }
  return v;
}

}  // namespace stark
