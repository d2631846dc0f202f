// What the last step did, as sensors see it: contacts with their forces, accelerations of rigid bodies.
#include <stark/sim/simulation.h>

namespace stark {

std::vector<ContactForce> Simulation::contacts() const {
  if (!contact_ || step_start_.empty()) return {};
  return contact_->contact_forces(site_positions());
}

Vec3 Simulation::acceleration(BodyId body, const Vec3& point) const {
  const ModelBody& b = rigid(body, "acceleration");
  if (step_start_.empty()) return {};
  const Vec3 local = transpose(b.axes) * (point - b.centre);
  const auto velocity = [&](const std::vector<Vec3>& linear, const std::vector<Mat3>& rate) {
    return linear[b.rigid_index] + rate[b.rigid_index] * local;
  };
  return (velocity(state_.body_velocity, state_.body_rotation_rate) -
          velocity(reference_.body_velocity, reference_.body_rotation_rate)) /
         reference_.stencil.scale;
}

}  // namespace stark
