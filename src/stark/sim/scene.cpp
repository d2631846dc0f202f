// Scene: validation of what is added, names, pairs. See scene.h.
#include <stark/sim/scene.h>

#include <algorithm>
#include <cmath>

#include <stark/base/error.h>
#include <stark/geometry/mass_properties.h>
#include <stark/geometry/polyline.h>
#include <stark/geometry/topology.h>
#include <stark/sim/body_checks.h>
#include <stark/sim/material_fields.h>
#include <stark/sim/validation.h>

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

}  // namespace

BodyId Scene::add_cloth(ClothDescription body) {
  body.name = unique_name(body.name, BodyKind::Cloth);
  const std::string owner = owner_text(BodyKind::Cloth, body.name);
  std::vector<std::string> warnings;
  validate(body.material, owner);
  check_cloth_mesh(owner, body.mesh, warnings);
  warn_about_free_directions(owner, body.mesh, body.material, warnings);
  warn_about_weak_plates(owner, body.mesh, body.material, warnings);
  check_fields(owner, body);
  check_initial_positions(owner, body.initial_positions, body.mesh.vertices.size());
  check_common(owner, body);
  warn_about_size(owner, body.mesh.vertices, warnings);
  warnings_.insert(warnings_.end(), warnings.begin(), warnings.end());
  cloths_.push_back(std::move(body));
  return append(cloths_.back().name, BodyKind::Cloth, cloths_.size() - 1);
}

BodyId Scene::add_solid(SolidDescription body) {
  body.name = unique_name(body.name, BodyKind::Solid);
  const std::string owner = owner_text(BodyKind::Solid, body.name);
  std::vector<std::string> warnings;
  validate(body.material, owner);
  check_solid_mesh(owner, body.mesh);
  if (body.formulation == Formulation::MeanDilatation && body.mesh.type == ElementType::Tet4)
    throw InvalidArgument(owner +
                          ": formulation = mean_dilatation with linear tetrahedra, which have one volume "
                          "ratio each anyway: must be hexahedra or quadratic tetrahedra; use "
                          "stark.mesh.to_quadratic");
  check_fields(owner, body);
  check_initial_positions(owner, body.initial_positions, body.mesh.vertices.size());
  check_common(owner, body);
  warn_about_size(owner, body.mesh.vertices, warnings);
  warnings_.insert(warnings_.end(), warnings.begin(), warnings.end());
  solids_.push_back(std::move(body));
  return append(solids_.back().name, BodyKind::Solid, solids_.size() - 1);
}

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

BodyId Scene::append(std::string name, BodyKind kind, size_t index_in_kind) {
  body_names_.add(name);
  bodies_.push_back({std::move(name), kind, static_cast<int32_t>(index_in_kind)});
  pins_.emplace_back();
  return {static_cast<int32_t>(bodies_.size()) - 1};
}

std::string Scene::unique_name(const std::string& name, BodyKind kind) {
  if (name.empty()) return free_name(to_string(kind));
  if (body_names_.contains(name))
    throw InvalidArgument(
        owner_text(kind, name) + ": name = '" + name +
        "' is taken: names of bodies and layers must be unique in a scene; choose another or leave it out");
  return name;
}

void Scene::check_vertices(BodyId body, std::string_view action, std::span<const int32_t> vertices) const {
  const std::string owner = owner_text(kind(body), name(body));
  const size_t count = initial_positions(body).size();
  for (const int32_t v : vertices)
    if (v < 0 || static_cast<size_t>(v) >= count)
      throw InvalidArgument(owner + ": " + std::string(action) + " vertex " + std::to_string(v) +
                            ": must be in [0, " + std::to_string(count) +
                            "); give indices of vertices of the mesh");
}

void Scene::pin(BodyId body, std::span<const int32_t> vertices) {
  if (is_rigid(kind(body)))
    throw InvalidArgument(
        owner_text(kind(body), name(body)) +
        ": has no vertices of its own to pin: only cloth, solids and rods do; use motion = fixed or "
        "scripted for the whole body");
  check_vertices(body, "pinned", vertices);
  if (const SolidMesh* mesh = solid_mesh(body))
    for (const int32_t v : vertices)
      if (const auto first = static_cast<int32_t>(mesh->first_embedded()); v >= first)
        throw InvalidArgument(owner_text(kind(body), name(body)) + ": pinned vertex " + std::to_string(v) +
                              " is embedded and follows the nodes of its cell: must be below " +
                              std::to_string(first) + "; pin those nodes, mesh.nodes_around(vertices)");
  append_new(pins_[at_index(body)].vertices, vertices);
}

void Scene::disable_contact(BodyId a, BodyId b) { contact_disabled_.insert(ordered(a, b)); }

void Scene::enable_contact(BodyId a, BodyId b) {
  contact_disabled_.erase(ordered(a, b));
  const std::set<int32_t> bodies{a.index, b.index};
  const auto enable = [&](auto& connections) {
    for (auto& connection : connections)
      if (connected_bodies(connection) == bodies) connection.contact = true;
  };
  enable(joints_);
  enable(attachments_);
}

bool Scene::contact_enabled(BodyId a, BodyId b) const {
  return contact_possible(a, b) && !is_kept_apart(a, b);
}

