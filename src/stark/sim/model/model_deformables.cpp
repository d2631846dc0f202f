// Cloth and solids of a model: points, masses, elastic energies.
#include <algorithm>
#include <array>
#include <cmath>

#include <stark/geometry/embedding.h>
#include <stark/geometry/topology.h>
#include <stark/mechanics/rest_state.h>
#include <stark/sim/model/model_builder.h>
#include <stark/sim/scene/lumped_mass.h>
#include <stark/sim/scene/material_fields.h>

namespace stark {

namespace models {
ShellLaw membrane_strain_limit_law();
PotentialDefinition grown_edge_strain_limit(const std::set<std::string>& fields, bool is_solid);
}  // namespace models

namespace {

/// Each edge of an element stands for the same part of its volume.
WeightedEdges solid_edges(const SolidMesh& mesh) {
  WeightedEdges result{find_edges(mesh), {}};
  result.weights.assign(result.edges.size(), 0.0);
  const std::vector<double> volumes = compute_element_volumes(mesh);
  const auto& edges = reference_element(mesh.type).edges;
  for (int64_t e = 0; e < mesh.element_count(); ++e)
    for (const Index2& local : edges) {
      const int32_t a = mesh.element(e)[local[0]], b = mesh.element(e)[local[1]];
      const Index2 edge{std::min(a, b), std::max(a, b)};
      result
          .weights[std::lower_bound(result.edges.begin(), result.edges.end(), edge) - result.edges.begin()] +=
          volumes[e] / static_cast<double>(edges.size());
    }
  return result;
}

template <typename Material>
bool limits_strain(const Material& material) {
  return std::isfinite(material.strain_limit) && material.strain_limit_stiffness > 0.0;
}

/// Names of what changes the shape at rest.
template <typename Description>
std::set<std::string> stretching_fields(const Description& body) {
  std::set<std::string> names;
  for (const auto& [name, values] : body.rest_state) names.insert(name);
  return rest_state::stretching(names);
}

/// Parameters of the limit, and what changes the shape at rest.
template <typename Description>
ParameterValues limit_values(const Description& body) {
  ParameterValues values{{"strain_limit", {{body.material.strain_limit}, false}},
                         {"strain_limit_stiffness", {{body.material.strain_limit_stiffness}, false}},
                         {"strain_limit_hardening", {{body.material.strain_limit_hardening}, false}}};
  if (stretching_fields(body).empty()) return values;
  const ParameterValues elastic = elastic_energy(body).values;
  for (const char* name : {rest_state::kGrowth, rest_state::kTemperature, rest_state::kThermalExpansion})
    if (const auto found = elastic.find(name); found != elastic.end()) values.insert(*found);
  return values;
}

}  // namespace

void Model::Builder::add_deformables() {
  model.bodies_.resize(scene.body_count());
  for (int32_t i = 0; i < scene.body_count(); ++i) {
    const BodyId id{i};
    ModelBody& body = model.bodies_[i];
    body.kind = scene.kind(id);
    if (!row_of(body.kind).surface) body.edges = edges_of(scene, id);
    if (!has_points(body.kind)) continue;
    const std::vector<Vec3>& rest = scene.rest_vertices(id);
    body.first_site = static_cast<int32_t>(sites.size());
    body.site_count = static_cast<int32_t>(rest.size());
    body.pins = scene.pins(id).vertices;
    for (const Vec3& X : rest) {
      const auto point = static_cast<int32_t>(sites.size());
      add_site({.kind = SiteKind::Point, .index = point, .local = {}, .points = {}, .weights = {}}, X);
      point_prescribed.push_back(false);
      model.point_masses_.push_back(0.0);
      model.point_damping_.push_back(0.0);
    }
    if (const SolidMesh* mesh = scene.solid_mesh(id)) add_embedded_sites(*mesh, body);
    for (const int32_t pin : body.pins) point_prescribed[body.first_site + pin] = true;
    body.triangles = scene.surface_triangles(id);
    set_masses(body, row_of(body.kind).vertex_masses(scene, id), scene.visit(id, [](const auto& b) {
      if constexpr (requires { b.material; }) return b.material.mass_damping;
      return 0.0;
    }));
  }
}

void Model::Builder::add_embedded_sites(const SolidMesh& mesh, const ModelBody& body) {
  std::vector<double> weights(mesh.node_count());
  std::vector<int32_t> support_of(mesh.is_embedded() ? mesh.element_count() : 0, -1);
  for (size_t k = 0; k < mesh.embedding.elements.size(); ++k) {
    const int32_t element = mesh.embedding.elements[k];
    if (support_of[element] < 0) {
      std::vector<int32_t> nodes(mesh.element(element).begin(), mesh.element(element).end());
      for (int32_t& node : nodes) node += body.first_site;
      support_of[element] = embedded.add_support(nodes);
    }
    embedding_weights(mesh, k, weights);
    const size_t p = body.first_site + mesh.first_embedded() + k;
    sites[p].kind = SiteKind::Embedded;
    sites[p].index = embedded.add_row(support_of[element], weights);
    point_prescribed[p] = true;  // it has no unknowns of its own
  }
}

void Model::Builder::set_masses(const ModelBody& body, std::span<const double> masses, double damping) {
  for (int32_t v = 0; v < body.site_count; ++v) {
    model.point_masses_[body.first_site + v] = masses[v];
    model.point_damping_[body.first_site + v] = damping;
  }
}

void Model::Builder::add_edge_limit(const WeightedEdges& edges, double scale, double limit, double stiffness,
                                    const ModelBody& body, const std::string& name) {
  PotentialBatch& batch =
      add_batch(models::edge_strain_limit(), offset_stencils(edges.edges, body.first_site), name);
  for (int64_t e = 0; e < batch.size(); ++e) batch.set("volume", e, scale * edges.weights[e]);
  batch.set_uniform("strain_limit", limit);
  batch.set_uniform("strain_limit_stiffness", stiffness);
}

void Model::Builder::add_grown_edge_limit(std::span<const Index2> edges, std::span<const int32_t> elements,
                                          std::span<const double> volumes,
                                          const PotentialDefinition& definition, ParameterValues values,
                                          const std::string& name) {
  values.erase("strain_limit_hardening");
  const size_t nodes = elements.size() / volumes.size();
  for (const Index2& edge : edges) {
    std::vector<int32_t> stencils;
    for (size_t e = 0; e < volumes.size(); ++e)
      stencils.insert(stencils.end(), {elements[e * nodes + edge[0]], elements[e * nodes + edge[1]]});
    PotentialBatch& batch = add_batch(definition, stencils, name, values);
    for (int64_t e = 0; e < batch.size(); ++e)
      batch.set("volume", e, volumes[e] / static_cast<double>(edges.size()));
  }
}

void Model::Builder::add_strain_limit(const ClothDescription& sheet, const ModelBody& body,
                                      const std::string& name) {
  const ShellMaterial& material = sheet.material;
  if (!limits_strain(material)) return;
  const std::vector<Index3>& triangles = sheet.mesh.triangles;
  const std::set<std::string> fields = stretching_fields(sheet);
  ParameterValues values = limit_values(sheet);
  if (material.strain_limit_law == StrainLimitLaw::GreenStrain) {
    values["thickness"] = {{material.thickness}, false};
    const PotentialDefinition definition =
        fields.empty() ? models::membrane_strain_limit()
                       : triangle3(rest_state::with_fields(models::membrane_strain_limit_law(), fields));
    add_stress_batch(definition, offset_stencils(triangles, body.first_site), name, values);
  } else if (fields.empty()) {
    const std::vector<Index2> edges = find_edges(std::span<const Index3>(triangles));
    add_edge_limit({edges, compute_edge_areas(sheet.mesh.vertices, triangles, edges)}, material.thickness,
                   material.strain_limit, material.strain_limit_stiffness, body, name);
  } else {
    constexpr std::array<Index2, 3> kEdges{{{0, 1}, {1, 2}, {2, 0}}};
    std::vector<double> volumes = compute_triangle_areas(sheet.mesh.vertices, triangles);
    for (double& volume : volumes) volume *= material.thickness;
    add_grown_edge_limit(kEdges, offset_stencils(triangles, body.first_site), volumes,
                         models::grown_edge_strain_limit(fields, false), values, name);
  }
}

void Model::Builder::add_strain_limit(const SolidDescription& solid, const ModelBody& body,
                                      const std::string& name) {
  const SolidMaterial& material = solid.material;
  if (!limits_strain(material)) return;
  const std::set<std::string> fields = stretching_fields(solid);
  if (material.strain_limit_law == StrainLimitLaw::GreenStrain) {
    const auto element = solid.mesh.type == ElementType::Tet4 ? tet4 : quadrature_point;
    const SolidLaw law = models::strain_limit();
    add_elements(solid.mesh,
                 {element(fields.empty() ? law : rest_state::with_fields(law, fields)), limit_values(solid)},
                 body, name);
  } else if (fields.empty()) {
    add_edge_limit(solid_edges(solid.mesh), 1.0, material.strain_limit, material.strain_limit_stiffness, body,
                   name);
  } else {
    std::vector<int32_t> elements = solid.mesh.elements;
    for (int32_t& site : elements) site += body.first_site;
    add_grown_edge_limit(reference_element(solid.mesh.type).edges, elements,
                         compute_element_volumes(solid.mesh), models::grown_edge_strain_limit(fields, true),
                         limit_values(solid), name);
  }
}

void Model::Builder::add_energies(BodyId id, const ClothDescription& cloth) {
  add_shell_energies(cloth, model.bodies_[id.index], scene.name(id));
}

void Model::Builder::add_shell_energies(const ClothDescription& sheet, const ModelBody& body,
                                        const std::string& name) {
  const ElasticEnergy membrane = elastic_energy(sheet);
  add_stress_batch(membrane.definition, offset_stencils(sheet.mesh.triangles, body.first_site), name,
                   membrane.values);
  add_bending(sheet, body, name);
  add_strain_limit(sheet, body, name);
}

void Model::Builder::add_quadrature_batch(const SolidMesh& mesh, const ElasticEnergy& elastic,
                                          std::span<const int32_t> stencils, const std::string& body) {
  const std::vector<QuadraturePoint>& rule = reference_element(mesh.type).quadrature;
  const size_t nodes = static_cast<size_t>(mesh.node_count());
  const auto law = compile(elastic.definition, per_element_names(elastic.values));
  const int points = static_cast<int>(rule.size());
  QuadratureBatch batch =
      law->point_count() == 3
          ? QuadratureBatch(law, mesh.node_count(), points)
          : QuadratureBatch(law, mesh.node_count(), points,
                            {compile(volume_ratio()), points, mean_dilatation_modes(mesh.type)});
  batch.resize(stencils);
  std::vector<Vec3> gradients(rule.size() * nodes);
  std::vector<double> volumes(rule.size());
  std::vector<Vec3> positions(rule.size());
  for (int64_t e = 0; e < mesh.element_count(); ++e) {
    const std::vector<QuadraturePoint> of_element = quadrature_rule(mesh, e);
    for (size_t q = 0; q < rule.size(); ++q) {
      const Vec3& place = of_element[q].position;
      rest_gradients(mesh, e, place, std::span(gradients).subspan(q * nodes, nodes));
      positions[q] = rest_position(mesh, e, place);
      volumes[q] = of_element[q].weight;
    }
    batch.set_geometry(e, gradients, volumes, positions);
  }
  batch.set_values(elastic.values);
  energies.quadrature.push_back({body, std::move(batch)});
}

void Model::Builder::add_energies(BodyId id, const SolidDescription& solid) {
  const ModelBody& body = model.bodies_[id.index];
  add_elements(solid.mesh, elastic_energy(solid), body, scene.name(id));
  add_strain_limit(solid, body, scene.name(id));
}

void Model::Builder::add_elements(const SolidMesh& mesh, const ElasticEnergy& energy, const ModelBody& body,
                                  const std::string& name) {
  std::vector<int32_t> stencils = mesh.elements;
  for (int32_t& site : stencils) site += body.first_site;
  if (mesh.type == ElementType::Tet4)
    add_stress_batch(energy.definition, stencils, name, energy.values);
  else
    add_quadrature_batch(mesh, energy, stencils, name);
}

}  // namespace stark
