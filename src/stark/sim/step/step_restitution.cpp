// Restitution in a step: how rigid bodies move before and after impacts, and what impacts leave for the next
// step (step phases 2 and 6). Velocities of points are those of the bodies at the place where the step ends:
// a body that spins has turned other points to where it is hit. [theory eq. 19b, 19c]
#include <utility>

#include <stark/base/rotation.h>
#include <stark/mechanics/free_rotation.h>
#include <stark/sim/step/step_motion.h>

namespace stark {

template <typename Value>
std::vector<Vec3> StepMotion::by_rigid_site(const Value& value) const {
  const KinematicMap& map = model_.map();
  std::vector<Vec3> result(map.site_count());
  for (int32_t i = 0; i < map.site_count(); ++i)
    if (const Site& site = map.site(i); site.kind == SiteKind::RigidPoint)
      result[i] = value(static_cast<size_t>(site.index), site.local);
  return result;
}

Vec3 StepMotion::unpushed_angular_velocity(size_t b, const Mat3& R) const {
  if (model_.map().layout().rotation_block[b] == kNoBlock) return impact_.angular_velocity[b];
  return velocity_of_momentum(R, model_.rigid_masses()[b].moments, impact_.spin[b]);
}

RestitutionSet::Motion StepMotion::restitution_motion(double h) {
  const bool has_time = has_inertia(settings_.time.integrator);
  if (!contact_->has_restitution() || !has_time) return {};
  const State& s = state_;
  const MotionReference& r = reference_;
  impact_ = {s.body_position, s.body_velocity, s.body_angular_velocity, {}, {}, {}, {}, {}};
  for (size_t b = 0; b < s.body_position.size(); ++b) impact_.spin.push_back(spin(b));

  std::vector<Mat3> turned = target_configuration(h).body_rotation;
  std::vector<Vec3> turning(turned.size());  // with which the turn of the step ends [rad/s]
  for (size_t b = 0; b < turned.size(); ++b) {
    const bool is_free = model_.map().layout().rotation_block[b] != kNoBlock;
    if (is_free) turned[b] = r.free_rotation[b];
    turning[b] = is_free ? unpushed_angular_velocity(b, turned[b])
                         : log_rotation(turned[b] * transpose(s.body_rotation[b])) / h;
  }
  impact_.turned =
      by_rigid_site([&](size_t b, const Vec3& local) { return s.body_position[b] + turned[b] * local; });
  impact_.velocities = by_rigid_site([&](size_t b, const Vec3& local) {
    return s.body_velocity[b] + cross(unpushed_angular_velocity(b, turned[b]), turned[b] * local);
  });
  impact_.lead =
      by_rigid_site([&](size_t b, const Vec3&) { return r.place.body_position[b] - s.body_position[b]; });
  // Displacements from there are those of the end velocity over the duration if nothing pushes: a point that
  // goes round in a circle has come less far along its tangent than its velocity says, and across it.
  impact_.references = by_rigid_site([&](size_t b, const Vec3& local) {
    const Vec3 lever = turned[b] * local;
    return r.place.body_position[b] + lever - cross(turning[b], lever) * r.stencil.duration;
  });
  return {.turned = impact_.turned,
          .velocities = impact_.velocities,
          .references = impact_.references,
          .lead = impact_.lead,
          .duration = r.stencil.duration,
          .step = h,
          .weight = r.stencil.contact_weight,
          .delay = r.stencil.history == 0.0 ? 1.0 : 0.0};
}

RestitutionSet::End StepMotion::restitution_end(double h) const {
  const State& s = state_;
  const auto before = [&](size_t b, const Vec3& lever) {
    return cross(unpushed_angular_velocity(b, s.body_rotation[b]), lever);
  };
  return {.before = by_rigid_site([&](size_t b, const Vec3& local) {
            return impact_.velocity[b] + before(b, s.body_rotation[b] * local);
          }),
          .after = site_velocities(),
          .way = by_rigid_site([&](size_t b, const Vec3& local) {
            const Vec3 lever = s.body_rotation[b] * local;
            const Vec3 turning = 0.5 * (before(b, lever) + cross(s.body_angular_velocity[b], lever));
            return s.body_position[b] - impact_.position[b] + turning * h;
          })};
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
