#include <stark/sim/model.h>

#include <algorithm>
#include <cmath>

#include <stark/base/error.h>
#include <stark/base/hash.h>
#include <stark/geometry/mass_properties.h>
#include <stark/geometry/topology.h>
#include <stark/sim/registry.h>

namespace stark {

namespace {

symbolic::Backend to_backend(KernelBackend backend) { return static_cast<symbolic::Backend>(backend); }

/// Edges of the mesh and the part of a measure (area, volume) of its elements that each stands for.
struct WeightedEdges {
  std::vector<Index2> edges;
  std::vector<double> weights;
};

WeightedEdges solid_edges(const TetMesh& mesh) {
  WeightedEdges result{find_edges(std::span<const Index4>(mesh.tets)), {}};
  result.weights.assign(result.edges.size(), 0.0);
  for (const Index4& t : mesh.tets) {
    const Vec3& a = mesh.vertices[t[0]];
    const double volume =
        dot(mesh.vertices[t[1]] - a, cross(mesh.vertices[t[2]] - a, mesh.vertices[t[3]] - a)) / 6.0;
    for (int i = 0; i < 4; ++i)
      for (int j = i + 1; j < 4; ++j) {
        const Index2 edge{std::min(t[i], t[j]), std::max(t[i], t[j])};
        result.weights[std::lower_bound(result.edges.begin(), result.edges.end(), edge) -
                       result.edges.begin()] += volume / 6.0;
      }
  }
  return result;
}

}  // namespace

/// Collects everything body by body; one method per kind of body and per family of energies.
struct Model::Builder {
  Builder(Model& m, const Scene& s, const Settings& t) : model(m), scene(s), settings(t) {}

  void build() {
    add_deformables();
    add_rigids();
    DofLayout layout = DofLayout::build(point_prescribed, body_prescribed);
    add_rigid_sites();
    model.map_ = KinematicMap(std::move(layout), std::move(sites));
    for (int32_t i = 0; i < scene.body_count(); ++i) {
      if (scene.kind(BodyId{i}) == BodyKind::Cloth) add_cloth_energies(BodyId{i});
      if (scene.kind(BodyId{i}) == BodyKind::Solid) add_solid_energies(BodyId{i});
    }
    add_inertia();
    for (ModelBatch& batch : model.batches_) batch.batch.set_rest(model.rest_positions_);
    set_block_scales();
    set_initial_state();
    compile_contact();
  }

  std::shared_ptr<const Potential> compile(const PotentialDefinition& definition) const {
    return std::make_shared<Potential>(definition, to_backend(settings.execution.backend));
  }

  // Points
  // ------------------------------------------------------------------------------------------------------------

  void add_deformables() {
    model.bodies_.resize(scene.body_count());
    for (int32_t i = 0; i < scene.body_count(); ++i) {
      const BodyId id{i};
      ModelBody& body = model.bodies_[i];
      body.kind = scene.kind(id);
      if (body.kind == BodyKind::Rigid) continue;
      const std::vector<Vec3>& rest =
          body.kind == BodyKind::Cloth ? scene.cloth(id).mesh.vertices : scene.solid(id).mesh.vertices;
      body.first_site = static_cast<int32_t>(sites.size());
      body.site_count = static_cast<int32_t>(rest.size());
      body.pins = scene.pins(id).vertices;
      for (const Vec3& X : rest) {
        sites.push_back({.kind = SiteKind::Point,
                         .index = static_cast<int32_t>(sites.size()),
                         .local = {},
                         .points = {},
                         .weights = {}});
        model.rest_positions_.push_back(X);
        point_prescribed.push_back(false);
        model.point_masses_.push_back(0.0);
        point_damping.push_back(0.0);
      }
      for (const int32_t pin : body.pins) point_prescribed[body.first_site + pin] = true;
      if (body.kind == BodyKind::Cloth)
        lump_cloth(scene.cloth(id), body);
      else
        lump_solid(scene.solid(id), body);
    }
  }

