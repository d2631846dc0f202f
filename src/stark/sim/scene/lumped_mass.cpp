// See lumped_mass.h.
#include <stark/sim/scene/lumped_mass.h>

#include <numeric>

#include <stark/geometry/topology.h>
#include <stark/sim/scene/layers.h>
#include <stark/sim/scene/material_fields.h>

namespace stark {

namespace {

double sum(const std::vector<double>& masses) { return std::accumulate(masses.begin(), masses.end(), 0.0); }

double own_mass(const Scene& scene, BodyId body) {
  const BodyKindRow& row = row_of(scene.kind(body));
  return row.mass ? row.mass(scene, body) : sum(row.vertex_masses(scene, body));
}

}  // namespace

std::vector<double> lumped_masses(const ClothDescription& cloth) {
  std::vector<double> masses(cloth.mesh.vertices.size(), 0.0);
  const std::vector<double> areas = compute_triangle_areas(cloth.mesh.vertices, cloth.mesh.triangles);
  for (size_t t = 0; t < areas.size(); ++t)
    for (const int32_t v : cloth.mesh.triangles[t]) masses[v] += element_density(cloth, t) * areas[t] / 3.0;
  return masses;
}

std::vector<double> lumped_masses(const SolidDescription& solid) {
  std::vector<double> masses(solid.mesh.vertices.size(), 0.0);
  std::vector<double> volumes(solid.mesh.node_count());
  for (int64_t e = 0; e < solid.mesh.element_count(); ++e) {
    lump_volume(solid.mesh, e, volumes);
    for (int a = 0; a < solid.mesh.node_count(); ++a)
      masses[solid.mesh.element(e)[a]] += element_density(solid, static_cast<size_t>(e)) * volumes[a];
  }
  return masses;
}

std::vector<double> lumped_masses(const Scene& scene, const SkinDescription& skin) {
  return lumped_masses(sheet_of(scene, skin));
}

std::vector<double> lumped_masses(const Scene& scene, const FibresDescription& fibres) {
  std::vector<double> masses(scene.rest_vertices(fibres.body).size(), 0.0);
  const std::vector<double> of_edges = fibre_masses(scene, fibres);
  size_t e = 0;
  for (const auto& path : fibres.paths)
    for (size_t k = 0; k + 1 < path.size(); ++k, ++e)
      for (const int32_t v : {path[k], path[k + 1]}) masses[v] += 0.5 * of_edges[e];
  return masses;
}

double total_mass(const Scene& scene, BodyId body) {
  double mass = own_mass(scene, body);
  for (const SkinDescription& skin : scene.skins())
    if (skin.body == body) mass += total_mass(scene, skin);
  for (const FibresDescription& fibres : scene.fibres())
    if (fibres.body == body) mass += total_mass(scene, fibres);
  return mass;
}

double total_mass(const Scene& scene, const SkinDescription& skin) { return sum(lumped_masses(scene, skin)); }

double total_mass(const Scene& scene, const FibresDescription& fibres) {
  return sum(fibre_masses(scene, fibres));
}

}  // namespace stark
