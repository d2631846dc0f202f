// What holds the prescribed parts of a scene: forces on pins, torques on clamps, wrenches on fixed and
// scripted bodies, in the last step. They are the derivatives of its energies by places that are no unknowns.
// And what the segments of rods transmit, whatever their law.
#include <stark/base/error.h>
#include <stark/sim/simulation_parts.h>

namespace stark {

namespace {

/// Part of the wrench on a body, about its centre, by its own place: force, and arm or direction times force.
Wrench wrench_on(const KinematicMap& map, int32_t body, std::span<const Vec3> gradient,
                 std::span<const Vec3> x, const Vec3& centre) {
  Wrench wrench;
  for (int32_t i = 0; i < map.site_count(); ++i) {
    const Site& site = map.site(i);
    if (site.index != body || gradient[i] == Vec3{}) continue;
    if (site.kind == SiteKind::RigidPoint) {
      wrench.force += gradient[i];
      wrench.torque += cross(x[i] - centre, gradient[i]);
    } else if (site.kind == SiteKind::RigidDirection) {
      wrench.torque += cross(x[i], gradient[i]);
    }
  }
  return wrench;
}

}  // namespace

std::vector<Vec3> Simulation::pin_forces(BodyId body) {
  scene_.name(body);
  const ModelBody& b = model_->bodies()[body.index];
  std::vector<Vec3> forces(b.pins.size());
  if (step_start_.empty() || forces.empty()) return forces;
  const MotionReference& reference = parts_->motion.reference();
  const bool has_inertia_now = has_inertia(settings_.time.integrator);
  // Of a lumped mass that no energy has: its weight, what accelerates it, and its damping.
  const auto own = [&](double mass, double damping, const Vec3& velocity, const Vec3& before) {
    const Vec3 rate =
        has_inertia_now ? (velocity - before) / reference.stencil.scale + velocity * damping : Vec3{};
    return (rate - settings_.gravity) * mass;
  };
  const std::vector<Vec3> gradient = parts_->ledger.site_gradient(), x = site_positions();
  const KinematicMap& map = model_->map();
  if (has_nodes(b.kind)) {
    for (size_t k = 0; k < forces.size(); ++k) {
      const int32_t node = b.rigid_index + b.pins[k];
      const RigidMass& mass = model_->rigid_masses()[node];
      forces[k] =
          wrench_on(map, node, gradient, x, state_.body_position[node]).force +
          own(mass.mass, mass.linear_damping, state_.body_velocity[node], reference.body_velocity[node]);
    }
    return forces;
  }
  std::vector<Vec3> by_point(state_.point_position.size());
  for (int32_t i = 0; i < map.site_count(); ++i) {
    const SiteSupport s = map.support(i);
    for (size_t k = 0; k < s.points.size(); ++k) by_point[s.points[k]] += gradient[i] * s.weights[k];
    if (map.is_point(i)) by_point[map.site(i).index] += gradient[i];
  }
  for (size_t k = 0; k < forces.size(); ++k) {
    const int32_t p = b.first_site + b.pins[k];
    forces[k] = by_point[p] + own(model_->point_masses()[p], model_->point_damping()[p],
                                  state_.point_velocity[p], reference.point_velocity[p]);
  }
  return forces;
}

std::vector<Vec3> Simulation::clamp_torques(BodyId body) {
  const ModelBody& b = rod(body);
  std::vector<Vec3> torques(b.clamped.size());
  if (step_start_.empty() || torques.empty()) return torques;
  const std::vector<Vec3> gradient = parts_->ledger.site_gradient(), x = site_positions();
  for (size_t k = 0; k < torques.size(); ++k) {
    const int32_t node = b.rigid_index + b.clamped[k];
    torques[k] = wrench_on(model_->map(), node, gradient, x, state_.body_position[node]).torque;
  }
  return torques;
}

Wrench Simulation::holding_wrench(BodyId body) {
  const ModelBody& b = rigid(body, "holding force");
  if (scene_.rigid(body).motion == Motion::Dynamic || step_start_.empty()) return {};
  return wrench_on(model_->map(), b.rigid_index, parts_->ledger.site_gradient(), site_positions(),
                   state_.body_position[b.rigid_index]);
}

std::vector<Wrench> Simulation::section_wrenches(BodyId body) const {
  const ModelBody& b = rod(body);
  std::vector<Wrench> wrenches(b.edges.size());
  if (step_start_.empty()) return wrenches;
  constexpr int kPoints = 8;  // two nodes, then the axes of the first and of the second
  const std::vector<Vec3>& x = site_positions();
  for (const ModelBatch& elements : energies_.batches) {
    const PotentialBatch& batch = elements.batch;
    if (elements.role != ModelBatch::Role::Elastic || elements.owner != scene_.name(body)) continue;
    if (batch.point_count() != kPoints || batch.size() != static_cast<int64_t>(wrenches.size())) continue;
    const std::vector<double> values = batch.evaluate(symbolic::Order::Gradient, x);
    for (size_t e = 0; e < wrenches.size(); ++e) {
      const double* slopes = values.data() + e * (1 + 3 * kPoints) + 1;
      const auto slope = [&](int p) { return Vec3{slopes[3 * p], slopes[3 * p + 1], slopes[3 * p + 2]}; };
      const std::span<const int32_t> sites = batch.stencil(static_cast<int64_t>(e));
      const Vec3 force = slope(1);
      wrenches[e].force += force;
      wrenches[e].torque += cross((x[sites[1]] - x[sites[0]]) * 0.5, force);
      for (int p = 5; p < kPoints; ++p) wrenches[e].torque += cross(x[sites[p]], slope(p));
    }
  }
  return wrenches;
}

}  // namespace stark
