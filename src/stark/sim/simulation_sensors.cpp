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
  const TimeStencil& stencil = reference_.stencil;
  const Vec3& by_contact = reference_.contact_velocity[b.rigid_index];  // it acts for the whole step
  return (state_.body_velocity[b.rigid_index] + turning_velocity(b.rigid_index, local) - before -
          by_contact) /
             stencil.scale +
         by_contact / (stencil.scale * stencil.contact_weight);
}

}  // namespace stark