  void lump_cloth(const ClothDescription& cloth, ModelBody& body) {
    body.triangles = cloth.mesh.triangles;
    const std::vector<double> areas = compute_vertex_areas(cloth.mesh.vertices, cloth.mesh.triangles);
    for (int32_t v = 0; v < body.site_count; ++v) {
      model.point_masses_[body.first_site + v] = cloth.material.density * areas[v];
      point_damping[body.first_site + v] = cloth.material.mass_damping;
    }
  }

  void lump_solid(const SolidDescription& solid, ModelBody& body) {
    body.triangles = find_boundary_triangles(std::span<const Index4>(solid.mesh.tets));
    for (const Index4& t : solid.mesh.tets) {
      const auto& X = solid.mesh.vertices;
      const double volume = dot(X[t[1]] - X[t[0]], cross(X[t[2]] - X[t[0]], X[t[3]] - X[t[0]])) / 6.0;
      for (const int32_t v : t)
        model.point_masses_[body.first_site + v] += solid.material.density * volume / 4.0;
    }
    for (int32_t v = 0; v < body.site_count; ++v)
      point_damping[body.first_site + v] = solid.material.mass_damping;
  }

  // Rigid bodies
  // ------------------------------------------------------------------------------------------------------

  void add_rigids() {
    for (int32_t i = 0; i < scene.body_count(); ++i) {
      const BodyId id{i};
      if (scene.kind(id) != BodyKind::Rigid) continue;
      const RigidDescription& rigid = scene.rigid(id);
      ModelBody& body = model.bodies_[i];
      body.rigid_index = static_cast<int32_t>(model.rigid_masses_.size());
      body.triangles = rigid.mesh.triangles;
      body.site_count = static_cast<int32_t>(rigid.mesh.vertices.size());
      RigidMass mass;
      if (rigid.motion == Motion::Dynamic) {
        const RigidInertia& inertia = scene.rigid_inertia(id);
        const PrincipalAxes principal = compute_principal_axes(inertia.tensor);
        mass.mass = inertia.mass;
        mass.moments = principal.values;
        for (int k = 0; k < 3; ++k)
          mass.second_moments[k] =
              std::max(0.0, 0.5 * (mass.moments.x + mass.moments.y + mass.moments.z) - mass.moments[k]);
        mass.linear_damping = rigid.linear_damping;
        mass.angular_damping = rigid.angular_damping;
        body.centre = inertia.center_of_mass;
        body.axes = principal.axes;
      }
      for (const Vec3& v : rigid.mesh.vertices) mass.reach = std::max(mass.reach, norm(v - body.centre));
      model.rigid_masses_.push_back(mass);
      rigid_bodies.push_back(i);
      body_prescribed.push_back(rigid.motion != Motion::Dynamic);
    }
  }

  void add_rigid_sites() {
    const Mat3 identity = Mat3::identity();
    for (const int32_t i : rigid_bodies) {
      ModelBody& body = model.bodies_[i];
      body.first_site = static_cast<int32_t>(sites.size());
      for (const Vec3& v : scene.rigid(BodyId{i}).mesh.vertices) {
        sites.push_back({.kind = SiteKind::RigidPoint,
                         .index = body.rigid_index,
                         .local = transpose(body.axes) * (v - body.centre),
                         .points = {},
                         .weights = {}});
        model.rest_positions_.push_back(v);
      }
    }
    for (const int32_t i : rigid_bodies) {
      const ModelBody& body = model.bodies_[i];
      if (body_prescribed[body.rigid_index]) continue;
      centre_sites.push_back(static_cast<int32_t>(sites.size()));
      sites.push_back({.kind = SiteKind::RigidPoint,
                       .index = body.rigid_index,
                       .local = {},
                       .points = {},
                       .weights = {}});
      for (int k = 0; k < 3; ++k)
        sites.push_back({.kind = SiteKind::RigidDirection,
                         .index = body.rigid_index,
                         .local = identity.column(k),
                         .points = {},
                         .weights = {}});
      model.rest_positions_.resize(sites.size());
    }
  }

