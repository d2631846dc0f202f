// Friction and restitution of a scene: coefficients of pairs, directions of surfaces that friction may depend
// on, and surfaces that move along themselves.
#include <algorithm>
#include <cmath>

#include <stark/base/error.h>
#include <stark/geometry/topology.h>
#include <stark/sim/scene/body_checks.h>

namespace stark {

namespace {

std::string pair_text(const Scene& scene, BodyId a, BodyId b) {
  return "friction of '" + scene.name(a) + "' and '" + scene.name(b) + "'";
}

}  // namespace

void Scene::set_friction(BodyId a, BodyId b, const FrictionCoefficient& coefficient) {
  const Pair pair = ordered(a, b);
  const std::string owner = pair_text(*this, a, b);
  check_number(owner, "coefficient", coefficient.sticking, "1", non_negative(), "use 0 for none");
  check_number(owner, "kinetic coefficient", coefficient.sliding, "1",
               closed_interval(0.0, coefficient.sticking), "sliding contact cannot hold more than sticking");
  friction_[pair] = {coefficient.sticking, coefficient.sliding};
}

void Scene::set_anisotropic_friction(BodyId a, BodyId b, const AnisotropicFriction& friction) {
  const Pair pair = ordered(a, b);
  const std::string owner = pair_text(*this, a, b);
  check_number(owner, "coefficient along the surface direction", friction.along, "1", non_negative(),
               "use 0 for none");
  check_number(owner, "coefficient across the surface direction", friction.across, "1", non_negative(),
               "use 0 for none");
  check_number(owner, "kinetic", friction.kinetic, "1", closed_interval(0.0, 1.0),
               "it is the part of both coefficients that sliding contact has");
  const double larger = std::max(friction.along, friction.across);
  FrictionCoefficient coefficient(larger, larger * friction.kinetic);
  if (friction.along != friction.across) {
    coefficient.along = friction.along / larger;
    coefficient.across = friction.across / larger;
    coefficient.frame = a.index;
  }
  friction_[pair] = coefficient;
}

void Scene::set_restitution(BodyId a, BodyId b, double coefficient) {
  const std::string owner = "restitution of '" + name(a) + "' and '" + name(b) + "'";
  for (const BodyId body : {a, b})
    if (!is_rigid(kind(body)))
      throw InvalidArgument(
          owner + ": '" + name(body) + "' is a " + to_string(kind(body)) +
          ": must be rigid bodies; what deforms gives back what its material does not damp");
  if (a == b) throw InvalidArgument(owner + ": must be two bodies; a rigid body does not hit itself");
  check_number(owner, "coefficient", coefficient, "1", closed_interval(0.0, 1.0),
               "it is the speed after an impact over that before");
  restitution_[ordered(a, b)] = coefficient;
}

std::optional<double> Scene::restitution(BodyId a, BodyId b) const {
  const auto entry = restitution_.find(ordered(a, b));
  return entry == restitution_.end() ? std::nullopt : std::optional(entry->second);
}

std::vector<std::pair<BodyId, BodyId>> Scene::pairs_with_friction() const {
  std::vector<std::pair<BodyId, BodyId>> pairs;
  for (const auto& [pair, unused] : friction_) pairs.emplace_back(BodyId{pair.first}, BodyId{pair.second});
  return pairs;
}

void Scene::set_default_friction(double coefficient) {
  check_number("scene", "default_friction", coefficient, "1", non_negative(), "use 0 for none");
  default_friction_ = coefficient;
}

FrictionCoefficient Scene::friction(BodyId a, BodyId b) const {
  if (const auto entry = friction_.find(ordered(a, b)); entry != friction_.end()) {
    FrictionCoefficient coefficient = entry->second;
    if (!coefficient.is_anisotropic() || has_surface_direction({coefficient.frame})) return coefficient;
    const BodyId other = coefficient.frame == a.index ? b : a;
    coefficient.frame = has_surface_direction(other) ? other.index : -1;
    return coefficient;
  }
  return combined_friction(surface_friction(a), surface_friction(b));
}

void Scene::set_surface_directions(BodyId body, std::vector<Vec3> directions) {
  const std::string owner = owner_text(kind(body), name(body));
  if (has_nodes(kind(body)))
    throw InvalidArgument(owner +
                          ": surface_direction: a rod has no triangles that could have a direction; give "
                          "one to the body that it touches");
  const size_t triangles = surface_triangles(body).size();
  if (directions.size() > 1 && directions.size() != triangles)
    throw InvalidArgument(owner + ": surface_direction has " + std::to_string(directions.size()) +
                          " vectors: must be one, or one for each of the " + std::to_string(triangles) +
                          " triangles of the surface");
  for (const Vec3& d : directions) {
    check_finite(owner, "surface_direction", d, "1");
    if (norm(d) == 0.0)
      throw InvalidArgument(owner +
                            ": surface_direction = (0, 0, 0): must not be zero; where it is normal to the "
                            "surface, friction takes the geometric mean of the two coefficients");
  }
  if (directions.empty())
    surface_directions_.erase(body.index);
  else
    surface_directions_[body.index] = std::move(directions);
}

std::vector<Vec3> Scene::surface_directions(BodyId body) const {
  at(body);
  const auto entry = surface_directions_.find(body.index);
  return entry == surface_directions_.end() ? std::vector<Vec3>{} : entry->second;
}

void Scene::set_surface_motion(BodyId body, const SurfaceMotion& motion) {
  const std::string owner = owner_text(kind(body), name(body));
  if (!is_rigid(kind(body)))
    throw InvalidArgument(owner +
                          ": surface_velocity: must be of a rigid body, also a fixed or scripted one; what "
                          "deforms moves with its material");
  check_finite(owner, "surface_velocity", motion.velocity, "m/s");
  check_finite(owner, "surface_spin", motion.spin, "rad/s");
  check_finite(owner, "surface_center", motion.center, "m");
  surface_motions_[body.index] = motion;
}

std::optional<SurfaceMotion> Scene::surface_motion(BodyId body) const {
  at(body);
  const auto entry = surface_motions_.find(body.index);
  return entry == surface_motions_.end() ? std::nullopt : std::optional(entry->second);
}

bool Scene::has_surface_direction(BodyId body) const { return surface_directions_.contains(body.index); }

std::vector<Index3> Scene::surface_triangles(BodyId body) const {
  const BodyKindRow& row = row_of(kind(body));
  return row.surface ? row.surface(*this, body) : std::vector<Index3>{};
}

bool Scene::has_anisotropic_friction() const {
  return std::ranges::any_of(friction_, [](const auto& entry) { return entry.second.is_anisotropic(); });
}

void Scene::check_friction() const {
  for (const auto& [a, b] : pairs_with_friction()) {
    const FrictionCoefficient coefficient = friction(a, b);
    if (coefficient.is_anisotropic() && coefficient.frame < 0)
      throw InvalidArgument(pair_text(*this, a, b) +
                            " is anisotropic, but neither body has a direction: "
                            "set surface_direction of one of them");
  }
}

}  // namespace stark
