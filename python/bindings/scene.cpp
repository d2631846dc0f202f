// Bindings of the scene description. The Python front end is stark/scene.py and its siblings.
#include <stark/sim/contact_distance.h>
#include <stark/sim/layers.h>
#include <stark/sim/lumped_mass.h>
#include <stark/sim/unit_checks.h>

#include "descriptions.h"
#include "with_arrays.h"

namespace stark::bindings {

namespace {

using Bodies = std::vector<BodyId>;

std::string quoted(const Scene& s, BodyId body) { return "'" + s.name(body) + "'"; }

/// A function of a body and an array: errors name both.
template <typename List>
auto giving(void (Scene::*give)(BodyId, List), const char* name, const char* expected = "") {
  return [=](Scene& s, BodyId body, nb::handle given) {
    (s.*give)(body, read<typename Kept<List>::type>(given, quoted(s, body) + ": " + name, expected));
  };
}

/// A function of two bodies and a struct, which is given by its numbers.
template <typename... Numbers, typename Struct>
auto of_numbers(void (Scene::*set)(BodyId, BodyId, const Struct&)) {
  return [=](Scene& s, BodyId a, BodyId b, Numbers... numbers) { (s.*set)(a, b, Struct{numbers...}); };
}

/// Fields of a rest state by name: (numbers, per_element).
template <auto function, typename SceneReference>
void with_rest_state(SceneReference& s, BodyId body, nb::handle given) {
  (s.*function)(body, parameter_values_of(given, quoted(s, body)));
}

/// Each body of a with each other one of b.
template <void (Scene::*action)(BodyId, BodyId)>
void for_each_pair_of(Scene& scene, const Bodies& a, const Bodies& b) {
  for (const BodyId i : a)
    for (const BodyId j : b)
      if (i != j) (scene.*action)(i, j);
}

template <typename Layer, typename Id>
auto layer_mass(const Layer& (Scene::*layer)(Id) const) {
  return [=](const Scene& scene, Id k) { return total_mass(scene, (scene.*layer)(k)); };
}

void bind_bodies(nb::class_<Scene>& c) {
  c.def("add_cloth", adding(&Scene::add_cloth, "cloth"), "description"_a, "material"_a)
      .def("add_solid", adding(&Scene::add_solid, "solid"), "description"_a, "material"_a)
      .def("add_rigid", adding(&Scene::add_rigid, "rigid body"), "description"_a)
      .def("add_rod", adding(&Scene::add_rod, "rod"), "description"_a, "material"_a)
      .def("set_rest_state", with_rest_state<&Scene::set_rest_state, Scene>, "body"_a, "values"_a,
           "Fields of a rest state by name: (numbers, True).")
      .def("check_rest_state", with_rest_state<&Scene::check_rest_state, const Scene>, "body"_a, "values"_a)
      .def("clamp", giving(&Scene::clamp, "clamped nodes", "a row of indices"), "body"_a, "nodes"_a)
      .def("clamped", path_of(&Scene::pins, &Pins::clamped), "body"_a)
      .def("initial_frames", with_arrays<&Scene::initial_frames>, "body"_a,
           "Frames of the nodes of a rod at time 0 (n, 3, 3).")
      .def("pin", giving(&Scene::pin, "pinned vertices", "a row of vertex indices"), "body"_a, "vertices"_a)
      .def("pins", path_of(&Scene::pins, &Pins::vertices), "body"_a);
}

void bind_friction(nb::class_<Scene>& c) {
  c.def("set_friction", of_numbers<double, double>(&Scene::set_friction), "a"_a, "b"_a, "sticking"_a,
        "sliding"_a)
      .def("set_anisotropic_friction", of_numbers<double, double, double>(&Scene::set_anisotropic_friction),
           "a"_a, "b"_a, "along"_a, "across"_a, "kinetic"_a)
      .def(
          "friction",
          [](const Scene& s, BodyId a, BodyId b) {
            const FrictionCoefficient mu = s.friction(a, b);
            return nb::make_tuple(mu.sticking, mu.sliding, mu.along, mu.across);
          },
          "a"_a, "b"_a, "Static and kinetic coefficient and their shares along and across the direction.")
      .def("set_restitution", &Scene::set_restitution, "a"_a, "b"_a, "coefficient"_a)
      .def("restitution", &Scene::restitution, "a"_a, "b"_a, "Coefficient of a pair, None where it has none.")
      .def("set_surface_directions", giving(&Scene::set_surface_directions, "surface_direction"), "body"_a,
           "directions"_a)
      .def("surface_directions", with_arrays<&Scene::surface_directions>, "body"_a)
      .def(
          "set_surface_motion",
          [](Scene& s, BodyId body, nb::handle velocity, nb::handle spin, nb::handle center) {
            s.set_surface_motion(body,
                                 {read<Vec3>(velocity, "surface_velocity"), read<Vec3>(spin, "surface_spin"),
                                  read<Vec3>(center, "surface_center")});
          },
          "body"_a, "velocity"_a, "spin"_a, "center"_a)
      .def("surface_motion", &Scene::surface_motion, "body"_a,
           "Velocity, spin and center of the motion of a surface; None where it rests.")
      .def_prop_rw("default_friction", &Scene::default_friction, &Scene::set_default_friction);
}

void bind_contact(nb::class_<Scene>& c) {
  c.def("disable_contact", &Scene::disable_contact, "a"_a, "b"_a)
      .def("disable_contacts", for_each_pair_of<&Scene::disable_contact>, "a"_a, "b"_a,
           "Of each body of a with each other one of b.")
      .def("enable_contacts", for_each_pair_of<&Scene::enable_contact>, "a"_a, "b"_a)
      .def("enable_contact", &Scene::enable_contact, "a"_a, "b"_a)
      .def("contact_enabled", &Scene::contact_enabled, "a"_a, "b"_a)
      .def("contact_possible", &Scene::contact_possible, "a"_a, "b"_a)
      .def("meeting_matters", &Scene::meeting_matters, "a"_a, "b"_a)
      .def("joint_contact", path_of(&Scene::joint, &JointDescription::contact), "joint"_a)
      .def("attachment_contact", path_of(&Scene::attachment, &AttachmentDescription::contact),
           "attachment"_a);
}

void bind_description(nb::class_<Scene>& c) {
  c.def_prop_ro("body_count", &Scene::body_count)
      .def("contains", &Scene::contains, "name"_a)
      .def("free_name", &Scene::free_name, "stem"_a)
      .def("find", &Scene::find, "name"_a)
      .def("name", &Scene::name, "body"_a)
      .def("kind", &Scene::kind, "body"_a)
      .def("motion", &Scene::motion, "body"_a)
      .def("contact_distance", &Scene::contact_distance, "body"_a)
      .def("contact_stiffness", &Scene::contact_stiffness, "body"_a)
      .def("contact_core", &Scene::contact_core, "body"_a)
      .def("is_filled", &Scene::is_filled, "body"_a,
           "Whether a body is the solid inside of its closed surface.")
      .def("initial_positions", with_arrays<&Scene::initial_positions>, "body"_a)
      .def(
          "pose",
          [](const Scene& s, BodyId body) {
            return nb::make_tuple(s.rigid(body).position, s.rigid(body).rotation);
          },
          "body"_a, "(position, rotation) of the mesh frame of a rigid body at time 0.")
      .def(
          "inertia",
          [](const Scene& s, BodyId body) {
            const auto& [mass, center, tensor] = s.rigid_inertia(body);
            return dict_of("mass", mass, "center_of_mass", to_python(FieldValue(center)), "tensor", tensor);
          },
          "body"_a);
}

void bind_actions(nb::class_<Scene>& c) {
  c.def("add_energy", adding(&Scene::add_energy, "energy", "formula_name", "doc", "points"), "description"_a,
        "Adds an energy of the user's own; returns its index.")
      .def("energy_name", path_of(&Scene::energy, &EnergyDescription::name), "energy"_a)
      .def("add_joint", adding(&Scene::add_joint, "joint", "a", "b"), "description"_a,
           "Adds a joint; returns its index.")
      .def("joint_name", path_of(&Scene::joint, &JointDescription::name), "joint"_a)
      .def("add_actuator", adding(&Scene::add_actuator, "actuator", "on"), "description"_a,
           "Adds an actuator; returns its index.")
      .def("actuator_name", path_of(&Scene::actuator, &ActuatorDescription::name), "actuator"_a)
      .def(
          "actuator_value",
          [](const Scene& s, ActuatorId k, const std::string& name) { return s.actuator(k).values.at(name); },
          "actuator"_a, "name"_a)
      .def("set_actuator_value", &Scene::set_actuator_value, "actuator"_a, "name"_a, "value"_a)
      .def("actuator_enabled", path_of(&Scene::actuator, &ActuatorDescription::enabled), "actuator"_a)
      .def("set_actuator_enabled", &Scene::set_actuator_enabled, "actuator"_a, "enabled"_a)
      .def_prop_ro("warnings", &Scene::warnings)
      .def("contact_distance_in", contact_distance, "body"_a, "settings"_a)
      .def("check_contact_distances", check_contact_distances, "settings"_a)
      .def("check_units", check_units, "settings"_a)
      .def("add_attachment", adding(&Scene::add_attachment, "attachment", "a", "b"), "description"_a,
           "Glues points; returns the index.")
      .def("attachment_name", path_of(&Scene::attachment, &AttachmentDescription::name), "attachment"_a);
}

void bind_layers(nb::class_<Scene>& c) {
  c.def("add_skin", adding(&Scene::add_skin, "skin"), "description"_a, "material"_a,
        "Adds a skin; returns its index.")
      .def("add_fibres", adding(&Scene::add_fibres, "fibres", "vertices", "counts"), "description"_a,
           "material"_a, "Adds fibres; returns their index.")
      .def("skin_name", path_of(&Scene::skin, &SkinDescription::name), "skin"_a)
      .def("fibres_name", path_of(&Scene::fibres, &FibresDescription::name), "fibres"_a)
      .def("skin_mass", layer_mass(&Scene::skin), "skin"_a)
      .def("fibres_mass", layer_mass(&Scene::fibres), "fibres"_a)
      .def("mass", nb::overload_cast<const Scene&, BodyId>(&total_mass), "body"_a,
           "Of a body with all of its layers [kg].")
      .def(
          "initial_fibre_frames",
          [](const Scene& s, FibresId k) { return ArrayOf{initial_frames(s, s.fibres(k))}; }, "fibres"_a,
          "Frames of the nodes at time 0, path by path (n, 3, 3).");
}

}  // namespace

void bind_scene(nb::module_& m) {
  nb::class_<Scene> scene(m, "Scene",
                          "Description of what is simulated; bodies are indices in the order of adding.");
  scene.def(nb::init<>())
      .def("copy", [](const Scene& s) { return Scene(s); })
      .def("assign", [](Scene& s, const Scene& other) { s = other; }, "other"_a);
  bind_bodies(scene);
  bind_friction(scene);
  bind_contact(scene);
  bind_description(scene);
  bind_actions(scene);
  bind_layers(scene);
}

}  // namespace stark::bindings
