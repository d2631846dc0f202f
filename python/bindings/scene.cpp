// Bindings of settings, materials and the scene description. Settings and materials are bound generically
// through their descriptor tables, so a new field needs no line here. The Python front end is stark/scene.py
// and its siblings.
#include <nanobind/nanobind.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <stark/sim/contact_distance.h>
#include <stark/sim/materials.h>
#include <stark/sim/scene.h>
#include <stark/sim/settings.h>

#include "actuators.h"
#include "arrays.h"
#include "attachments.h"
#include "field_values.h"
#include "formulas.h"
#include "joints.h"
#include "layers.h"
#include "solid_mesh.h"

namespace {

namespace nb = nanobind;
using namespace nb::literals;
using namespace stark;
using namespace stark::bindings;

nb::object to_python(const FieldValue& value) {
  if (const auto* v = std::get_if<Vec3>(&value)) return nb::make_tuple(v->x, v->y, v->z);
  if (const auto* flag = std::get_if<bool>(&value)) return nb::bool_(*flag);
  if (const auto* integer = std::get_if<int64_t>(&value)) return nb::int_(*integer);
  if (const auto* real = std::get_if<double>(&value)) return nb::float_(*real);
  return nb::str(std::get<std::string>(value).c_str());
}

/// Flags, integers, reals (NumPy scalars too), texts and rows of three; anything else becomes its text, which
/// the descriptor then refuses by name.
FieldValue to_field_value(nb::handle object) {
  if (nb::isinstance<nb::str>(object)) return nb::cast<std::string>(object);
  if (nb::isinstance<nb::bool_>(object)) return nb::cast<bool>(object);
  if (PyIndex_Check(object.ptr()) && !nb::hasattr(object, "__len__")) {
    int64_t integer = 0;
    if (nb::try_cast<int64_t>(nb::int_(object), integer)) return integer;
  }
  try {
    if (nb::hasattr(object, "__len__")) {
      if (nb::len(object) == 3) {
        Vec3 v;
        for (int i = 0; i < 3; ++i) v[i] = nb::cast<double>(nb::float_(object[i]));
        return v;
      }
    } else if (nb::hasattr(object, "__float__")) {
      return nb::cast<double>(nb::float_(object));
    }
  } catch (const std::exception&) {
  }
  return text(object);
}

FieldMap to_field_map(const nb::dict& values) {
  FieldMap map;
  for (auto [name, value] : values) map.emplace_back(text(name), to_field_value(value));
  return map;
}

nb::dict to_dict(const FieldMap& map) {
  nb::dict dict;
  for (const auto& [name, value] : map) dict[name.c_str()] = to_python(value);
  return dict;
}

nb::list describe(const FieldTable& table) {
  nb::list rows;
  for (const Field& f : table.fields()) {
    nb::dict row;
    row["name"] = f.name;
    row["unit"] = f.unit;
    row["default"] = to_python(f.default_value);
    row["rule"] = f.rule_text();
    row["choices"] = f.choices ? f.choices() : std::vector<std::string>();
    row["doc"] = f.doc;
    rows.append(row);
  }
  return rows;
}

/// The methods that every described struct has: get, set, update, to_dict, changed, copy, fields, markdown,
/// ==.
template <typename S>
nb::class_<S> bind_described(nb::module_& m, const char* name, const char* doc) {
  return nb::class_<S>(m, name, doc)
      .def(nb::init<>())
      .def(
          "get", [](const S& s, const std::string& field) { return to_python(S::fields().get(&s, field)); },
          "name"_a)
      .def(
          "set",
          [](S& s, const std::string& field, nb::handle value, const std::string& owner) {
            S::fields().set(&s, field, to_field_value(value), owner);
          },
          "name"_a, "value"_a.none(), "owner"_a = "", "Checks the range, then assigns.")
      .def(
          "update",
          [](S& s, const nb::dict& values, const std::string& owner) {
            S::fields().set_all(&s, to_field_map(values), owner);
          },
          "values"_a, "owner"_a = "", "Assigns all entries, or none when one is refused.")
      .def("to_dict", [](const S& s) { return to_dict(S::fields().to_map(&s)); })
      .def("changed", [](const S& s) { return to_dict(S::fields().changed_from_default(&s)); })
      .def(
          "listing", [](const S& s) { return S::fields().listing(&s); }, "One 'name = value unit' a line.")
      .def("copy", [](const S& s) { return S(s); })
      .def("__eq__",
           [](const S& s, const S& other) { return S::fields().to_map(&s) == S::fields().to_map(&other); })
      .def_static("fields", [] { return describe(S::fields()); })
      .def_static("markdown", [] { return S::fields().markdown(); });
}

void bind_settings(nb::module_& m) {
  bind_described<Settings>(m, "Settings", "All settings of a simulation by dotted name.")
      .def(
          "set_text",
          [](Settings& s, const std::string& name, const std::string& value) {
            set_from_text(s, name, value);
          },
          "name"_a, "text"_a)
      .def(
          "assign",
          [](Settings& s, const std::string& name, nb::handle value) { set(s, name, to_field_value(value)); },
          "name"_a, "value"_a.none(), "As set(), and knows time_step, contact_distance and threads.")
      .def(
          "read", [](const Settings& s, const std::string& name) { return to_python(get(s, name)); },
          "name"_a, "As get(), and knows the short names.")
      .def(
          "validate", [](const Settings& s) { validate(s); }, "Ranges, and the rules between settings.")
      .def("brief", [](const Settings& s) { return changed_from_default(s); });
}

template <typename Material>
nb::list bind_presets(const std::vector<materials::Preset<Material>>& presets) {
  nb::list rows;
  for (const auto& preset : presets) rows.append(nb::make_tuple(preset.name, preset.source, preset.material));
  return rows;
}

Vec3 vector_of(nb::handle object, const std::string& name) {
  const auto column = array<Column<double>>(object, name, "three numbers");
  if (column.shape(0) != 3)
    throw InvalidArgument(name + ": got " + std::to_string(column.shape(0)) + " numbers, need three numbers");
  return {column(0), column(1), column(2)};
}

Mat3 matrix_of(nb::handle object, const std::string& name) {
  const auto matrix = array<Rows<double, 3>>(object, name, "a 3 x 3 rotation matrix");
  if (matrix.shape(0) != 3)
    throw InvalidArgument(name + ": got " + std::to_string(matrix.shape(0)) +
                          " rows, need a 3 x 3 rotation matrix");
  Mat3 result;
  std::copy_n(matrix.data(), 9, result.m.begin());
  return result;
}

std::vector<Vec3> points_of(nb::handle object, const std::string& name) {
  const auto array_of = array<Rows<double, 3>>(object, name, "an array of shape (n, 3) of real numbers [m]");
  const auto view = rows<Vec3>(array_of);
  return {view.begin(), view.end()};
}

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
  body.material = material;
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

auto matrix_to_numpy(const Mat3& matrix) {
  return to_numpy<double>(std::vector<Vec3>{matrix.row(0), matrix.row(1), matrix.row(2)});
}

nb::dict inertia_to_dict(const RigidInertia& inertia) {
  nb::dict dict;
  dict["mass"] = inertia.mass;
  dict["center_of_mass"] = to_python(FieldValue(inertia.center_of_mass));
  dict["tensor"] = matrix_to_numpy(inertia.tensor);
  return dict;
}

nb::dict section_to_dict(const RodMaterial& material) {
  const RodSection section = section_of(material);
  nb::dict dict;
  dict["mass"] = section.mass;
  dict["axial_stiffness"] = section.axial_stiffness;
  dict["shear_stiffness"] = section.shear_stiffness;
  dict["bending_stiffness_1"] = section.bending_stiffness[0];
  dict["bending_stiffness_2"] = section.bending_stiffness[1];
  dict["torsional_stiffness"] = section.torsional_stiffness;
  return dict;
}

/// Each body of a with each other one of b.
template <typename Action>
void for_each_pair_of(const std::vector<int32_t>& a, const std::vector<int32_t>& b, Action&& action) {
  for (const int32_t i : a)
    for (const int32_t j : b)
      if (i != j) action(BodyId{i}, BodyId{j});
}

void bind_scene_class(nb::module_& m) {
  nb::class_<Scene>(m, "Scene",
                    "Description of what is simulated; bodies are indices in the order of adding.")
      .def(nb::init<>())
      .def("copy", [](const Scene& s) { return Scene(s); })
      .def(
          "assign", [](Scene& s, const Scene& other) { s = other; }, "other"_a)
      .def(
          "add_cloth",
          [](Scene& s, const nb::dict& given, const ShellMaterial& material) {
            return s.add_cloth(cloth_of(given, material)).index;
          },
          "description"_a, "material"_a)
      .def(
          "add_solid",
          [](Scene& s, const nb::dict& given, const SolidMaterial& material) {
            return s.add_solid(solid_of(given, material)).index;
          },
          "description"_a, "material"_a)
      .def(
          "add_rigid", [](Scene& s, const nb::dict& given) { return s.add_rigid(rigid_of(given)).index; },
          "description"_a)
      .def(
          "add_rod",
          [](Scene& s, const nb::dict& given, const RodMaterial& material) {
            return s.add_rod(rod_of(given, material)).index;
          },
          "description"_a, "material"_a)
      .def(
          "clamp",
          [](Scene& s, int32_t body, nb::handle nodes) {
            const auto indices =
                array<Column<int32_t>>(nodes, "'" + s.name({body}) + "': clamped nodes", "a row of indices");
            s.clamp({body}, values(indices));
          },
          "body"_a, "nodes"_a)
      .def(
          "clamped",
          [](const Scene& s, int32_t body) {
            return to_numpy<int32_t>(std::vector<int32_t>(s.pins({body}).clamped));
          },
          "body"_a)
      .def(
          "initial_frames",
          [](const Scene& s, int32_t body) { return to_numpy<double>(s.initial_frames({body})); }, "body"_a,
          "Frames of the nodes of a rod at time 0 (n, 3, 3).")
      .def(
          "pin",
          [](Scene& s, int32_t body, nb::handle vertices) {
            const auto indices = array<Column<int32_t>>(vertices, "'" + s.name({body}) + "': pinned vertices",
                                                        "a row of vertex indices");
            s.pin({body}, values(indices));
          },
          "body"_a, "vertices"_a)
      .def(
          "pins",
          [](const Scene& s, int32_t body) {
            return to_numpy<int32_t>(std::vector<int32_t>(s.pins({body}).vertices));
          },
          "body"_a)
      .def(
          "set_friction",
          [](Scene& s, int32_t a, int32_t b, double sticking, double sliding) {
            s.set_friction({a}, {b}, {sticking, sliding});
          },
          "a"_a, "b"_a, "sticking"_a, "sliding"_a)
      .def(
          "set_anisotropic_friction",
          [](Scene& s, int32_t a, int32_t b, double along, double across, double kinetic) {
            s.set_anisotropic_friction({a}, {b}, {along, across, kinetic});
          },
          "a"_a, "b"_a, "along"_a, "across"_a, "kinetic"_a)
      .def(
          "friction",
          [](const Scene& s, int32_t a, int32_t b) {
            const FrictionCoefficient mu = s.friction({a}, {b});
            return nb::make_tuple(mu.sticking, mu.sliding, mu.along, mu.across);
          },
          "a"_a, "b"_a, "Static and kinetic coefficient and their shares along and across the direction.")
      .def(
          "set_restitution",
          [](Scene& s, int32_t a, int32_t b, double coefficient) {
            s.set_restitution({a}, {b}, coefficient);
          },
          "a"_a, "b"_a, "coefficient"_a)
      .def(
          "restitution", [](const Scene& s, int32_t a, int32_t b) { return s.restitution({a}, {b}); }, "a"_a,
          "b"_a, "Coefficient of a pair, None where it has none.")
      .def(
          "set_surface_directions",
          [](Scene& s, int32_t body, nb::handle directions) {
            s.set_surface_directions({body},
                                     points_of(directions, "'" + s.name({body}) + "': surface_direction"));
          },
          "body"_a, "directions"_a)
      .def(
          "surface_directions",
          [](const Scene& s, int32_t body) { return to_numpy<double>(s.surface_directions({body})); },
          "body"_a)
      .def_prop_rw("default_friction", &Scene::default_friction, &Scene::set_default_friction)
      .def(
          "disable_contact", [](Scene& s, int32_t a, int32_t b) { s.disable_contact({a}, {b}); }, "a"_a,
          "b"_a)
      .def(
          "disable_contacts",
          [](Scene& s, const std::vector<int32_t>& a, const std::vector<int32_t>& b) {
            for_each_pair_of(a, b, [&](BodyId i, BodyId j) { s.disable_contact(i, j); });
          },
          "a"_a, "b"_a, "Of each body of a with each other one of b.")
      .def(
          "enable_contacts",
          [](Scene& s, const std::vector<int32_t>& a, const std::vector<int32_t>& b) {
            for_each_pair_of(a, b, [&](BodyId i, BodyId j) { s.enable_contact(i, j); });
          },
          "a"_a, "b"_a)
      .def(
          "enable_contact", [](Scene& s, int32_t a, int32_t b) { s.enable_contact({a}, {b}); }, "a"_a, "b"_a)
      .def(
          "contact_enabled", [](const Scene& s, int32_t a, int32_t b) { return s.contact_enabled({a}, {b}); },
          "a"_a, "b"_a)
      .def(
          "contact_possible",
          [](const Scene& s, int32_t a, int32_t b) { return s.contact_possible({a}, {b}); }, "a"_a, "b"_a)
      .def(
          "meeting_matters", [](const Scene& s, int32_t a, int32_t b) { return s.meeting_matters({a}, {b}); },
          "a"_a, "b"_a)
      .def(
          "joint_contact", [](const Scene& s, int32_t joint) { return s.joint({joint}).contact; }, "joint"_a)
      .def(
          "attachment_contact", [](const Scene& s, int32_t k) { return s.attachment({k}).contact; },
          "attachment"_a)
      .def_prop_ro("body_count", &Scene::body_count)
      .def("contains", &Scene::contains, "name"_a)
      .def("free_name", &Scene::free_name, "stem"_a)
      .def(
          "find", [](const Scene& s, const std::string& name) { return s.find(name).index; }, "name"_a)
      .def(
          "name", [](const Scene& s, int32_t body) { return s.name({body}); }, "body"_a)
      .def(
          "kind", [](const Scene& s, int32_t body) { return to_string(s.kind({body})); }, "body"_a)
      .def(
          "motion", [](const Scene& s, int32_t body) { return to_string(s.motion({body})); }, "body"_a)
      .def(
          "contact_distance", [](const Scene& s, int32_t body) { return s.contact_distance({body}); },
          "body"_a)
      .def(
          "contact_stiffness", [](const Scene& s, int32_t body) { return s.contact_stiffness({body}); },
          "body"_a)
      .def(
          "initial_positions",
          [](const Scene& s, int32_t body) { return to_numpy<double>(s.initial_positions({body})); },
          "body"_a)
      .def(
          "pose",
          [](const Scene& s, int32_t body) {
            const RigidDescription& rigid = s.rigid({body});
            return nb::make_tuple(
                to_numpy<double>(std::vector<double>{rigid.position.x, rigid.position.y, rigid.position.z}),
                matrix_to_numpy(rigid.rotation));
          },
          "body"_a, "(position, rotation) of the mesh frame of a rigid body at time 0.")
      .def(
          "inertia", [](const Scene& s, int32_t body) { return inertia_to_dict(s.rigid_inertia({body})); },
          "body"_a)
      .def("add_energy", &add_energy, "description"_a, "Adds an energy of the user's own; returns its index.")
      .def(
          "energy_name", [](const Scene& s, int32_t energy) { return s.energy({energy}).name; }, "energy"_a)
      .def("add_joint", &add_joint, "description"_a, "Adds a joint; returns its index.")
      .def(
          "joint_name", [](const Scene& s, int32_t joint) { return s.joint({joint}).name; }, "joint"_a)
      .def("add_actuator", &add_actuator, "description"_a, "Adds an actuator; returns its index.")
      .def(
          "actuator_name", [](const Scene& s, int32_t k) { return s.actuator({k}).name; }, "actuator"_a)
      .def(
          "actuator_value",
          [](const Scene& s, int32_t k, const std::string& name) { return s.actuator({k}).values.at(name); },
          "actuator"_a, "name"_a)
      .def(
          "set_actuator_value",
          [](Scene& s, int32_t k, const std::string& name, double value) {
            s.set_actuator_value({k}, name, value);
          },
          "actuator"_a, "name"_a, "value"_a)
      .def(
          "actuator_enabled", [](const Scene& s, int32_t k) { return s.actuator({k}).enabled; }, "actuator"_a)
      .def(
          "set_actuator_enabled",
          [](Scene& s, int32_t k, bool enabled) { s.set_actuator_enabled({k}, enabled); }, "actuator"_a,
          "enabled"_a)
      .def_prop_ro("warnings", &Scene::warnings)
      .def(
          "contact_distance_in",
          [](const Scene& s, int32_t body, const Settings& settings) {
            return contact_distance(s, {body}, settings);
          },
          "body"_a, "settings"_a)
      .def(
          "check_contact_distances",
          [](const Scene& s, const Settings& settings) { return check_contact_distances(s, settings); },
          "settings"_a);
  bind_attachments_of_scene(m.attr("Scene"));
  bind_layers_of_scene(m.attr("Scene"));
}

}  // namespace

void bind_scene(nb::module_& m) {
  bind_settings(m);
  bind_described<ShellMaterial>(m, "ShellMaterial", "Parameters of cloth and thin shells.");
  bind_described<SolidMaterial>(m, "SolidMaterial", "Parameters of soft solids.");
  bind_described<RodMaterial>(m, "RodMaterial", "Parameters of rods.");
  m.def("rod_section", &section_to_dict, "material"_a, "What the cross-section gives a rod.");
  m.def(
      "rod_presets", [] { return bind_presets(materials::rod_presets()); },
      "(name, source, material) of each.");
  m.def(
      "shell_presets", [] { return bind_presets(materials::shell_presets()); },
      "(name, source, material) of each.");
  m.def(
      "solid_presets", [] { return bind_presets(materials::solid_presets()); },
      "(name, source, material) of each.");
  bind_scene_class(m);
}
