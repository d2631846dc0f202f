// Rods: checks of what is added, and what the rest of sim asks of the kind (sim/scene/body_kind.h).
#include <stark/geometry/polyline.h>
#include <stark/mechanics/rest_state.h>
#include <stark/sim/scene/body_checks.h>
#include <stark/sim/scene/material_fields.h>
#include <stark/sim/scene/scene.h>

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

BodyId Scene::add_rod(RodDescription body) {
  body.name = unique_name(body.name, BodyKind::Rod);
  const std::string owner = owner_text(BodyKind::Rod, body.name);
  std::vector<std::string> warnings;
  validate(body.material, owner);
  check_polyline(owner, "the polyline", body.mesh.vertices);
  check_initial_positions(owner, body.initial_positions, body.mesh.vertices.size());
  if (!body.initial_positions.empty()) check_polyline(owner, "initial_positions", body.initial_positions);
  if (body.normal) check_normal(owner, *body.normal, body.mesh.vertices);
  if (body.normal && !body.initial_positions.empty())
    check_normal(owner, *body.normal, body.initial_positions);
  check_fields(owner, body);
  check_common(owner, body);
  warn_about_size(owner, body.mesh.vertices, warnings);
  warnings_.insert(warnings_.end(), warnings.begin(), warnings.end());
  rods_.push_back(std::move(body));
  return append(rods_.back().name, BodyKind::Rod, rods_.size() - 1);
}

std::vector<Mat3> Scene::initial_frames(BodyId body) const {
  const RodDescription& rod = this->rod(body);
  std::vector<Mat3> frames =
      polyline_frames(rod.initial_positions.empty() ? rod.mesh.vertices : rod.initial_positions, rod.normal);
  for (Mat3& frame : frames) frame = rod.rotation * frame;
  return frames;
}

}  // namespace stark
