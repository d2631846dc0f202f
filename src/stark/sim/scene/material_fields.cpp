// See material_fields.h.
#include <stark/sim/scene/material_fields.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <stark/base/error.h>
#include <stark/mechanics/rest_state.h>
#include <stark/sim/scene/registry.h>

namespace stark {

namespace models {
ShellLaw membrane_neo_hookean_law();
}

namespace {

// Cosine between the normal of a triangle and the x axis above which the default warp direction is y.
constexpr double kPerpendicular = 0.999;

constexpr const char *kBendingStiffness = "bending_stiffness", *kFlexuralRigidity = "flexural_rigidity";

int64_t element_count(const SolidDescription& solid) { return solid.mesh.element_count(); }
int64_t element_count(const ClothDescription& cloth) {
  return static_cast<int64_t>(cloth.mesh.triangles.size());
}
int64_t element_count(const RodDescription& rod) {
  return static_cast<int64_t>(rod.mesh.vertices.size()) - 1;
}
int64_t element_count(const FibresDescription& fibres) { return fibres.edge_count(); }

template <typename Description>
bool is_damped(const Description& body) {
  return body.material.strain_damping > 0.0 || body.fields.contains("strain_damping");
}

/// Names of the fields of a rest state that changes.
template <typename Description>
std::set<std::string> rest_fields(const Description& body) {
  std::set<std::string> names;
  for (const auto& [name, values] : body.rest_state) names.insert(name);
  return names;
}

/// Linear tetrahedra have a kernel of their own, all other elements that of a quadrature point.
PotentialDefinition definition_of(const SolidDescription& solid) {
  SolidLaw law = solid.law.value_or(models::stable_neo_hookean());
  if (!solid.rest_state.empty()) law = rest_state::with_fields(law, rest_fields(solid));
  if (solid.formulation == Formulation::MeanDilatation) {
    const std::optional<SolidLaw> damping =
        is_damped(solid) ? std::optional(models::solid_damping()) : std::nullopt;
    return compose("solid", {mean_dilatation_point(law, damping)});
  }
  const auto element = solid.mesh.type == ElementType::Tet4 ? tet4 : quadrature_point;
  std::vector<PotentialDefinition> terms{element(law)};
  if (is_damped(solid)) terms.push_back(element(models::solid_damping()));
  return compose("solid", terms);
}

bool yields(const ClothDescription& cloth) {
  return std::isfinite(cloth.material.yield_stress) || cloth.fields.contains("yield_stress");
}

PotentialDefinition membrane_of(const ClothDescription& cloth) {
  std::optional<ShellLaw> law = cloth.law;
  if (!law && yields(cloth)) law = models::plastic_membrane();
  if (!cloth.rest_state.empty())
    return triangle3(
        rest_state::with_fields(law.value_or(models::membrane_neo_hookean_law()), rest_fields(cloth)));
  return law ? triangle3(*law) : models::membrane_neo_hookean();
}

PotentialDefinition definition_of(const ClothDescription& cloth) {
  std::vector<PotentialDefinition> terms{membrane_of(cloth)};
  if (is_damped(cloth)) terms.push_back(models::membrane_damping());
  return compose("membrane", terms);
}

/// Whether a value of what a rod yields at is finite, or given by element.
template <typename Rods>
bool yields(const Rods& rods) {
  constexpr std::array<const char*, 4> kNames{"yield_force", "yield_moment_1", "yield_moment_2",
                                              "yield_torque"};
  return section_of(rods.material).yields() ||
         std::ranges::any_of(kNames, [&](const char* name) { return rods.fields.contains(name); });
}

template <typename Rods>
RodLaw rod_law_of(const Rods& rods) {
  std::vector<RodLaw> laws{rods.law       ? *rods.law
                           : yields(rods) ? models::plastic_rod()
                                          : models::linear_rod()};
  if (is_damped(rods)) laws.push_back(models::rod_damping());
  const RodLaw law = sum("rod", laws);
  if constexpr (requires { rods.rest_state; })
    if (!rods.rest_state.empty()) return rest_state::with_fields(law, rest_fields(rods));
  return law;
}

PotentialDefinition definition_of(const RodDescription& rod) { return rod_segment(rod_law_of(rod)); }

PotentialDefinition definition_of(const FibresDescription& fibres) {
  return fibres.bending ? rod_segment(rod_law_of(fibres)) : rod_bar(rod_law_of(fibres));
}

/// x, but y on triangles perpendicular to x.
FieldValues default_warp(const TriangleMesh& mesh) {
  FieldValues warp{.values = {}, .per_element = true};
  for (const Index3& t : mesh.triangles) {
    const Vec3& a = mesh.vertices[t[0]];
    const Vec3 normal = cross(mesh.vertices[t[1]] - a, mesh.vertices[t[2]] - a);
    const bool perpendicular = std::fabs(normal.x) > kPerpendicular * norm(normal);
    warp.values.insert(warp.values.end(), {perpendicular ? 0.0 : 1.0, perpendicular ? 1.0 : 0.0, 0.0});
  }
  return warp;
}

void add_defaults(const SolidDescription&, ParameterValues&) {}
void add_defaults(const ClothDescription& cloth, ParameterValues& values) {
  if (cloth.law && !cloth.law->isotropic) values.try_emplace("warp_direction", default_warp(cloth.mesh));
}
/// What the material leaves to the section.
void add_section(const RodMaterial& material, ParameterValues& values) {
  const RodSection section = section_of(material);
  const auto add = [&](const char* name, double value) {
    values.try_emplace(name, FieldValues{{value}, false});
  };
  add("axial_stiffness", section.axial_stiffness);
  add("shear_stiffness", section.shear_stiffness);
  add("bending_stiffness_1", section.bending_stiffness[0]);
  add("bending_stiffness_2", section.bending_stiffness[1]);
  add("torsional_stiffness", section.torsional_stiffness);
  add("yield_force", section.yield_force);
  add("yield_moment_1", section.yield_moments[0]);
  add("yield_moment_2", section.yield_moments[1]);
  add("yield_torque", section.yield_torque);
  add("yield_hardening", section.yield_hardening);
}
void add_defaults(const RodDescription& rod, ParameterValues& values) { add_section(rod.material, values); }
void add_defaults(const FibresDescription& fibres, ParameterValues& values) {
  add_section(fibres.material, values);
}

/// Values of a body: its fields, then its material, then defaults. Parameters without any are left out.
template <typename Description>
ParameterValues values_of(const Description& body, const std::vector<ParameterDeclaration>& declarations) {
  using Material = decltype(body.material);
  ParameterValues values = body.fields;
  if constexpr (requires { body.rest_state; }) values.insert(body.rest_state.begin(), body.rest_state.end());
  add_defaults(body, values);
  for (const ParameterDeclaration& declaration : declarations)
    for (const Field& field : Material::fields().fields())
      if (field.name == declaration.name && field.type == FieldType::Real)
        values.try_emplace(field.name, FieldValues{{std::get<double>(field.get(&body.material))}, false});
  return values;
}

template <typename Description>
ElasticEnergy energy_of(const Description& body) {
  PotentialDefinition definition = definition_of(body);
  ParameterValues values = values_of(body, parameters_of(definition));
  return {std::move(definition), std::move(values)};
}

ParameterDeclaration declaration_in(const FieldTable& table, const char* name) {
  const Field& field = table.find(name);
  return {.name = field.name, .unit = field.unit, .doc = field.doc, .width = 1, .rule = field.rule};
}

std::string law_name(const auto& body, const char* fallback) { return body.law ? body.law->name : fallback; }

std::string in_words(const std::vector<std::string>& names) {
  std::string text;
  for (size_t i = 0; i < names.size(); ++i)
    text += (i == 0 ? "" : i + 1 < names.size() ? ", " : " or ") + names[i];
  return text;
}

template <typename Description>
void check(std::string_view owner, const Description& body, const char* default_law) {
  std::vector<ParameterDeclaration> declarations = parameters_of(definition_of(body));
  std::erase_if(declarations, [](const ParameterDeclaration& d) { return d.name == kQuadratureWeight; });
  const ParameterValues values = values_of(body, declarations);
  const std::string law = "the law '" + law_name(body, default_law) + "'";
  for (const ParameterDeclaration& d : declarations)
    if (!values.contains(d.name))
      throw InvalidArgument(std::string(owner) + ": " + law + " needs a value of " + d.name +
                            (d.unit == "1" ? "" : " [" + d.unit + "]") + ", " + d.doc +
                            "; give one for the whole body or one for each element");
  std::vector<const char*> beside{"density", rest_state::kThermalExpansion};
  if constexpr (std::is_same_v<Description, ClothDescription>)
    beside.insert(beside.end(), {kBendingStiffness, kFlexuralRigidity});
  for (const char* name : beside)
    if (std::ranges::find(declarations, name, &ParameterDeclaration::name) == declarations.end())
      declarations.push_back(declaration_in(decltype(body.material)::fields(), name));
  std::vector<std::string> names;
  for (const ParameterDeclaration& d : declarations) names.push_back(d.name);
  for (const auto& [name, value] : body.fields)
    if (std::ranges::find(names, name) == names.end())
      throw InvalidArgument(std::string(owner) + ": field '" + name + "': " + law +
                            " has no such parameter by element; give one value for the whole body, or " +
                            "values of " + in_words(names) + nearest_name_hint(name, names));
  for (const ParameterDeclaration& d : declarations)
    if (const auto found = values.find(d.name); found != values.end())
      check_values(owner, d, found->second, element_count(body));
}

/// The value of an element, that of the material where the body has no field of the name.
template <typename Description>
double field_at(const Description& body, const char* name, double of_material, size_t element) {
  const auto found = body.fields.find(name);
  if (found == body.fields.end()) return of_material;
  return found->second.values[found->second.per_element ? element : 0];
}

template <typename Description>
double density_at(const Description& body, size_t element) {
  return field_at(body, "density", body.material.density, element);
}

void check_warp(std::string_view owner, const ClothDescription& cloth) {
  const auto found = cloth.fields.find("warp_direction");
  if (found == cloth.fields.end()) return;
  for (size_t t = 0; t < cloth.mesh.triangles.size(); ++t) {
    const double* v = found->second.values.data() + (found->second.per_element ? 3 * t : 0);
    const Index3& i = cloth.mesh.triangles[t];
    const auto& X = cloth.mesh.vertices;
    if (!is_projectable({v[0], v[1], v[2]}, X[i[0]], X[i[1]], X[i[2]]))
      throw InvalidArgument(std::string(owner) +
                            ": warp_direction = " + to_text(FieldValue(Vec3{v[0], v[1], v[2]})) +
                            " is normal to triangle " + std::to_string(t) +
                            ": must have a projection into each; give one direction for each triangle");
  }
}

}  // namespace

ElasticEnergy elastic_energy(const SolidDescription& solid) { return energy_of(solid); }
ElasticEnergy elastic_energy(const ClothDescription& cloth) { return energy_of(cloth); }
ElasticEnergy elastic_energy(const RodDescription& rod) { return energy_of(rod); }
ElasticEnergy elastic_energy(const FibresDescription& fibres) { return energy_of(fibres); }

std::vector<ParameterDeclaration> law_parameters(const SolidDescription& solid) {
  return parameters_of(tet4(solid.law.value_or(models::stable_neo_hookean())));
}
std::vector<ParameterDeclaration> law_parameters(const ClothDescription& cloth) {
  return parameters_of(triangle3(cloth.law.value_or(models::membrane_neo_hookean_law())));
}
std::vector<ParameterDeclaration> law_parameters(const RodDescription& rod) {
  return parameters_of(rod_segment(rod.law.value_or(models::linear_rod())));
}

void check_fields(std::string_view owner, const SolidDescription& solid) {
  check(owner, solid, "stable_neo_hookean");
}

void check_fields(std::string_view owner, const ClothDescription& cloth) {
  check(owner, cloth, yields(cloth) ? "plastic_membrane" : "membrane_neo_hookean");
  check_warp(owner, cloth);
}

void check_fields(std::string_view owner, const RodDescription& rod) {
  check(owner, rod, yields(rod) ? "plastic_rod" : "linear_rod");
}

void check_fields(std::string_view owner, const FibresDescription& fibres) {
  check(owner, fibres, yields(fibres) ? "plastic_rod" : "linear_rod");
}

double element_density(const SolidDescription& solid, size_t element) { return density_at(solid, element); }
double element_density(const ClothDescription& cloth, size_t element) { return density_at(cloth, element); }
double element_density(const RodDescription& rod, size_t element) { return density_at(rod, element); }
double element_density(const FibresDescription& fibres, size_t element) {
  return density_at(fibres, element);
}

double bending_stiffness(const ClothDescription& cloth, size_t triangle) {
  return field_at(cloth, kBendingStiffness, cloth.material.bending_stiffness, triangle);
}
double flexural_rigidity(const ClothDescription& cloth, size_t triangle) {
  return field_at(cloth, kFlexuralRigidity, cloth.material.flexural_rigidity, triangle);
}

void keep_largest_bending(ShellMaterial& material, const ParameterValues& fields) {
  const auto keep = [&](const char* name, double& value) {
    if (const auto found = fields.find(name); found != fields.end() && !found->second.values.empty())
      value = *std::ranges::max_element(found->second.values);
  };
  keep(kBendingStiffness, material.bending_stiffness);
  keep(kFlexuralRigidity, material.flexural_rigidity);
}

double smallest_modulus(const ElasticEnergy& energy) {
  const auto found = energy.values.find("youngs_modulus");
  if (found == energy.values.end() || found->second.values.empty())
    return std::numeric_limits<double>::infinity();
  return *std::ranges::min_element(found->second.values);
}

}  // namespace stark
