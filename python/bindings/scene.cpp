// Bindings of the scene description. The Python front end is stark/scene.py and its siblings.
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
#include "body_descriptions.h"
#include "described.h"
#include "field_values.h"
#include "formulas.h"
#include "joints.h"
#include "layers.h"
#include "small_arrays.h"
#include "solid_mesh.h"

namespace {

namespace nb = nanobind;
using namespace nb::literals;
using namespace stark;
using namespace stark::bindings;

nb::dict inertia_to_dict(const RigidInertia& inertia) {
  nb::dict dict;
  dict["mass"] = inertia.mass;
  dict["center_of_mass"] = to_python(FieldValue(inertia.center_of_mass));
  dict["tensor"] = matrix_to_numpy(inertia.tensor);
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
          "set_rest_state",
          [](Scene& s, int32_t body, nb::handle given) {
            s.set_rest_state({body}, parameter_values_of(given, "'" + s.name({body}) + "'"));
          },
          "body"_a, "values"_a, "Fields of a rest state by name: (numbers, True).")
      .def(
          "check_rest_state",
          [](const Scene& s, int32_t body, nb::handle given) {
            s.check_rest_state({body}, parameter_values_of(given, "'" + s.name({body}) + "'"));
          },
          "body"_a, "values"_a)
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
          "contact_core", [](const Scene& s, int32_t body) { return s.contact_core({body}); }, "body"_a)
      .def(
          "is_filled", [](const Scene& s, int32_t body) { return s.is_filled({body}); }, "body"_a,
          "Whether a body is the solid inside of its closed surface.")
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

void bind_scene(nb::module_& m) { bind_scene_class(m); }
