// Scene: rest states that change. What a body may have, ranges of its values.
#include <algorithm>
#include <array>

#include <stark/base/error.h>
#include <stark/mechanics/rest_state.h>
#include <stark/sim/scene/body_checks.h>
#include <stark/sim/scene/material_fields.h>

namespace stark {

namespace {

/// What of the stretch of the rest shape must be positive: the determinant in solids.
double measure_of_growth(const FieldValues& growth, size_t element, bool is_tensor) {
  if (!is_tensor) return growth.values[element];
  Mat3 G;
  for (int i = 0; i < 9; ++i) G.m[i] = growth.values[9 * element + i];
  return determinant(G);
}

void check_growth(std::string_view owner, const FieldValues& growth, bool is_tensor) {
  const size_t width = is_tensor ? 9 : 1;
  for (size_t e = 0; e < growth.values.size() / width; ++e)
    if (const double value = measure_of_growth(growth, e, is_tensor); !(value > 0.0))
      throw InvalidArgument(std::string(owner) + ": growth[" + std::to_string(e) + "]" +
                            (is_tensor ? " has the determinant " : " = ") + to_text(value) +
                            ": must be > 0; it is the stretch of the rest shape, 1 for none");
}

void check_heat(std::string_view owner, const FieldValues& temperature, const FieldValues& expansion) {
  for (size_t e = 0; e < temperature.values.size(); ++e) {
    const double alpha = expansion.values[expansion.per_element ? e : 0];
    if (!(1.0 + alpha * temperature.values[e] > 0.0))
      throw InvalidArgument(std::string(owner) + ": temperature[" + std::to_string(e) +
                            "] = " + quantity_text(temperature.values[e], "K") +
                            " with a thermal expansion of " + quantity_text(alpha, "1/K") +
                            ": must leave a positive stretch 1 + expansion * temperature");
  }
}

/// sheet: of a cloth, whose triangles must have a part of the direction in them.
void check_fibers(std::string_view owner, const FieldValues& fibers, const TriangleMesh* sheet) {
  for (size_t e = 0; e < fibers.values.size() / 3; ++e) {
    const double* a = fibers.values.data() + 3 * e;
    const std::string title = std::string(owner) + ": fiber_direction[" + std::to_string(e) + "] = ";
    if (a[0] == 0.0 && a[1] == 0.0 && a[2] == 0.0)
      throw InvalidArgument(title + "(0, 0, 0): must not be zero; give any vector in that direction");
    if (!sheet) continue;
    const Index3& t = sheet->triangles[e];
    if (!is_projectable({a[0], a[1], a[2]}, sheet->vertices[t[0]], sheet->vertices[t[1]],
                        sheet->vertices[t[2]]))
      throw InvalidArgument(title + "(" + to_text(a[0]) + ", " + to_text(a[1]) + ", " + to_text(a[2]) +
                            "): must not be normal to its triangle; give a vector along the sheet");
  }
}

void check_curl(std::string_view owner, const FieldValues& curvature, const ClothDescription& sheet) {
  const std::string title = std::string(owner) + ": natural_curvature";
  if (!(sheet.material.flexural_rigidity > 0.0))
    throw InvalidArgument(title +
                          ": needs a material that bends as a plate: give it a flexural_rigidity "
                          "instead of a bending_stiffness");
  if (curvature.values.size() != 9 * sheet.mesh.triangles.size())
    throw InvalidArgument(title + ": got " + std::to_string(curvature.values.size()) +
                          " numbers: must be a tensor of 9 for each triangle");
  for (size_t e = 0; e < sheet.mesh.triangles.size(); ++e) {
    const double* K = curvature.values.data() + 9 * e;
    if (K[1] != K[3] || K[2] != K[6] || K[5] != K[7])
      throw InvalidArgument(title + "[" + std::to_string(e) + "]: must be symmetric; give (K + K^T)/2");
  }
}

template <typename Description>
void merge(std::string_view owner, Description& body, const ParameterValues& values) {
  if (body.law)
    for (const ParameterDeclaration& own : law_parameters(body))
      if (values.contains(own.name))
        throw InvalidArgument(std::string(owner) + ": " + own.name + ": the law '" + body.law->name +
                              "' has a parameter of this name: must be another law; give it to the material");
  for (const auto& [name, value] : values) body.rest_state[name] = value;
  check_fields(owner, body);
}

}  // namespace

void Scene::set_rest_state(BodyId id, const ParameterValues& values) {
  const BodyKind body_kind = kind(id);
  const std::string owner = owner_text(body_kind, name(id));
  const std::span<const std::string_view> fields = row_of(body_kind).rest_fields;
  if (fields.empty())
    throw InvalidArgument(owner + ": has no rest state that could change: must be a cloth, a solid or a rod");
  const std::vector<std::string> known(fields.begin(), fields.end());
  for (const auto& [field, value] : values)
    if (std::ranges::find(known, field) == known.end())
      throw InvalidArgument(owner + ": rest state '" + field + "'" + nearest_name_hint(field, known) +
                            ": is not one of such a body");
  const auto set = [&](auto& description) {
    auto changed = description;
    merge(owner, changed, values);
    check_rest_state(id, values);
    description = std::move(changed);
  };
  visit(id, [&](const auto& description) {
    using Description = std::remove_cvref_t<decltype(description)>;
    if constexpr (requires { description.rest_state; }) set(const_cast<Description&>(description));
  });
}

const ParameterValues& Scene::rest_state(BodyId id) const {
  static const ParameterValues none;
  return visit(id, [](const auto& body) -> const ParameterValues& {
    if constexpr (requires { body.rest_state; }) return body.rest_state;
    return none;
  });
}

void Scene::check_rest_state(BodyId id, const ParameterValues& values) const {
  const std::string owner = owner_text(kind(id), name(id));
  if (const auto growth = values.find(rest_state::kGrowth); growth != values.end())
    check_growth(owner, growth->second, solid_mesh(id) != nullptr);
  if (const auto fibers = values.find(rest_state::kFiberDirection); fibers != values.end())
    check_fibers(owner, fibers->second, kind(id) == BodyKind::Cloth ? &cloth(id).mesh : nullptr);
  if (const auto curl = values.find(rest_state::kNaturalCurvature);
      curl != values.end() && kind(id) == BodyKind::Cloth)
    check_curl(owner, curl->second, cloth(id));
  const auto heat = values.find(rest_state::kTemperature);
  if (heat == values.end()) return;
  visit(id, [&](const auto& body) {
    if constexpr (requires { body.material.thermal_expansion; }) {
      const auto found = body.fields.find(rest_state::kThermalExpansion);
      check_heat(
          owner, heat->second,
          found != body.fields.end() ? found->second : FieldValues{{body.material.thermal_expansion}, false});
    }
  });
}

}  // namespace stark
