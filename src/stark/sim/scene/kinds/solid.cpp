// Soft solids: checks of what is added, and what the rest of sim asks of the kind (sim/scene/body_kind.h).
#include <stark/base/error.h>
#include <stark/mechanics/rest_state.h>
#include <stark/sim/scene/body_checks.h>
#include <stark/sim/scene/lumped_mass.h>
#include <stark/sim/scene/material_fields.h>

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
  const auto limits = solid.fields.find("strain_limit");
  const bool is_one = limits == solid.fields.end() || limits->second.values.empty();
  return {.density = element_density(solid, 0),
          .youngs_modulus = smallest_modulus(elastic_energy(solid)),
          .strain_limit = is_one ? solid.material.strain_limit : limits->second.values.front()};
}

}  // namespace

const BodyKindRow kSolidRow{.title = "solid",
                            .can_be_filled = true,
                            .rest_fields = kRestFields,
                            .vertex_masses = vertex_masses,
                            .surface = surface,
                            .elements = elements,
                            .material_scale = material_scale};

BodyId Scene::add_solid(SolidDescription body) {
  body.name = unique_name(body.name, BodyKind::Solid);
  const std::string owner = owner_text(BodyKind::Solid, body.name);
  std::vector<std::string> warnings;
  validate(body.material, owner);
  check_solid_mesh(owner, body.mesh);
  if (body.formulation == Formulation::MeanDilatation && body.mesh.type == ElementType::Tet4)
    throw InvalidArgument(owner +
                          ": formulation = mean_dilatation with linear tetrahedra, which have one volume "
                          "ratio each anyway: must be hexahedra or quadratic tetrahedra; use "
                          "stark.mesh.to_quadratic");
  check_fields(owner, body);
  check_initial_positions(owner, body.initial_positions, body.mesh.vertices.size());
  check_common(owner, body);
  warn_about_size(owner, body.mesh.vertices, warnings);
  warnings_.insert(warnings_.end(), warnings.begin(), warnings.end());
  solids_.push_back(std::move(body));
  return append(solids_.back().name, BodyKind::Solid, solids_.size() - 1);
}

}  // namespace stark
