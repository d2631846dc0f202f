// What the last step did, as sensors see it: contacts with their forces, accelerations of rigid bodies.
#include <array>
#include <cmath>
#include <span>

#include <stark/base/error.h>
#include <stark/sim/simulation_parts.h>

namespace stark {

const ContactReadings::Found* Simulation::contact_readings() const {
  if (!contact_ || step_start_.empty()) return nullptr;
  const std::vector<Vec3>& x = site_positions();
  return &contact_readings_->get(x, site_readings_->revision(), *contact_, scene_.body_count());
}

const std::vector<ContactForce>& Simulation::contacts() const {
  static const std::vector<ContactForce> none;
  const ContactReadings::Found* found = contact_readings();
  return found != nullptr ? found->contacts : none;
}

ClosestPoints Simulation::closest_points(BodyId a, BodyId b) {
  const std::string &name_a = scene_.name(a), &name_b = scene_.name(b);
  if (a == b) throw InvalidArgument("distance of '" + name_a + "' from itself: give two bodies");
  if (!intersections_)  // without contact nothing has asked for it
    intersections_ = std::make_unique<IntersectionFinder>(surface_mesh_, scene_.body_count(), is_filled_);
  const ClosestPoints points = intersections_->closest_points(site_positions(), a.index, b.index, *pool_);
  if (std::isinf(points.distance))
    throw InvalidArgument("distance of '" + name_a + "' from '" + name_b + "': one of them has no surface");
  return points;
}

Vec3 Simulation::contact_force(BodyId body) const {
  scene_.name(body);  // throws for ids of another scene
  Vec3 sum;
  const ContactReadings::Found* found = contact_readings();
  if (found == nullptr) return sum;
  for (const int32_t c : found->of_body[body.index]) {
    const ContactForce& entry = found->contacts[c];
    if (entry.contact.group_a == entry.contact.group_b) continue;  // its own, which cancel
    if (entry.contact.group_a == body.index) sum += entry.normal_force + entry.friction;
    if (entry.contact.group_b == body.index) sum -= entry.normal_force + entry.friction;
  }
  return sum;
}

namespace {

/// Barycentric coordinates of a point in the plane of a triangle.
std::array<double, 3> shares_of(const Vec3& point, const std::array<Vec3, 3>& t) {
  const Vec3 n = cross(t[1] - t[0], t[2] - t[0]);
  const double b = dot(cross(point - t[0], t[2] - t[0]), n) / squared_norm(n);
  const double c = dot(cross(t[1] - t[0], point - t[0]), n) / squared_norm(n);
  return {1.0 - b - c, b, c};
}

/// Adds friction that acts beside the closest points to what the vertices of a body bear.
void add_friction(const Model& model, int32_t body, const ContactForce& entry, std::span<const Vec3> x,
                  std::vector<Vec3>& forces) {
  const ModelBody& of = model.bodies()[body];
  const FrictionStencil& at = entry.friction_at;
  for (int p = 0; p < at.point_count; ++p) {
    const Vec3 force = entry.friction * at.weights[p] + at.facing * dot(at.slopes[p], entry.friction);
    if (const ModelLever* lever = model.find_lever(at.sites[p])) {
      if (lever->body != body) continue;
      const Index3& t = of.triangles[lever->triangle];
      const int32_t first = of.first_site;
      const auto shares = shares_of(x[at.sites[p]], {x[first + t[0]], x[first + t[1]], x[first + t[2]]});
      for (int k = 0; k < 3; ++k) forces[t[k]] += force * shares[k];
    } else if (at.sites[p] >= of.first_site && at.sites[p] < of.first_site + of.site_count) {
      forces[at.sites[p] - of.first_site] += force;
    }
  }
}

}  // namespace

std::vector<Vec3> Simulation::vertex_contact_forces(BodyId body) const {
  scene_.name(body);
  const ModelBody& of = model().bodies()[body.index];
  std::vector<Vec3> forces(of.site_count);
  const ContactReadings::Found* found = contact_readings();
  if (found == nullptr) return forces;
  for (const int32_t c : found->of_body[body.index]) {
    const ContactForce& entry = found->contacts[c];
    const Contact& contact = entry.contact;
    const bool is_beside = entry.friction_at.point_count > 0;
    for (int p = 0; p < contact.point_count; ++p) {
      const int32_t group = p < contact.side_a_count ? contact.group_a : contact.group_b;
      if (group == body.index)  // weights of side B are negative, as its forces are
        forces[contact.sites[p] - of.first_site] +=
            (is_beside ? entry.normal_force : entry.normal_force + entry.friction) * contact.weights[p];
    }
    if (is_beside) add_friction(model(), body.index, entry, site_positions(), forces);
  }
  return forces;
}

Vec3 Simulation::acceleration(BodyId body, const Vec3& point) const {
  const ModelBody& b = rigid(body, "acceleration");
  if (step_start_.empty()) return {};
  const Vec3 local = transpose(b.axes) * (point - b.centre);
  const MotionReference& from = parts_->motion.reference();
  const TimeStencil& stencil = from.stencil;
  const int32_t i = b.rigid_index;
  const Vec3 turning = parts_->motion.turning_velocity(i, local);
  const Vec3& by_contact = from.contact_velocity[i];  // it acts for the whole step
  const Vec3 lasting = state_.body_velocity[i] - from.body_velocity[i] - by_contact;
  const Vec3 sudden = by_contact / (stencil.scale * stencil.contact_weight);
  if (stencil.history == 0.0 || stencil.has_smooth_contact)
    return (lasting + turning - from.body_rotation_rate[i] * local) / stencil.scale + sudden;
  // A turn that contact changes within the step has its mean.
  const Vec3 before =
      cross(state_.previous_body_angular_velocity[i], state_.previous_body_rotation[i] * local);
  return lasting / stencil.scale + sudden + (turning - before) / state_.previous_time_step;
}

}  // namespace stark
