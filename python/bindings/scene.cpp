// Bindings of the scene description. The Python front end is stark/scene.py and its siblings.
#include <nanobind/nanobind.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <stark/sim/contact_distance.h>
#include <stark/sim/layers.h>
#include <stark/sim/lumped_mass.h>
#include <stark/sim/settings.h>
#include <stark/sim/unit_checks.h>

#include "descriptions.h"
#include "domains.h"

namespace {

namespace nb = nanobind;
using namespace nb::literals;
using namespace stark;
using namespace stark::bindings;
using Bodies = std::vector<BodyId>;

/// Each body of a with each other one of b.
template <void (Scene::*action)(BodyId, BodyId)>
void for_each_pair_of(Scene& scene, const Bodies& a, const Bodies& b) {
  for (const BodyId i : a)
    for (const BodyId j : b)
      if (i != j) (scene.*action)(i, j);
}

std::vector<Mat3> initial_fibre_frames(const Scene& scene, FibresId k) {
  const FibresDescription& fibres = scene.fibres(k);
  std::vector<Mat3> frames;
  if (!fibres.bending) return frames;
  for (const PathFrames& of_path : path_frames(scene, fibres))
    frames.insert(frames.end(), of_path.initial.begin(), of_path.initial.end());
  return frames;
}

void bind_friction(nb::class_<Scene>& c) {
  c.def(
       "set_friction",
       [](Scene& s, BodyId a, BodyId b, double sticking, double sliding) {
         s.set_friction(a, b, {sticking, sliding});
       },
       "a"_a, "b"_a, "sticking"_a, "sliding"_a)
      .def(
          "set_anisotropic_friction",
          [](Scene& s, BodyId a, BodyId b, double along, double across, double kinetic) {
            s.set_anisotropic_friction(a, b, {along, across, kinetic});
          },
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
      .def(
          "set_surface_directions",
          [](Scene& s, BodyId body, nb::handle directions) {
            s.set_surface_directions(body, points_of(directions, quoted(s, body) + ": surface_direction"));
          },
          "body"_a, "directions"_a)
      .def("surface_directions", with_arrays<&Scene::surface_directions>, "body"_a)
      .def(
          "set_surface_motion",
          [](Scene& s, BodyId body, nb::object velocity, nb::object spin, nb::object center) {
            s.set_surface_motion(body,
                                 {vector_of(velocity, "surface_velocity"), vector_of(spin, "surface_spin"),
                                  vector_of(center, "surface_center")});
          },
          "body"_a, "velocity"_a, "spin"_a, "center"_a)
      .def(
          "surface_motion",
          [](const Scene& s, BodyId body) -> std::optional<nb::tuple> {
            const std::optional<SurfaceMotion> motion = s.surface_motion(body);
            if (!motion) return std::nullopt;
            return nb::make_tuple(motion->velocity, motion->spin, motion->center);
          },
          "body"_a, "Velocity, spin and center of the motion of a surface; None where it rests.")
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
      .def("joint_contact", path_of<&Scene::joint, &JointDescription::contact>, "joint"_a)
      .def("attachment_contact", path_of<&Scene::attachment, &AttachmentDescription::contact>,
           "attachment"_a);
}

void bind_description(nb::class_<Scene>& c) {
  c.def_prop_ro("body_count", &Scene::body_count)
      .def("contains", &Scene::contains, "name"_a)
      .def("free_name", &Scene::free_name, "stem"_a)
      .def(
          "find", [](const Scene& s, const std::string& name) { return s.find(name); }, "name"_a)
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
  c.def("add_energy", adding<&Scene::add_energy, energy_of>, "description"_a,
        "Adds an energy of the user's own; returns its index.")
      .def("energy_name", path_of<&Scene::energy, &EnergyDescription::name>, "energy"_a)
      .def("add_joint", adding<&Scene::add_joint, joint_of>, "description"_a,
           "Adds a joint; returns its index.")
      .def("joint_name", path_of<&Scene::joint, &JointDescription::name>, "joint"_a)
      .def("add_actuator", adding<&Scene::add_actuator, actuator_of>, "description"_a,
           "Adds an actuator; returns its index.")
      .def("actuator_name", path_of<&Scene::actuator, &ActuatorDescription::name>, "actuator"_a)
      .def(
          "actuator_value",
          [](const Scene& s, ActuatorId k, const std::string& name) { return s.actuator(k).values.at(name); },
          "actuator"_a, "name"_a)
      .def("set_actuator_value", &Scene::set_actuator_value, "actuator"_a, "name"_a, "value"_a)
      .def("actuator_enabled", path_of<&Scene::actuator, &ActuatorDescription::enabled>, "actuator"_a)
      .def("set_actuator_enabled", &Scene::set_actuator_enabled, "actuator"_a, "enabled"_a)
      .def_prop_ro("warnings", &Scene::warnings)
      .def("contact_distance_in", contact_distance, "body"_a, "settings"_a)
      .def("check_contact_distances", check_contact_distances, "settings"_a)
      .def("check_units", check_units, "settings"_a)
      .def("add_attachment", adding<&Scene::add_attachment, attachment_of>, "description"_a,
           "Glues points; returns the index.")
      .def("attachment_name", path_of<&Scene::attachment, &AttachmentDescription::name>, "attachment"_a);
}

void bind_layers(nb::class_<Scene>& c) {
  c.def("add_skin", adding<&Scene::add_skin, skin_of>, "description"_a, "material"_a,
        "Adds a skin; returns its index.")
      .def("add_fibres", adding<&Scene::add_fibres, fibres_of>, "description"_a, "material"_a,
           "Adds fibres; returns their index.")
      .def("skin_name", path_of<&Scene::skin, &SkinDescription::name>, "skin"_a)
      .def(
          "fibres_name", [](const Scene& s, FibresId k) { return s.fibres(k).name; }, "fibres"_a)
      .def(
          "skin_mass", [](const Scene& s, SkinId k) { return total_mass(s, s.skin(k)); }, "skin"_a)
      .def(
          "fibres_mass", [](const Scene& s, FibresId k) { return total_mass(s, s.fibres(k)); }, "fibres"_a)
      .def(
          "mass", [](const Scene& s, BodyId body) { return total_mass(s, body); }, "body"_a,
          "Of a body with all of its layers [kg].")
      .def("initial_fibre_frames", with_arrays<initial_fibre_frames>, "fibres"_a,
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
