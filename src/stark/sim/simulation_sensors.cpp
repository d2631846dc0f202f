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
  const Vec3 before =
      reference_.body_velocity[b.rigid_index] + reference_.body_rotation_rate[b.rigid_index] * local;
  return (state_.body_velocity[b.rigid_index] + turning_velocity(b.rigid_index, local) - before) /
         reference_.stencil.scale;
}

}  // namespace stark
