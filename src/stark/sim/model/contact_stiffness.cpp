#include <stark/sim/model/contact_stiffness.h>

#include <algorithm>
#include <limits>
#include <numeric>

#include <stark/geometry/polyline.h>
#include <stark/geometry/topology.h>
#include <stark/sim/scene/contact_distance.h>

namespace stark {

namespace {

/// Length of a rod that carries it, over its diameter: it may lie across a few others.
constexpr double kRodLength = 4.0;

constexpr double kStandardGravity = 9.80665;  ///< [m/s^2]

/// Of the whole body [kg].
double mass_of(const Model& model, BodyId id) {
  const ModelBody& body = model.bodies()[id.index];
  double mass = 0.0;
  for (int32_t i = 0; i < body.rigid_count(); ++i) mass += model.rigid_masses()[body.rigid_index + i].mass;
  if (has_points(body.kind))
    for (int32_t i = 0; i < body.site_count; ++i) mass += model.point_masses()[body.first_site + i];
  return mass;
}

/// What a body rests on: half of a closed surface, one side of a sheet [m^2].
double resting_area(const Scene& scene, const Model& model, BodyId id, const Settings& settings) {
  const ModelBody& body = model.bodies()[id.index];
  if (has_nodes(body.kind)) {
    const std::vector<double> lengths = polyline_lengths(scene.rest_vertices(id));
    const double length = std::accumulate(lengths.begin(), lengths.end(), 0.0);
    const double diameter = 2.0 * contact_distance(scene, id, settings);
    return std::min(length, kRodLength * diameter) * diameter;
  }
  const std::vector<double> areas = compute_triangle_areas(scene.rest_vertices(id), body.triangles);
  return std::accumulate(areas.begin(), areas.end(), 0.0) * (is_closed(body.triangles) ? 0.5 : 1.0);
}

}  // namespace

BodyStiffness contact_stiffness(const Scene& scene, const Model& model, BodyId body,
                                const Settings& settings) {
  if (const std::optional<double> own = scene.contact_stiffness(body)) return {*own, true};
  if (settings.contact.stiffness > 0.0) return {settings.contact.stiffness, true};
  if (scene.motion(body) != Motion::Dynamic) return {std::numeric_limits<double>::infinity(), false};
  return {settings.contact.stiffness_factor * kStandardGravity * mass_of(model, body) /
              resting_area(scene, model, body, settings),
          false};
}

}  // namespace stark
