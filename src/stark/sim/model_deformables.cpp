// Cloth and solids of a model: points, lumped masses, elastic energies.
#include <algorithm>
#include <cmath>

#include <stark/geometry/topology.h>
#include <stark/sim/material_fields.h>
#include <stark/sim/model_builder.h>

namespace stark {

namespace {

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

void Model::Builder::add_deformables() {
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

void Model::Builder::lump_cloth(const ClothDescription& cloth, ModelBody& body) {
  body.triangles = cloth.mesh.triangles;
  const std::vector<double> areas = compute_triangle_areas(cloth.mesh.vertices, cloth.mesh.triangles);
  for (size_t t = 0; t < areas.size(); ++t)
    for (const int32_t v : cloth.mesh.triangles[t])
      model.point_masses_[body.first_site + v] += element_density(cloth, t) * areas[t] / 3.0;
  for (int32_t v = 0; v < body.site_count; ++v)
    point_damping[body.first_site + v] = cloth.material.mass_damping;
}

void Model::Builder::lump_solid(const SolidDescription& solid, ModelBody& body) {
  body.triangles = find_boundary_triangles(std::span<const Index4>(solid.mesh.tets));
  const std::vector<double> volumes = compute_tet_volumes(solid.mesh.vertices, solid.mesh.tets);
  for (size_t e = 0; e < volumes.size(); ++e)
    for (const int32_t v : solid.mesh.tets[e])
      model.point_masses_[body.first_site + v] += element_density(solid, e) * volumes[e] / 4.0;
  for (int32_t v = 0; v < body.site_count; ++v)
    point_damping[body.first_site + v] = solid.material.mass_damping;
}

void Model::Builder::add_strain_limit(const WeightedEdges& edges, double scale, double limit,
                                      double stiffness, const ModelBody& body, const std::string& name) {
  if (!std::isfinite(limit)) return;
  PotentialBatch& batch =
      add_batch(models::strain_limit(), offset_stencils(edges.edges, body.first_site), name);
  for (int64_t e = 0; e < batch.size(); ++e) batch.set("volume", e, scale * edges.weights[e]);
  batch.set_uniform("strain_limit", limit);
  batch.set_uniform("strain_limit_stiffness", stiffness);
}

void Model::Builder::add_cloth_energies(BodyId id) {
  const ClothDescription& cloth = scene.cloth(id);
  const ShellMaterial& material = cloth.material;
  const ModelBody& body = model.bodies_[id.index];
  const std::string& name = scene.name(id);

  const ElasticEnergy membrane = elastic_energy(cloth);
  add_batch(membrane.definition, offset_stencils(body.triangles, body.first_site), name, membrane.values);

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

void Model::Builder::add_solid_energies(BodyId id) {
  const SolidDescription& solid = scene.solid(id);
  const SolidMaterial& material = solid.material;
  const ModelBody& body = model.bodies_[id.index];
  const std::string& name = scene.name(id);

  const ElasticEnergy elastic = elastic_energy(solid);
  add_batch(elastic.definition, offset_stencils(solid.mesh.tets, body.first_site), name, elastic.values);
  add_strain_limit(solid_edges(solid.mesh), 1.0, material.strain_limit, material.strain_limit_stiffness, body,
                   name);
}

}  // namespace stark
