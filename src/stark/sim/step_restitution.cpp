// Restitution in a step: velocities of sites, and what impacts leave for the next one (step phases 2 and 6).
#include <utility>

#include <stark/sim/step_motion.h>

namespace stark {

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

RestitutionSet::Motion StepMotion::restitution_motion(double h) {
  const bool has_time = has_inertia(settings_.time.integrator);
  if (!contact_->has_restitution() || !has_time) return {};
  reference_.site_velocities = site_velocities();
  return {.positions = reference_.sites,
          .velocities = reference_.site_velocities,
          .duration = reference_.stencil.duration,
          .step = h,
          .weight = reference_.stencil.contact_weight,
          .delay = reference_.stencil.history == 0.0 ? 1.0 : 0.0};
}

RestitutionMemory StepMotion::restitution_memory() const {
  const State& s = state_;
  return {s.restitution_bodies, s.restitution_speed,     s.restitution_impulse, s.restitution_work,
          s.restitution_load,   s.restitution_stiffness, s.restitution_due,     s.restitution_rate,
          s.restitution_normal, s.restitution_moment};
}

void StepMotion::remember_impacts(RestitutionMemory memory) {
  State& s = state_;
  s.restitution_bodies = std::move(memory.bodies);
  s.restitution_speed = std::move(memory.speed);
  s.restitution_impulse = std::move(memory.impulse);
  s.restitution_work = std::move(memory.work);
  s.restitution_load = std::move(memory.load);
  s.restitution_stiffness = std::move(memory.stiffness);
  s.restitution_due = std::move(memory.due);
  s.restitution_rate = std::move(memory.rate);
  s.restitution_normal = std::move(memory.normal);
  s.restitution_moment = std::move(memory.moment);
}

}  // namespace stark