  // Energies
  // ----------------------------------------------------------------------------------------------------------

  PotentialBatch& add_batch(const PotentialDefinition& definition, std::span<const int32_t> stencils,
                            const std::string& body) {
    ModelBatch& batch = model.batches_.emplace_back(
        ModelBatch{ModelBatch::Role::Elastic, body, PotentialBatch(compile(definition)), {}});
    batch.batch.resize(stencils);
    return batch.batch;
  }

  template <typename Element>
  static std::vector<int32_t> offset_stencils(const std::vector<Element>& elements, int32_t first_site) {
    std::vector<int32_t> stencils;
    for (const Element& element : elements)
      for (const int32_t v : element) stencils.push_back(first_site + v);
    return stencils;
  }

  void add_strain_limit(const WeightedEdges& edges, double scale, double limit, double stiffness,
                        const ModelBody& body, const std::string& name) {
    if (!std::isfinite(limit)) return;
    PotentialBatch& batch =
        add_batch(models::strain_limit(), offset_stencils(edges.edges, body.first_site), name);
    for (int64_t e = 0; e < batch.size(); ++e) batch.set("volume", e, scale * edges.weights[e]);
    batch.set_uniform("strain_limit", limit);
    batch.set_uniform("strain_limit_stiffness", stiffness);
  }

  void add_cloth_energies(BodyId id) {
    const ClothDescription& cloth = scene.cloth(id);
    const ShellMaterial& material = cloth.material;
    const ModelBody& body = model.bodies_[id.index];
    const std::string& name = scene.name(id);

    std::vector<PotentialDefinition> terms{models::membrane_neo_hookean()};
    if (material.strain_damping > 0.0) terms.push_back(models::membrane_damping());
    PotentialBatch& membrane =
        add_batch(compose("membrane", terms), offset_stencils(body.triangles, body.first_site), name);
    membrane.set_uniform("youngs_modulus", material.youngs_modulus);
    membrane.set_uniform("poissons_ratio", material.poissons_ratio);
    membrane.set_uniform("thickness", material.thickness);
    if (material.strain_damping > 0.0) membrane.set_uniform("strain_damping", material.strain_damping);

    if (material.bending_stiffness > 0.0 || material.bending_damping > 0.0) {
      const std::vector<Index4> hinges = find_hinges(body.triangles);
      PotentialBatch& bending = add_batch(
          cloth.rest_angles == RestAngles::Flat ? models::flat_bending() : models::discrete_shell_bending(),
          offset_stencils(hinges, body.first_site), name);
      bending.set_uniform("bending_stiffness", material.bending_stiffness);
      bending.set_uniform("bending_damping", material.bending_damping);
    }
    const std::vector<Index2> edges = find_edges(std::span<const Index3>(body.triangles));
    add_strain_limit({edges, compute_edge_areas(cloth.mesh.vertices, body.triangles, edges)},
                     material.thickness, material.strain_limit, material.strain_limit_stiffness, body, name);
  }

  void add_solid_energies(BodyId id) {
    const SolidDescription& solid = scene.solid(id);
    const SolidMaterial& material = solid.material;
    const ModelBody& body = model.bodies_[id.index];
    const std::string& name = scene.name(id);

    std::vector<PotentialDefinition> terms{models::stable_neo_hookean()};
    if (material.strain_damping > 0.0) terms.push_back(models::solid_damping());
    PotentialBatch& elastic =
        add_batch(compose("solid", terms), offset_stencils(solid.mesh.tets, body.first_site), name);
    elastic.set_uniform("youngs_modulus", material.youngs_modulus);
    elastic.set_uniform("poissons_ratio", material.poissons_ratio);
    if (material.strain_damping > 0.0) elastic.set_uniform("strain_damping", material.strain_damping);
    add_strain_limit(solid_edges(solid.mesh), 1.0, material.strain_limit, material.strain_limit_stiffness,
                     body, name);
  }

