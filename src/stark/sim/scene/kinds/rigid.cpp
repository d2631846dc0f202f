// Rigid bodies: checks of what is added, and what the rest of sim asks of the kind (sim/scene/body_kind.h).
#include <algorithm>
#include <cmath>

#include <stark/base/error.h>
#include <stark/geometry/mass_properties.h>
#include <stark/sim/scene/body_checks.h>
#include <stark/sim/scene/scene.h>

namespace stark {

namespace {

RigidInertia checked_inertia(const std::string& owner, const RigidInertia& inertia) {
  check_number(owner, "inertia.mass", inertia.mass, "kg", positive(), "give the mass in kilograms");
  check_finite(owner, "inertia.center_of_mass", inertia.center_of_mass, "m");
  double size = 0.0, asymmetry = 0.0;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      size = std::max(size, std::fabs(inertia.tensor(i, j)));
      asymmetry = std::max(asymmetry, std::fabs(inertia.tensor(i, j) - inertia.tensor(j, i)));
    }
  if (!(asymmetry <= 1e-9 * size) || !std::isfinite(size))
    throw InvalidArgument(
        owner + ": inertia tensor differs from its transpose by " + rough_text(asymmetry, "kg m^2") +
        ": must be symmetric and finite; give it about the centre of mass in the axes of the mesh");
  const Vec3 moments = compute_principal_axes(inertia.tensor).values;
  // Physical tensors obey I1 + I2 >= I3; flat bodies reach equality, so rounding needs a margin.
  if (!(moments.x > 0.0) || moments.x + moments.y < moments.z * (1.0 - 1e-9))
    throw InvalidArgument(
        owner + ": inertia tensor has principal moments " + to_text(FieldValue(moments)) +
        " kg m^2: must be positive and no moment above the sum of the other two; check the point "
        "and the axes it refers to");
  return inertia;
}

RigidInertia inertia_of_mesh(const std::string& owner, const RigidDescription& body,
                             std::vector<std::string>& warnings) {
  const TriangleMesh& mesh = body.mesh;
  const bool solid = !body.hollow && (is_closed(mesh.triangles) || body.density);
  if (solid) check_closed(owner, mesh, body.density ? "a mass by density" : "its mass properties");
  const MassProperties unit = solid ? compute_solid_mass_properties(mesh.vertices, mesh.triangles, 1.0)
                                    : compute_shell_mass_properties(mesh.vertices, mesh.triangles, 1.0);
  if (solid && !(unit.mass > 0.0))
    throw InvalidMesh(
        owner + ": the mesh encloses a volume of " + rough_text(unit.mass, "m^3") +
        ": triangles must be counter-clockwise seen from outside; use stark.mesh.oriented(mesh)");
  if (!solid && !body.hollow)
    warnings.push_back(
        owner +
        ": the mesh is open, so its mass is spread over the surface; give inertia= for another "
        "distribution");
  const double factor = body.density ? *body.density : *body.mass / unit.mass;
  return {unit.mass * factor, unit.centre, unit.inertia * factor};
}

RigidInertia inertia_of(const std::string& owner, const RigidDescription& body,
                        std::vector<std::string>& warnings) {
  if (body.mass)
    check_number(owner, "mass", *body.mass, "kg", positive(),
                 "for a body that does not move use motion = fixed");
  if (body.density)
    check_number(owner, "density", *body.density, "kg/m^3", positive(),
                 "for a body that does not move use motion = fixed");
  if (body.hollow && body.density)
    throw InvalidArgument(owner + ": density = " + quantity_text(*body.density, "kg/m^3") +
                          ": a hollow body has no volume: must be given its mass= [kg], spread over the "
                          "surface, or inertia=");
  if (body.motion != Motion::Dynamic) return {};
  const int given = (body.mass ? 1 : 0) + (body.density ? 1 : 0) + (body.inertia ? 1 : 0);
  if (given != 1)
    throw InvalidArgument(
        owner + ": " + (given == 0 ? "none" : "more than one") +
        " of mass, density and inertia given: a dynamic body needs exactly one of them; add mass= [kg] "
        "or density= [kg/m^3], or make it motion = fixed or scripted");
  return body.inertia ? checked_inertia(owner, *body.inertia) : inertia_of_mesh(owner, body, warnings);
}

double mass(const Scene& scene, BodyId body) { return scene.rigid_inertia(body).mass; }

std::vector<Index3> surface(const Scene& scene, BodyId body) { return scene.rigid(body).mesh.triangles; }

}  // namespace

const BodyKindRow kRigidRow{.title = "rigid body",
                            .moved_by = MovedBy::RigidBody,
                            .can_be_filled = true,
                            .mass = mass,
                            .surface = surface};

BodyId Scene::add_rigid(RigidDescription body) {
  body.name = unique_name(body.name, BodyKind::Rigid);
  const std::string owner = owner_text(BodyKind::Rigid, body.name);
  std::vector<std::string> warnings;
  check_rigid_mesh(owner, body.mesh, warnings);
  check_common(owner, body);
  check_number(owner, "linear_damping", body.linear_damping, "1/s", non_negative(), "use 0 for none");
  check_number(owner, "angular_damping", body.angular_damping, "1/s", non_negative(), "use 0 for none");
  if (body.motion == Motion::Fixed && (body.velocity != Vec3{} || body.angular_velocity != Vec3{}))
    throw InvalidArgument(owner + ": velocity = " + to_text(FieldValue(body.velocity)) +
                          " m/s, angular_velocity = " + to_text(FieldValue(body.angular_velocity)) +
                          " rad/s: a fixed body must be at rest; use motion = scripted for a moving one");
  const RigidInertia inertia = inertia_of(owner, body, warnings);
  warn_about_size(owner, body.mesh.vertices, warnings);
  warnings_.insert(warnings_.end(), warnings.begin(), warnings.end());
  rigids_.push_back(std::move(body));
  inertias_.push_back(inertia);
  return append(rigids_.back().name, BodyKind::Rigid, rigids_.size() - 1);
}

}  // namespace stark