bool Scene::meeting_matters(BodyId a, BodyId b) const {
  const bool are_prescribed = motion(a) != Motion::Dynamic && motion(b) != Motion::Dynamic;
  const bool moves = motion(a) == Motion::Scripted || motion(b) == Motion::Scripted;
  return a != b && are_prescribed && moves && !contact_disabled_.contains(ordered(a, b)) &&
         !is_kept_apart(a, b);
}

bool Scene::is_kept_apart(BodyId a, BodyId b) const {
  const std::set<int32_t> bodies{a.index, b.index};
  const auto keeps_apart = [&](const auto& connection) {
    return !connection.contact && connected_bodies(connection) == bodies;
  };
  return bodies.size() == 2 &&
         (std::ranges::any_of(joints_, keeps_apart) || std::ranges::any_of(attachments_, keeps_apart));
}

bool Scene::is_filled(BodyId body) const {
  return visit(body, [&](const auto& b) {
    if constexpr (requires { b.hollow; })
      if (b.hollow) return false;
    return row_of(kind(body)).can_be_filled;
  });
}

bool Scene::contact_possible(BodyId a, BodyId b) const {
  if (contact_disabled_.contains(ordered(a, b))) return false;
  if (motion(a) != Motion::Dynamic && motion(b) != Motion::Dynamic) return false;
  if (a != b) return true;
  return visit(a, [](const auto& body) {
    if constexpr (requires { body.self_contact; }) return body.self_contact;
    return false;
  });
}

Scene::Pair Scene::ordered(BodyId a, BodyId b) const {
  at(a);
  at(b);
  return {std::min(a.index, b.index), std::max(a.index, b.index)};
}

size_t Scene::at_index(BodyId body) const {
  if (body.index < 0 || body.index >= body_count())
    throw InvalidArgument("body id " + std::to_string(body.index) + ": must be in [0, " +
                          std::to_string(body_count()) +
                          ") for this scene; use the ids that its add_* functions returned");
  return static_cast<size_t>(body.index);
}

BodyId Scene::find(std::string_view name) const {
  std::vector<std::string> known;
  for (int32_t i = 0; i < body_count(); ++i) {
    if (bodies_[i].name == name) return {i};
    known.push_back(bodies_[i].name);
  }
  throw InvalidArgument("unknown body '" + std::string(name) + "'" + nearest_name_hint(name, known) +
                        ": must be the name of a body of the scene, which has " +
                        std::to_string(body_count()));
}

Motion Scene::motion(BodyId body) const {
  return visit(body, [](const auto& b) {
    if constexpr (requires { b.motion; }) return b.motion;
    return Motion::Dynamic;
  });
}

namespace {

[[noreturn]] void fail_kind(const std::string& name, BodyKind kind, BodyKind wanted) {
  throw InvalidArgument("body '" + name + "' is a " + to_string(kind) + " body: a " + to_string(wanted) +
                        " body is needed here");
}

}  // namespace

size_t Scene::body_of_kind(BodyId body, BodyKind wanted) const {
  if (kind(body) != wanted) fail_kind(name(body), kind(body), wanted);
  return static_cast<size_t>(index_in_kind(body));
}

const std::vector<Vec3>& Scene::rest_vertices(BodyId body) const {
  return visit(body, [](const auto& b) -> const std::vector<Vec3>& { return b.mesh.vertices; });
}

const RigidInertia& Scene::rigid_inertia(BodyId body) const {
  rigid(body);
  return inertias_[index_in_kind(body)];
}

namespace {

template <typename Description>
std::vector<Vec3> placed_vertices(const Description& body) {
  const std::vector<Vec3>* local = &body.mesh.vertices;
  if constexpr (requires { body.initial_positions; })
    if (!body.initial_positions.empty()) local = &body.initial_positions;
  std::vector<Vec3> placed(local->size());
  for (size_t i = 0; i < placed.size(); ++i) placed[i] = body.position + body.rotation * (*local)[i];
  return placed;
}

}  // namespace

std::optional<double> Scene::contact_distance(BodyId body) const {
  return visit(body, [](const auto& b) -> std::optional<double> {
    if constexpr (requires { b.default_contact_distance(); })
      return b.contact_distance.value_or(b.default_contact_distance());
    return b.contact_distance;
  });
}

std::optional<double> Scene::contact_stiffness(BodyId body) const {
  return visit(body, [](const auto& b) { return b.contact_stiffness; });
}

double Scene::contact_core(BodyId body) const {
  return visit(body, [](const auto& b) { return b.contact_core; });
}

std::optional<double> Scene::body_friction(BodyId body) const {
  return visit(body, [](const auto& b) { return b.friction; });
}

std::optional<Color> Scene::color(BodyId body) const {
  return visit(body, [](const auto& b) { return b.color; });
}

std::vector<Vec3> Scene::initial_positions(BodyId body) const {
  return visit(body, [](const auto& b) { return placed_vertices(b); });
}

std::vector<Vec3> Scene::initial_velocities(BodyId body) const {
  if (is_rigid(kind(body))) fail_kind(name(body), kind(body), BodyKind::Cloth);
  return visit(body, [](const auto& b) {
    std::vector<Vec3> velocities = placed_vertices(b);
    for (Vec3& v : velocities) v = b.velocity + cross(b.angular_velocity, v - b.position);
    return velocities;
  });
}

}  // namespace stark
