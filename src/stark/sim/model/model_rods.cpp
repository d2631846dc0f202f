// Rods of a model: nodes with frames, which live among the rigid bodies of the state, lumped masses,
// segments.
#include <algorithm>

#include <stark/geometry/polyline.h>
#include <stark/sim/model/model_builder.h>
#include <stark/sim/scene/material_fields.h>

namespace stark {

namespace {

/// Rest shape: its nodes and their frames, in the frame of the body.
struct RestRod {
  std::vector<Vec3> nodes;
  std::vector<Mat3> frames;
};

RestRod rest_of(const RodDescription& rod) {
  const std::vector<Vec3>& nodes = rod.mesh.vertices;
  std::vector<Mat3> frames = polyline_frames(nodes, rod.normal);
  if (rod.rest_shape == RestShape::Mesh) return {nodes, frames};
  return {straightened(nodes, frames[0].column(2)), std::vector<Mat3>(nodes.size(), frames[0])};
}

}  // namespace

void Model::Builder::add_rods() {
  for (int32_t i = 0; i < scene.body_count(); ++i)
    if (scene.kind(BodyId{i}) == BodyKind::Rod) add_rod_nodes(BodyId{i});
}

void Model::Builder::add_rod_nodes(BodyId id) {
  const RodDescription& rod = scene.rod(id);
  ModelBody& body = model.bodies_[id.index];
  const int32_t count = static_cast<int32_t>(rod.mesh.vertices.size());
  body.rigid_index = static_cast<int32_t>(model.rigid_masses_.size());
  body.site_count = count;
  body.pins = scene.pins(id).vertices;
  body.clamped = scene.pins(id).clamped;

  const std::vector<double> lengths = polyline_lengths(rod.mesh.vertices);
  const RodSection section = section_of(rod.material);
  for (int32_t v = 0; v < count; ++v) {
    RigidMass node;
    for (const int32_t e : {v - 1, v}) {
      if (e < 0 || e + 1 >= count) continue;
      const double half = 0.5 * lengths[e];
      const double density = element_density(rod, static_cast<size_t>(e)) / rod.material.density;
      node.mass += density * section.mass * half;
      for (int k = 0; k < 2; ++k) node.second_moments[k] += density * section.second_moments[k] * half;
      node.reach = std::max(node.reach, lengths[e]);
    }
    const auto& s = node.second_moments;
    node.moments = {s.y, s.x, s.x + s.y};
    // The inertia of a slender section is negligible: torques act on the nodes next to it through the edges.
    node.resistance = node.mass * node.reach * node.reach;
    node.is_frame = true;
    node.linear_damping = node.angular_damping = rod.material.mass_damping;
    model.rigid_masses_.push_back(node);
    const auto is_in = [v](const std::vector<int32_t>& list) {
      return std::find(list.begin(), list.end(), v) != list.end();
    };
    body_prescribed.push_back(is_in(body.pins));
    rotation_prescribed.push_back(is_in(body.clamped));
  }
}

void Model::Builder::add_rod_sites() {
  for (int32_t i = 0; i < scene.body_count(); ++i) {
    if (scene.kind(BodyId{i}) != BodyKind::Rod) continue;
    ModelBody& body = model.bodies_[i];
    const RestRod rest = rest_of(scene.rod(BodyId{i}));
    body.first_site = static_cast<int32_t>(sites.size());
    for (int32_t v = 0; v < body.site_count; ++v) {
      const int32_t node = body.rigid_index + v;
      centre_sites[node] =
          add_site({.kind = SiteKind::RigidPoint, .index = node, .local = {}, .points = {}, .weights = {}},
                   rest.nodes[v]);
    }
    for (int32_t v = 0; v < body.site_count; ++v) {
      add_axis_sites(body.rigid_index + v);
      for (int k = 0; k < 3; ++k) model.rest_positions_.push_back(rest.frames[v].column(k));
    }
  }
}

void Model::Builder::add_energies(BodyId id, const RodDescription& rod) {
  const ModelBody& body = model.bodies_[id.index];
  std::vector<int32_t> stencils;
  for (const Index2& edge : body.edges) {
    for (const int32_t v : edge) stencils.push_back(body.first_site + v);
    for (const int32_t v : edge)
      for (int k = 0; k < 3; ++k) stencils.push_back(axis_sites[body.rigid_index + v] + k);
  }
  const ElasticEnergy elastic = elastic_energy(rod);
  add_batch(elastic.definition, stencils, scene.name(id), elastic.values);
}

void Model::Builder::set_initial_rods() {
  State& state = model.initial_state_;
  for (int32_t i = 0; i < scene.body_count(); ++i) {
    const BodyId id{i};
    if (scene.kind(id) != BodyKind::Rod) continue;
    const ModelBody& body = model.bodies_[i];
    const std::vector<Vec3> x = scene.initial_positions(id), v = scene.initial_velocities(id);
    const std::vector<Mat3> frames = scene.initial_frames(id);
    for (int32_t node = 0; node < body.site_count; ++node) {
      const int32_t b = body.rigid_index + node;
      state.body_position.push_back(x[node]);
      state.body_velocity.push_back(body_prescribed[b] ? Vec3{} : v[node]);
      state.body_rotation.push_back(frames[node]);
      state.body_angular_velocity.push_back(rotation_prescribed[b] ? Vec3{} : scene.rod(id).angular_velocity);
    }
  }
}

}  // namespace stark
