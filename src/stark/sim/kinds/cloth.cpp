// What the rest of sim asks of cloth (sim/body_kind.h).
#include <stark/mechanics/rest_state.h>
#include <stark/sim/lumped_mass.h>
#include <stark/sim/material_fields.h>

namespace stark {

namespace {

constexpr std::string_view kRestFields[]{rest_state::kGrowth, rest_state::kTemperature,
                                         rest_state::kFiberDirection, rest_state::kActiveStress,
                                         rest_state::kNaturalCurvature};

std::vector<double> vertex_masses(const Scene& scene, BodyId body) {
  return lumped_masses(scene.cloth(body));
}

std::vector<Index3> surface(const Scene& scene, BodyId body) { return scene.cloth(body).mesh.triangles; }

BodyElements elements(const Scene& scene, BodyId body) {
  BodyElements result{.width = 3, .edges = {{0, 1}, {1, 2}, {2, 0}}};
  for (const Index3& t : scene.cloth(body).mesh.triangles)
    result.vertices.insert(result.vertices.end(), t.begin(), t.end());
  return result;
}

MaterialScale material_scale(const Scene& scene, BodyId body) {
  return {.density = element_density(scene.cloth(body), 0), .is_area_density = true};
}

}  // namespace

const BodyKindRow kClothRow{.title = "cloth",
                            .is_thin = true,
                            .rest_fields = kRestFields,
                            .vertex_masses = vertex_masses,
                            .surface = surface,
                            .elements = elements,
                            .material_scale = material_scale};

}  // namespace stark