  void add_inertia() {
    // Translation of points and centres of mass, with gravity; rotation of bodies through their axis
    // directions.
    std::vector<int32_t> translations, rotations, translation_subjects, rotation_subjects;
    for (size_t p = 0; p < point_prescribed.size(); ++p)
      if (!point_prescribed[p]) {
        translations.push_back(static_cast<int32_t>(p));
        translation_subjects.push_back(static_cast<int32_t>(p));
      }
    size_t next = 0;
    for (size_t b = 0; b < body_prescribed.size(); ++b) {
      if (body_prescribed[b]) continue;
      const int32_t centre = centre_sites[next++];
      translations.push_back(centre);
      translation_subjects.push_back(-1 - static_cast<int32_t>(b));
      for (int k = 0; k < 3; ++k) {
        rotations.push_back(centre + 1 + k);
        rotation_subjects.push_back(static_cast<int32_t>(3 * b) + k);
      }
    }
    PotentialBatch& moving =
        add_batch(compose("inertia", {models::point_inertia(), models::gravity()}), translations, "");
    for (int64_t e = 0; e < moving.size(); ++e) {
      const int32_t subject = translation_subjects[e];
      moving.set("mass", e,
                 subject >= 0 ? model.point_masses_[subject] : model.rigid_masses_[-1 - subject].mass);
      moving.set("damping", e,
                 subject >= 0 ? point_damping[subject] : model.rigid_masses_[-1 - subject].linear_damping);
    }
    moving.set_uniform("gravity", {&settings.gravity.x, 3});
    model.batches_.back().role = ModelBatch::Role::Inertia;
    model.batches_.back().subject = translation_subjects;
    PotentialBatch& turning = add_batch(models::point_inertia(), rotations, "");
    for (int64_t e = 0; e < turning.size(); ++e) {
      const RigidMass& mass = model.rigid_masses_[rotation_subjects[e] / 3];
      turning.set("mass", e, mass.second_moments[rotation_subjects[e] % 3]);
      turning.set("damping", e, mass.angular_damping);
    }
    model.batches_.back().role = ModelBatch::Role::Inertia;
    model.batches_.back().subject = rotation_subjects;
  }

  void set_block_scales() {
    const DofLayout& layout = model.map_.layout();
    model.block_scales_.resize(layout.block_count);
    for (size_t p = 0; p < layout.point_block.size(); ++p)
      if (layout.point_block[p] != kNoBlock)
        model.block_scales_[layout.point_block[p]].inverse_inertia = 1.0 / model.point_masses_[p];
    for (size_t b = 0; b < layout.body_block.size(); ++b) {
      if (layout.body_block[b] == kNoBlock) continue;
      const RigidMass& mass = model.rigid_masses_[b];
      const double smallest = std::min({mass.moments.x, mass.moments.y, mass.moments.z});
      model.block_scales_[layout.body_block[b]].inverse_inertia = 1.0 / mass.mass;
      model.block_scales_[layout.body_block[b] + 1] = {
          .inverse_inertia = mass.reach / smallest, .inverse_length = 1.0 / mass.reach, .reach = mass.reach};
    }
  }

  void set_initial_state() {
    State& state = model.initial_state_;
    state.time_step = settings.time.step;
    for (int32_t i = 0; i < scene.body_count(); ++i) {
      const BodyId id{i};
      if (scene.kind(id) == BodyKind::Rigid) continue;
      const std::vector<Vec3> x = scene.initial_positions(id), v = scene.initial_velocities(id);
      state.point_position.insert(state.point_position.end(), x.begin(), x.end());
      state.point_velocity.insert(state.point_velocity.end(), v.begin(), v.end());
    }
    for (size_t p = 0; p < point_prescribed.size(); ++p)
      if (point_prescribed[p]) state.point_velocity[p] = {};
    for (const int32_t i : rigid_bodies) {
      const RigidDescription& rigid = scene.rigid(BodyId{i});
      const ModelBody& body = model.bodies_[i];
      const bool moves = rigid.motion != Motion::Fixed;
      state.body_position.push_back(rigid.position + rigid.rotation * body.centre);
      state.body_velocity.push_back(moves ? rigid.velocity : Vec3{});
      state.body_rotation.push_back(rigid.rotation * body.axes);
      state.body_rotation_rate.push_back(moves ? skew(rigid.angular_velocity) * state.body_rotation.back()
                                               : Mat3{});
    }
    state.script_position = state.body_position;
    state.script_rotation = state.body_rotation;
    state.script_remaining.assign(state.body_position.size(), 0.0);
    state.pin_target = state.point_position;
  }

