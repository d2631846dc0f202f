// See layers.h.
#include <stark/sim/layers.h>

#include <stark/geometry/polyline.h>
#include <stark/sim/material_fields.h>

namespace stark {

namespace {

/// Position, rotation and shape at time 0 of the body of a layer.
struct Placement {
  Mat3 rotation;
  std::span<const Vec3> initial_positions;  ///< in the frame of the body; empty: the rest shape
};

Placement placement_of(const Scene& scene, BodyId body) {
  if (scene.kind(body) == BodyKind::Cloth)
    return {scene.cloth(body).rotation, scene.cloth(body).initial_positions};
  return {scene.solid(body).rotation, scene.solid(body).initial_positions};
}

}  // namespace

ClothDescription sheet_of(const Scene& scene, const SkinDescription& skin) {
  ClothDescription sheet;
  sheet.name = skin.name;
  sheet.mesh = {scene.rest_vertices(skin.body), skin.triangles};
  sheet.material = skin.material;
  sheet.law = skin.law;
  sheet.fields = skin.fields;
  sheet.rest_angles = skin.rest_angles;
  return sheet;
}

std::vector<Vec3> path_points(const std::vector<int32_t>& path, std::span<const Vec3> vertices) {
  std::vector<Vec3> points;
  if (is_ring(path)) points.push_back(vertices[path[path.size() - 2]]);
  for (const int32_t v : path) points.push_back(vertices[v]);
  return points;
}

PathFrames path_frames(const Scene& scene, const FibresDescription& fibres,
                       const std::vector<int32_t>& path) {
  const Placement place = placement_of(scene, fibres.body);
  PathFrames frames;
  frames.rest = polyline_frames(path_points(path, scene.rest_vertices(fibres.body)), fibres.normal);
  frames.initial = frames.rest;
  if (!place.initial_positions.empty()) {
    const std::vector<Vec3> points = path_points(path, place.initial_positions);
    const Mat3& first = frames.rest.front();
    frames.initial = polyline_frames(
        points, transported(first.column(0), first.column(2), polyline_tangents(points).front()));
  }
  for (Mat3& frame : frames.initial) frame = place.rotation * frame;
  if (is_ring(path))
    for (std::vector<Mat3>* list : {&frames.rest, &frames.initial}) {
      list->erase(list->begin());
      list->pop_back();
    }
  return frames;
}

std::vector<double> fibre_lengths(const Scene& scene, const FibresDescription& fibres) {
  const std::vector<Vec3>& X = scene.rest_vertices(fibres.body);
  std::vector<double> lengths;
  for (const auto& path : fibres.paths)
    for (size_t k = 0; k + 1 < path.size(); ++k) lengths.push_back(norm(X[path[k + 1]] - X[path[k]]));
  return lengths;
}

std::vector<double> fibre_masses(const Scene& scene, const FibresDescription& fibres) {
  std::vector<double> masses = fibre_lengths(scene, fibres);
  const double area = section_of(fibres.material).mass / fibres.material.density;
  for (size_t e = 0; e < masses.size(); ++e) masses[e] *= area * element_density(fibres, e);
  return masses;
}

}  // namespace stark
