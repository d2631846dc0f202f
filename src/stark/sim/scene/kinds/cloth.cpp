// Cloth: checks of what is added, and what the rest of sim asks of the kind (sim/scene/body_kind.h).
#include <stark/mechanics/rest_state.h>
#include <stark/sim/scene/body_checks.h>
#include <stark/sim/scene/lumped_mass.h>
#include <stark/sim/scene/material_fields.h>

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
  const ClothDescription& cloth = scene.cloth(body);
  const auto value = [&](const char* name, double of_material) {
    const auto found = cloth.fields.find(name);
    return found == cloth.fields.end() || found->second.values.empty() ? of_material
                                                                       : found->second.values.front();
  };
  const ShellMaterial& m = cloth.material;
  MaterialScale scale{.density = element_density(cloth, 0),
                      .is_area_density = true,
                      .thickness = value("thickness", m.thickness),
                      .strain_limit = value("strain_limit", m.strain_limit)};
  const double t = scale.thickness, nu = value("poissons_ratio", m.poissons_ratio);
  if (!cloth.law)
    scale.rigidity_ratio = 12.0 * (1.0 - nu * nu) * value("flexural_rigidity", m.flexural_rigidity) /
                           (value("youngs_modulus", m.youngs_modulus) * t * t * t);
  return scale;
}

}  // namespace

const BodyKindRow kClothRow{.title = "cloth",
                            .is_thin = true,
                            .rest_fields = kRestFields,
                            .vertex_masses = vertex_masses,
                            .surface = surface,
                            .elements = elements,
                            .material_scale = material_scale};

BodyId Scene::add_cloth(ClothDescription body) {
  body.name = unique_name(body.name, BodyKind::Cloth);
  const std::string owner = owner_text(BodyKind::Cloth, body.name);
  std::vector<std::string> warnings;
  keep_largest_bending(body.material, body.fields);
  validate(body.material, owner);
  check_cloth_mesh(owner, body.mesh, warnings);
  warn_about_free_directions(owner, body.mesh, body.material, warnings);
  warn_about_weak_plates(owner, body.mesh, body.material, warnings);
  check_fields(owner, body);
  check_initial_positions(owner, body.initial_positions, body.mesh.vertices.size());
  check_common(owner, body);
  warn_about_size(owner, body.mesh.vertices, warnings);
  warnings_.insert(warnings_.end(), warnings.begin(), warnings.end());
  cloths_.push_back(std::move(body));
  return append(cloths_.back().name, BodyKind::Cloth, cloths_.size() - 1);
}

}  // namespace stark
