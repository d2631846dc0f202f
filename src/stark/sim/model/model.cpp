#include <stark/sim/model/model.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <ranges>
#include <unordered_map>

#include <stark/base/error.h>
#include <stark/geometry/face_levers.h>
#include <stark/geometry/flat_faces.h>
#include <stark/geometry/topology.h>
#include <stark/mechanics/past_measures.h>
#include <stark/sim/model/contact_stiffness.h>
#include <stark/sim/model/internal_variables.h>
#include <stark/sim/model/model_builder.h>
#include <stark/sim/model/script_phase.h>
#include <stark/sim/model/state_history.h>
#include <stark/sim/scene/contact_distance.h>

namespace stark {

void Model::Builder::build() {
  scene.check_friction();
  add_deformables();
  add_layer_masses();
  add_rigids();
  add_rods();
  add_fibre_frames();
  DofLayout layout = DofLayout::build(point_prescribed, body_prescribed, rotation_prescribed);
  add_rigid_sites();
  add_rod_sites();
  add_fibre_sites();
  add_energy_sites();
  add_joint_sites();
  add_attachment_sites();
  add_levers();
  model.map_ = KinematicMap(std::move(layout), std::move(sites), std::move(embedded), turning_ranges());
  for (int32_t i = 0; i < scene.body_count(); ++i)
    scene.visit(BodyId{i}, [&](const auto& body) { add_energies(BodyId{i}, body); });
  add_layer_energies();
  add_inertia();
  add_energies();
  add_joints();
  for (PotentialBatch* batch : energies.all_batches()) batch->set_rest(model.rest_positions_);
  set_block_scales();
  set_initial_state();
  set_initial_sites();
  compile_contact();
  list_parts();
}

std::shared_ptr<const Potential> Model::Builder::compile(const PotentialDefinition& definition,
                                                         const std::set<std::string>& per_element) const {
  if (!has_history(settings.time.integrator))
    return std::make_shared<Potential>(definition, backend(), per_element);
  PotentialDefinition referenced = definition;
  referenced.energy = [&](PotentialBuilder& builder) {
    return with_references(builder, definition.energy(builder));
  };
  return std::make_shared<Potential>(referenced, backend(), per_element);
}

PotentialBatch& Model::Builder::add_batch(const PotentialDefinition& definition,
                                          std::span<const int32_t> stencils, const std::string& owner,
                                          const ParameterValues& values) {
  ModelBatch& batch = energies.batches.emplace_back(ModelBatch{
      ModelBatch::Role::Elastic, owner, PotentialBatch(compile(definition, per_element_names(values))), {}});
  batch.batch.resize(stencils);
  set_values(batch.batch, values);
  return batch.batch;
}

PotentialBatch& Model::Builder::add_stress_batch(const PotentialDefinition& definition,
                                                 std::span<const int32_t> stencils, const std::string& owner,
                                                 const ParameterValues& values) {
  PotentialBatch& batch = add_batch(definition, stencils, owner, values);
  energies.batches.back().carries_stress = true;
  return batch;
}

std::vector<bool> Model::Builder::held_bodies() const {
  std::vector<bool> held(scene.body_count(), false);
  const auto hold = [&](const auto& all) {
    for (const auto& one : all)
      for (const int32_t body : connected_bodies(one)) held[body] = true;
  };
  hold(scene.joints());
  hold(scene.attachments());
  return held;
}

std::vector<TurningRange> Model::Builder::turning_ranges() const {
  const std::vector<bool> held = held_bodies();
  std::vector<TurningRange> ranges;
  for (int32_t i = 0; i < scene.body_count(); ++i) {
    const ModelBody& body = model.bodies_[i];
    if (has_nodes(body.kind)) {
      std::vector<double> masses;
      for (int32_t k = 0; k < body.site_count; ++k)
        masses.push_back(model.rigid_masses_[body.rigid_index + k].mass);
      ranges.push_back({true, held[i], body.rigid_index, std::move(masses)});
    }
    if (!has_points(body.kind)) continue;
    const SolidMesh* solid = scene.solid_mesh(BodyId{i});
    // A sheet that is held somewhere swings as a chain does.
    if (!solid && (held[i] || !body.pins.empty())) continue;
    const auto first = model.point_masses_.begin() + body.first_site;
    const auto count =
        solid && solid->is_embedded() ? static_cast<int32_t>(solid->first_embedded()) : body.site_count;
    ranges.push_back({false, held[i], body.first_site, {first, first + count}});
  }
  return ranges;
}

void Model::Builder::set_block_scales() {
  const DofLayout& layout = model.map_.layout();
  model.block_scales_.resize(layout.block_count);
  for (size_t p = 0; p < layout.point_block.size(); ++p)
    if (layout.point_block[p] != kNoBlock)
      model.block_scales_[layout.point_block[p]].inverse_inertia = 1.0 / model.point_masses_[p];
  for (size_t b = 0; b < layout.body_block.size(); ++b) {
    const RigidMass& mass = model.rigid_masses_[b];
    if (const int32_t block = layout.body_block[b]; block != kNoBlock)
      model.block_scales_[block].inverse_inertia = 1.0 / mass.mass;
    if (const int32_t block = layout.rotation_block[b]; block != kNoBlock)
      model.block_scales_[block] = {.inverse_inertia = mass.reach / mass.resistance,
                                    .inverse_length = 1.0 / mass.reach,
                                    .reach = mass.reach};
  }
}

void Model::Builder::set_initial_state() {
  State& state = model.initial_state_;
  state.time_step = state.mark_step = settings.time.step;
  for (int32_t i = 0; i < scene.body_count(); ++i) {
    const BodyId id{i};
    if (!has_points(scene.kind(id))) continue;
    const std::vector<Vec3> x = scene.initial_positions(id), v = scene.initial_velocities(id);
    state.point_position.insert(state.point_position.end(), x.begin(), x.end());
    state.point_velocity.insert(state.point_velocity.end(), v.begin(), v.end());
  }
  for (size_t p = 0; p < point_prescribed.size(); ++p)
    if (point_prescribed[p]) state.point_velocity[p] = {};
  model.map_.follow(state.point_position);
  model.map_.follow(state.point_velocity);
  for (const int32_t i : rigid_bodies) {
    const RigidDescription& rigid = scene.rigid(BodyId{i});
    const ModelBody& body = model.bodies_[i];
    const bool moves = rigid.motion != Motion::Fixed;
    state.body_position.push_back(rigid.position + rigid.rotation * body.centre);
    state.body_velocity.push_back(moves ? rigid.velocity : Vec3{});
    state.body_rotation.push_back(rigid.rotation * body.axes);
    state.body_angular_velocity.push_back(moves ? rigid.angular_velocity : Vec3{});
  }
  set_initial_rods();
  set_initial_fibres();
  state.script_position = state.body_position;
  state.script_rotation = state.body_rotation;
  state.script_remaining.assign(state.body_position.size(), kMovesAtVelocity);
  state.pin_target = state.point_position;
  for (const auto& [body, motion] : scene.surface_motions()) {
    state.surface_velocity.push_back(motion.velocity);
    state.surface_spin.push_back(motion.spin);
  }
}

void Model::Builder::set_initial_sites() {
  const State& state = model.initial_state_;
  std::vector<Vec3> x(model.map_.site_count());
  model.map_.positions({state.point_position, state.body_position, state.body_rotation}, x);
  for (PotentialBatch* batch : energies.all_batches()) batch->set_initial(x);
  ConstraintSet& constraints = energies.constraints;
  model.initial_state_.joint_multiplier.assign(constraints.residual_count(), 0.0);
  model.initial_state_.joint_force = model.initial_state_.joint_multiplier;
  for (const JointDescription& joint : scene.joints())
    model.initial_state_.joint_enabled.push_back(joint.enabled ? 1.0 : 0.0);
  set_initial_attachments(x);
  for (ConstraintGroup& group : constraints.groups()) group.batch.set_previous(x);
  model.initial_state_.joint_coordinate = constraints.coordinates(x);
  set_initial_rates(x);
  if (has_history(settings.time.integrator)) begin_history(model.initial_state_);
  set_initial_actuators();
}

void Model::Builder::compile_contact() {
  if (settings.contact.enabled)
    model.contact_potentials_ =
        compile_contact_potentials(backend(), scene.has_anisotropic_friction(), scene.has_restitution());
}

Model::Model(const Scene& scene, const Settings& settings, Energies& out_energies) {
  Builder(*this, out_energies, scene, settings).build();
  initial_state_.internal_variable = internal_values(out_energies);
}

const ModelLever* Model::find_lever(int32_t site) const {
  const auto found = std::ranges::lower_bound(levers_, site, {}, &ModelLever::site);
  return found != levers_.end() && found->site == site ? &*found : nullptr;
}

std::vector<Vec3> Model::site_positions(const State& state) const {
  std::vector<Vec3> x(map_.site_count());
  map_.positions({state.point_position, state.body_position, state.body_rotation}, x);
  return x;
}

std::vector<PotentialBatch*> Energies::all_batches() {
  std::vector<PotentialBatch*> all;
  for (ModelBatch& batch : batches) all.push_back(&batch.batch);
  for (ConstraintGroup& group : constraints.groups()) all.push_back(&group.batch);
  return all;
}

namespace {

/// What collides of a body: of rigid ones the polyhedron without what its triangulation adds. Vertices inside
/// flat faces are kept where the body `moves` and there are more than a few: they carry their part of the
/// pressure.
void add_surface(const ModelBody& body, int32_t group, std::span<const Vec3> rest, bool has_faces, bool moves,
                 ContactSurfaces& out) {
  SurfaceMesh& mesh = out.mesh;
  const std::span<const Vec3> own = rest.subspan(body.first_site, body.site_count);
  const FlatFaces faces =
      is_rigid(body.kind) ? find_flat_faces(own, body.triangles) : separate_faces(body.triangles);
  const auto first_triangle = static_cast<int32_t>(mesh.triangles.size());
  for (int32_t v = 0; v < body.site_count; ++v) mesh.vertex_group[body.first_site + v] = group;
  std::vector<int32_t> inner = faces.inner_vertices;
  if (moves && is_rigid(body.kind))
    inner = has_faces ? find_lone_vertices(own, body.triangles, faces) : std::vector<int32_t>{};
  for (const int32_t v : inner) mesh.inner.push_back(body.first_site + v);
  for (size_t t = 0; t < body.triangles.size(); ++t) {
    const auto& [v0, v1, v2] = body.triangles[t];
    mesh.triangles.push_back({body.first_site + v0, body.first_site + v1, body.first_site + v2});
    mesh.triangle_group.push_back(group);
    out.face.push_back(first_triangle + (has_faces ? faces.face[t] : static_cast<int32_t>(t)));
    out.patch.push_back(first_triangle + faces.patch[t]);
  }
  for (const std::span<const Index2> edges :
       {std::span<const Index2>(faces.edges), std::span<const Index2>(body.edges)})
    for (const Index2& e : edges) {
      mesh.edges.push_back({body.first_site + e[0], body.first_site + e[1]});
      mesh.edge_group.push_back(group);
    }
}

/// Of a rigid body with many vertices on its surface.
std::optional<GroupFrame> find_body_frame(const ModelBody& body, std::span<const Vec3> rest) {
  if (!is_rigid(body.kind)) return {};
  std::vector<int32_t> sites = find_used_vertices(body.triangles);
  for (int32_t& site : sites) site += body.first_site;
  return find_frame(sites, rest);
}

/// Three vertices of a body that span its motion, far apart.
std::array<int32_t, 3> spanning_sites(const ModelBody& body, std::span<const Vec3> rest) {
  std::vector<int32_t> sites(body.site_count);
  std::iota(sites.begin(), sites.end(), body.first_site);
  return find_spanning_sites(sites, rest);
}

/// Keeps the nodes of a rod from its edges that begin within half a turn of the tightest bend of a rod as
/// thick as its contact distance (a length of pi/2 of that): they come within it in any such bend.
void set_neighbours(const ModelBody& rod, std::span<const Vec3> rest, double contact_distance,
                    PairFilter& filter) {
  const double half_turn = 0.5 * std::numbers::pi * contact_distance;
  for (int32_t a = rod.first_site; a < rod.first_site + rod.site_count; ++a) {
    double length = 0.0;
    for (int32_t b = a + 1; b < rod.first_site + rod.site_count; ++b) {
      length += norm(rest[b] - rest[b - 1]);
      if (!(length < half_turn)) break;
      filter.set_neighbours(a, b);
    }
  }
}

}  // namespace

namespace {

// Scenes have far more pairs of bodies than bodies: only what is said of a pair is looked up by pairs.
PairFilter make_filter(const Scene& scene, const Settings& settings) {
  const int32_t count = scene.body_count();
  PairFilter filter(count);
  std::vector<bool> is_dynamic(count);
  for (int32_t a = 0; a < count; ++a) {
    is_dynamic[a] = scene.motion(BodyId{a}) == Motion::Dynamic;
    for (int32_t b = 0; b < a; ++b)
      if (!is_dynamic[a] && !is_dynamic[b]) filter.set(a, b, false);
    filter.set(a, a, settings.contact.self_contact && scene.contact_possible(BodyId{a}, BodyId{a}));
  }
  for (const auto& [a, b] : scene.pairs_without_contact()) filter.set(a, b, false);
  return filter;
}

FrictionTable make_friction_table(const Scene& scene) {
  std::vector<double> of_body;
  for (int32_t b = 0; b < scene.body_count(); ++b) of_body.push_back(scene.surface_friction(BodyId{b}));
  std::unordered_map<int64_t, FrictionCoefficient> of_pair;
  for (const auto& [a, b] : scene.pairs_with_friction())
    of_pair.emplace(group_code(a.index, b.index), scene.friction(a, b));
  return [of_body, of_pair](int32_t a, int32_t b) -> FrictionCoefficient {
    const auto own = of_pair.find(group_code(a, b));
    return own != of_pair.end() ? own->second : combined_friction(of_body[a], of_body[b]);
  };
}

}  // namespace

ContactSurfaces Model::make_surfaces(const Scene& scene, const Settings& settings) const {
  ContactSurfaces surfaces;
  SurfaceMesh& mesh = surfaces.mesh;
  mesh.vertex_count = map_.site_count();
  mesh.vertex_group.assign(mesh.vertex_count, 0);
  std::vector<int32_t> first_triangle;  // by body
  for (size_t b = 0; b < bodies_.size(); ++b) {
    const BodyId id{static_cast<int32_t>(b)};
    first_triangle.push_back(static_cast<int32_t>(mesh.triangles.size()));
    // Directions may differ from triangle to triangle, so such a face is not taken for one.
    const bool has_faces = scene.surface_directions(id).size() <= 1;
    const bool moves = scene.motion(id) != Motion::Fixed;
    add_surface(bodies_[b], id.index, rest_positions_, has_faces, moves, surfaces);
    mesh.frames.push_back(find_body_frame(bodies_[b], rest_positions_));
    surfaces.group_distance.push_back(contact_distance(scene, id, settings));
    surfaces.stiffness.push_back(contact_stiffness(scene, *this, id, settings));
    surfaces.core.push_back(scene.contact_core(id));
    surfaces.is_sheet.push_back(row_of(bodies_[b].kind).is_thin);
  }
  for (const ModelLever& lever : levers_) {
    mesh.vertex_group[lever.site] = -1;  // of no surface, though on one
    surfaces.levers.push_back({bodies_[lever.body].first_site + lever.vertex,
                               first_triangle[lever.body] + lever.triangle, lever.site});
  }
  // Each triangle a face of its own: nothing to choose from, in every search for contacts.
  const auto triangles = std::views::iota(int32_t{0}, static_cast<int32_t>(surfaces.face.size()));
  if (std::ranges::equal(surfaces.face, triangles)) surfaces.face.clear();
  surfaces.filter = make_filter(scene, settings);
  for (size_t b = 0; b < bodies_.size(); ++b)
    if (has_nodes(bodies_[b].kind))
      set_neighbours(bodies_[b], rest_positions_, 2.0 * surfaces.group_distance[b], surfaces.filter);
  surfaces.rest_positions = rest_positions_;
  if (scene.has_anisotropic_friction()) surfaces.directions = make_directions(scene);
  if (scene.has_restitution()) surfaces.restitution = make_restitution(scene, settings);
  surfaces.moving = make_moving(scene);
  surfaces.friction = make_friction_table(scene);
  return surfaces;
}

std::vector<MovingSurface> Model::make_moving(const Scene& scene) const {
  std::vector<MovingSurface> moving;
  for (const auto& [index, motion] : scene.surface_motions()) {
    const ModelBody& body = bodies_[index];
    MovingSurface& surface = moving.emplace_back();
    surface.group = index;
    surface.sites = spanning_sites(body, rest_positions_);
    for (int k = 0; k < 3; ++k)
      surface.local[k] = scene.rest_vertices(BodyId{index})[surface.sites[k] - body.first_site];
    surface.motion = motion;
  }
  return moving;
}

RestitutionTable Model::make_restitution(const Scene& scene, const Settings& settings) const {
  RestitutionTable table;
  for (int32_t a = 0; a < scene.body_count(); ++a) {
    const ModelBody& body = bodies_[a];
    const bool is_rigid = stark::is_rigid(body.kind);
    const bool falls = is_rigid && map_.layout().body_block[body.rigid_index] != kNoBlock;
    table.gravity.push_back(falls ? settings.gravity : Vec3{});
    table.frame.push_back(is_rigid ? spanning_sites(body, rest_positions_) : std::array<int32_t, 3>{});
  }
  for (const auto& [pair, e] : scene.restitutions())
    table.coefficient[group_code(pair.first, pair.second)] = e;
  return table;
}

std::vector<TangentComponents> Model::make_directions(const Scene& scene) const {
  std::vector<TangentComponents> directions;
  for (size_t b = 0; b < bodies_.size(); ++b) {
    const BodyId id{static_cast<int32_t>(b)};
    const std::vector<Index3>& triangles = bodies_[b].triangles;
    const std::vector<Vec3> given = scene.surface_directions(id);
    if (given.empty()) {
      directions.resize(directions.size() + triangles.size());
      continue;
    }
    const std::vector<Vec3>& rest = scene.rest_vertices(id);
    for (size_t t = 0; t < triangles.size(); ++t) {
      const auto& [v0, v1, v2] = triangles[t];
      directions.push_back(
          tangent_components(rest[v0], rest[v1], rest[v2], given[given.size() == 1 ? 0 : t]));
    }
  }
  return directions;
}

void Model::mesh_pose(int32_t body, const State& state, Vec3& out_position, Mat3& out_rotation) const {
  const ModelBody& b = bodies_[body];
  out_rotation = state.body_rotation[b.rigid_index] * transpose(b.axes);
  out_position = state.body_position[b.rigid_index] - out_rotation * b.centre;
}

}  // namespace stark
