// Scene: names, pins, pairs, what all kinds of bodies have. See scene.h; kinds/x.cpp adds bodies of a kind.
#include <stark/sim/scene/scene.h>

#include <algorithm>
#include <cmath>

#include <stark/base/error.h>
#include <stark/geometry/topology.h>
#include <stark/sim/scene/body_checks.h>
#include <stark/sim/scene/validation.h>

namespace stark {

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

void Scene::clamp(BodyId body, std::span<const int32_t> nodes) {
  if (!has_nodes(kind(body)))
    throw InvalidArgument(owner_text(kind(body), name(body)) +
                          ": has no nodes with frames to clamp: only rods do; use pin");
  check_vertices(body, "clamped", nodes);
  append_new(pins_[at_index(body)].vertices, nodes);
  append_new(pins_[at_index(body)].clamped, nodes);
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

void Scene::disable_contacts(const std::vector<BodyId>& a, const std::vector<BodyId>& b) {
  for (const BodyId i : a)
    for (const BodyId j : b)
      if (i != j) disable_contact(i, j);
}
void Scene::enable_contacts(const std::vector<BodyId>& a, const std::vector<BodyId>& b) {
  for (const BodyId i : a)
    for (const BodyId j : b)
      if (i != j) enable_contact(i, j);
}

std::set<Scene::Pair> Scene::pairs_kept_apart() const {
  std::set<Pair> pairs;
  const auto add = [&](const auto& connections) {
    for (const auto& connection : connections) {
      if (connection.contact) continue;
      const std::set<int32_t> bodies = connected_bodies(connection);
      if (bodies.size() == 2) pairs.emplace(*bodies.begin(), *bodies.rbegin());
    }
  };
  add(joints_);
  add(attachments_);
  return pairs;
}

bool Scene::contact_enabled(BodyId a, BodyId b) const {
  return contact_possible(a, b) && (a == b || !pairs_kept_apart().contains(ordered(a, b)));
}

bool Scene::meeting_matters(BodyId a, BodyId b) const {
  const bool are_prescribed = motion(a) != Motion::Dynamic && motion(b) != Motion::Dynamic;
  const bool moves = motion(a) == Motion::Scripted || motion(b) == Motion::Scripted;
  return a != b && are_prescribed && moves && !contact_disabled_.contains(ordered(a, b)) &&
         !pairs_kept_apart().contains(ordered(a, b));
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
  const auto found = std::ranges::find(bodies_, name, &Body::name);
  if (found != bodies_.end()) return {static_cast<int32_t>(found - bodies_.begin())};
  std::vector<std::string> known;
  for (const Body& body : bodies_) known.push_back(body.name);
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
