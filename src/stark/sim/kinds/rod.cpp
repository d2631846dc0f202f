// What the rest of sim asks of rods (sim/body_kind.h).
#include <stark/geometry/polyline.h>
#include <stark/mechanics/rest_state.h>
#include <stark/sim/material_fields.h>
#include <stark/sim/scene.h>

namespace stark {

namespace {

constexpr std::string_view kRestFields[]{rest_state::kGrowth, rest_state::kTemperature,
                                         rest_state::kNaturalCurvature, rest_state::kNaturalTwist,
                                         rest_state::kActiveForce};

double mass(const Scene& scene, BodyId body) {
  const RodDescription& rod = scene.rod(body);
  const std::vector<double> lengths = polyline_lengths(rod.mesh.vertices);
  const double area = section_of(rod.material).mass / rod.material.density;
  double mass = 0.0;
  for (size_t e = 0; e < lengths.size(); ++e) mass += lengths[e] * area * element_density(rod, e);
  return mass;
}

BodyElements elements(const Scene& scene, BodyId body) {
  BodyElements result{.width = 2, .edges = {{0, 1}}};
  const auto nodes = static_cast<int32_t>(scene.rod(body).mesh.vertices.size());
  for (int32_t i = 0; i + 1 < nodes; ++i) result.vertices.insert(result.vertices.end(), {i, i + 1});
  return result;
}

MaterialScale material_scale(const Scene& scene, BodyId body) {
  const RodDescription& rod = scene.rod(body);
  return {.density = element_density(rod, 0), .youngs_modulus = smallest_modulus(elastic_energy(rod))};
}

}  // namespace

const BodyKindRow kRodRow{.title = "rod",
                          .moved_by = MovedBy::Nodes,
                          .is_thin = true,
                          .rest_fields = kRestFields,
                          .mass = mass,
                          .elements = elements,
                          .material_scale = material_scale};

}  // namespace stark