  void compile_contact() {
    if (settings.contact.enabled)
      model.contact_potentials_ = compile_contact_potentials(to_backend(settings.execution.backend));
  }

  Model& model;
  const Scene& scene;
  const Settings& settings;
  std::vector<Site> sites;
  std::vector<bool> point_prescribed, body_prescribed;
  std::vector<double> point_damping;
  std::vector<int32_t> rigid_bodies;  ///< body ids in the order of the state's body arrays
  std::vector<int32_t> centre_sites;  ///< of the dynamic ones; the three directions follow
};

Model::Model(const Scene& scene, const Settings& settings) {
  Builder(*this, scene, settings).build();
  Hash64 hash;
  for (const ModelBatch& batch : batches_) {
    for (const char c : batch.batch.potential().name()) hash.append(c);
    for (const int32_t site : batch.batch.stencils()) hash.append(site);
  }
  for (const Vec3& X : rest_positions_) hash.append(X);
  for (const double mass : point_masses_) hash.append(mass);
  fingerprint_ = hash.value();
}

ContactSurfaces Model::make_surfaces(const Scene& scene, const Settings& settings) const {
  ContactSurfaces surfaces;
  SurfaceMesh& mesh = surfaces.mesh;
  mesh.vertex_count = map_.site_count();
  mesh.vertex_group.assign(mesh.vertex_count, 0);
  for (size_t b = 0; b < bodies_.size(); ++b) {
    const ModelBody& body = bodies_[b];
    const int32_t group = static_cast<int32_t>(b);
    for (int32_t v = 0; v < body.site_count; ++v) mesh.vertex_group[body.first_site + v] = group;
    for (const Index3& t : body.triangles) {
      mesh.triangles.push_back({body.first_site + t[0], body.first_site + t[1], body.first_site + t[2]});
      mesh.triangle_group.push_back(group);
    }
    for (const Index2& e : find_edges(std::span<const Index3>(body.triangles))) {
      mesh.edges.push_back({body.first_site + e[0], body.first_site + e[1]});
      mesh.edge_group.push_back(group);
    }
    surfaces.group_distance.push_back(
        scene.contact_distance(BodyId{group}).value_or(settings.contact.distance));
  }
  const int32_t groups = static_cast<int32_t>(bodies_.size());
  surfaces.filter = PairFilter(groups);
  for (int32_t a = 0; a < groups; ++a)
    for (int32_t b = a; b < groups; ++b)
      surfaces.filter.set(
          a, b, scene.contact_enabled(BodyId{a}, BodyId{b}) && (a != b || settings.contact.self_contact));
  surfaces.rest_positions = rest_positions_;
  std::vector<double> friction(static_cast<size_t>(groups) * groups);
  for (int32_t a = 0; a < groups; ++a)
    for (int32_t b = 0; b < groups; ++b) friction[a * groups + b] = scene.friction(BodyId{a}, BodyId{b});
  surfaces.friction = [friction, groups](int32_t a, int32_t b) { return friction[a * groups + b]; };
  return surfaces;
}

void Model::mesh_pose(int32_t body, const State& state, Vec3& out_position, Mat3& out_rotation) const {
  const ModelBody& b = bodies_[body];
  out_rotation = state.body_rotation[b.rigid_index] * transpose(b.axes);
  out_position = state.body_position[b.rigid_index] - out_rotation * b.centre;
}

}  // namespace stark
