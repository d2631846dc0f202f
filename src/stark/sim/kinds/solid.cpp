// What the rest of sim asks of soft solids (sim/body_kind.h).
#include <stark/mechanics/rest_state.h>
#include <stark/sim/lumped_mass.h>
#include <stark/sim/material_fields.h>

namespace stark {

namespace {

constexpr std::string_view kRestFields[]{rest_state::kGrowth, rest_state::kTemperature,
                                         rest_state::kFiberDirection, rest_state::kActiveStress};

std::vector<double> vertex_masses(const Scene& scene, BodyId body) {
  return lumped_masses(scene.solid(body));
}

std::vector<Index3> surface(const Scene& scene, BodyId body) {
  return find_boundary_triangles(scene.solid(body).mesh);
}

BodyElements elements(const Scene& scene, BodyId body) {
  const SolidMesh& mesh = scene.solid(body).mesh;
  return {.vertices = mesh.elements,
          .width = static_cast<size_t>(mesh.node_count()),
          .edges = reference_element(mesh.type).edges};
}

MaterialScale material_scale(const Scene& scene, BodyId body) {
  const SolidDescription& solid = scene.solid(body);
  return {.density = element_density(solid, 0), .youngs_modulus = smallest_modulus(elastic_energy(solid))};
}

}  // namespace

const BodyKindRow kSolidRow{.title = "solid",
                            .can_be_filled = true,
                            .rest_fields = kRestFields,
                            .vertex_masses = vertex_masses,
                            .surface = surface,
                            .elements = elements,
                            .material_scale = material_scale};

}  // namespace stark
