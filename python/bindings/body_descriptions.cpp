#include "body_descriptions.h"

#include <optional>

#include "described.h"
#include "field_values.h"
#include "formulas.h"
#include "small_arrays.h"
#include "solid_mesh.h"

namespace stark::bindings {

namespace {

template <size_t n>
std::vector<std::array<int32_t, n>> elements_of(nb::handle object, const std::string& name) {
  const auto array_of = array<Rows<int32_t, n>>(
      object, name, "an array of shape (m, " + std::to_string(n) + ") of integers (32 bits suffice)");
  const auto view = rows<std::array<int32_t, n>>(array_of);
  return {view.begin(), view.end()};
}

template <typename E>
E choice_of(const std::string& value, const std::string& name) {
  const auto& names = EnumNames<E>::kNames;
  std::vector<std::string> known(names.begin(), names.end());
  std::string list;
  for (size_t i = 0; i < known.size(); ++i) {
    if (known[i] == value) return static_cast<E>(i);
    list += (i ? ", '" : "'") + known[i] + "'";
  }
  throw InvalidArgument(name + " = '" + value + "': must be one of " + list +
                        nearest_name_hint(value, known));
}

std::optional<double> number_of(nb::handle object, const std::string& name) {
  if (object.is_none()) return std::nullopt;
  const FieldValue value = to_field_value(object);
  if (const auto* real = std::get_if<double>(&value)) return *real;
  if (const auto* integer = std::get_if<int64_t>(&value)) return static_cast<double>(*integer);
  throw InvalidArgument(name + " = " + text(nb::repr(object)) + ": must be a number or None");
}

/// Fields that all descriptions share, from keyword arguments; `owner` names the body in messages.
template <typename Description>
Description description_of(const nb::dict& given, std::string& out_owner, const char* kind) {
  Description body;
  body.name = nb::cast<std::string>(given["name"]);
  out_owner = std::string(kind) + (body.name.empty() ? "" : " '" + body.name + "'");
  const std::string& owner = out_owner;
  body.position = vector_of(given["position"], owner + ": position");
  body.rotation = matrix_of(given["rotation"], owner + ": rotation");
  body.velocity = vector_of(given["velocity"], owner + ": velocity");
  body.angular_velocity = vector_of(given["angular_velocity"], owner + ": angular_velocity");
  body.contact_distance = number_of(given["contact_distance"], owner + ": contact_distance");
  if (given.contains("contact_stiffness"))  // descriptions of older recordings have none
    body.contact_stiffness = number_of(given["contact_stiffness"], owner + ": contact_stiffness");
  if (given.contains("contact_core"))
    body.contact_core = number_of(given["contact_core"], owner + ": contact_core").value_or(0.0);
  body.friction = number_of(given["friction"], owner + ": friction");
  if (!given["color"].is_none()) {
    const Vec3 c = vector_of(given["color"], owner + ": color");
    body.color = Color{c.x, c.y, c.z};
  }
  body.mesh.vertices = points_of(given["vertices"], owner + ": vertices");
  return body;
}

/// The law and the values of its parameters that a deformable body was given.
template <typename Description>
void read_law(const nb::dict& given, const std::string& owner, Description& body) {
  using Law = typename decltype(body.law)::value_type;
  if (!given["law"].is_none()) body.law = nb::cast<Law>(given["law"]);
  body.fields = parameter_values_of(given["fields"], owner);
}

}  // namespace

ClothDescription cloth_of(const nb::dict& given, const ShellMaterial& material) {
  std::string owner;
  auto body = description_of<ClothDescription>(given, owner, "cloth");
  body.mesh.triangles = elements_of<3>(given["triangles"], owner + ": triangles");
  body.material = material;
  read_law(given, owner, body);
  if (!given["initial_positions"].is_none())
    body.initial_positions = points_of(given["initial_positions"], owner + ": initial_positions");
  body.self_contact = nb::cast<bool>(given["self_contact"]);
  body.rest_angles =
      choice_of<RestAngles>(nb::cast<std::string>(given["rest_angles"]), owner + ": rest_angles");
  return body;
}

SolidDescription solid_of(const nb::dict& given, const SolidMaterial& material) {
  std::string owner;
  auto body = description_of<SolidDescription>(given, owner, "solid");
  read_elements(given["elements"], owner + ": elements", body.mesh);
  if (given.contains("embedding") && !given["embedding"].is_none())
    body.mesh.embedding = embedding_of(nb::cast<nb::dict>(given["embedding"]), owner);
  body.material = material;
  if (given.contains("formulation"))
    body.formulation =
        choice_of<Formulation>(nb::cast<std::string>(given["formulation"]), owner + ": formulation");
  read_law(given, owner, body);
  if (!given["initial_positions"].is_none())
    body.initial_positions = points_of(given["initial_positions"], owner + ": initial_positions");
  body.self_contact = nb::cast<bool>(given["self_contact"]);
  return body;
}

RodDescription rod_of(const nb::dict& given, const RodMaterial& material) {
  std::string owner;
  auto body = description_of<RodDescription>(given, owner, "rod");
  body.material = material;
  read_law(given, owner, body);
  if (!given["initial_positions"].is_none())
    body.initial_positions = points_of(given["initial_positions"], owner + ": initial_positions");
  if (!given["normal"].is_none()) body.normal = vector_of(given["normal"], owner + ": normal");
  body.self_contact = nb::cast<bool>(given["self_contact"]);
  body.rest_shape = choice_of<RestShape>(nb::cast<std::string>(given["rest_shape"]), owner + ": rest_shape");
  return body;
}

RigidDescription rigid_of(const nb::dict& given) {
  std::string owner;
  auto body = description_of<RigidDescription>(given, owner, "rigid body");
  body.mesh.triangles = elements_of<3>(given["triangles"], owner + ": triangles");
  body.motion = choice_of<Motion>(nb::cast<std::string>(given["motion"]), owner + ": motion");
  body.mass = number_of(given["mass"], owner + ": mass");
  body.density = number_of(given["density"], owner + ": density");
  if (given.contains("hollow")) body.hollow = nb::cast<bool>(given["hollow"]);
  body.linear_damping = number_of(given["linear_damping"], owner + ": linear_damping").value_or(0.0);
  body.angular_damping = number_of(given["angular_damping"], owner + ": angular_damping").value_or(0.0);
  if (!given["inertia"].is_none()) {
    const nb::tuple inertia = nb::cast<nb::tuple>(given["inertia"]);
    body.inertia = RigidInertia{number_of(inertia[0], owner + ": inertia.mass").value_or(0.0),
                                vector_of(inertia[1], owner + ": inertia.center_of_mass"),
                                matrix_of(inertia[2], owner + ": inertia.tensor")};
  }
  return body;
}

}  // namespace stark::bindings
