// Simulation: moving surfaces, which the next step takes as they are set.
#include <iterator>

#include <stark/base/error.h>
#include <stark/sim/scene/body_checks.h>
#include <stark/sim/simulation.h>

namespace stark {

namespace {

/// Position among the moving surfaces; throws where a body has none.
size_t surface_index(const Scene& scene, BodyId body) {
  const auto& motions = scene.surface_motions();
  const std::string& name = scene.name(body);  // throws for ids of another scene
  const auto found = motions.find(body.index);
  if (found == motions.end())
    throw InvalidArgument(
        "'" + name +
        "': surface_velocity: its surface did not move when the simulation was made: must be "
        "given before, (0, 0, 0) if it is to move later");
  return static_cast<size_t>(std::distance(motions.begin(), found));
}

}  // namespace

void Simulation::set_surface_motion(BodyId body, const Vec3& velocity, const Vec3& spin) {
  const size_t k = surface_index(scene_, body);
  const std::string owner = owner_text(scene_.kind(body), scene_.name(body));
  check_finite(owner, "surface_velocity", velocity, "m/s");
  check_finite(owner, "surface_spin", spin, "rad/s");
  state_.surface_velocity[k] = velocity;
  state_.surface_spin[k] = spin;
}

std::optional<SurfaceMotion> Simulation::surface_motion(BodyId body) const {
  const std::optional<SurfaceMotion> given = scene_.surface_motion(body);
  if (!given) return {};
  const size_t k = surface_index(scene_, body);
  return SurfaceMotion{state_.surface_velocity[k], state_.surface_spin[k], given->center};
}

}  // namespace stark
