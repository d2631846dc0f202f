// Bindings of the scene description. The Python front end is stark/scene.py and its siblings.
#include <stark/sim/scene/contact_distance.h>
#include <stark/sim/scene/layers.h>
#include <stark/sim/scene/lumped_mass.h>
#include <stark/sim/scene/unit_checks.h>

#include "descriptions.h"

namespace stark::bindings {

namespace {

using S = Scene;
using Class = nb::class_<Scene>;

std::string quoted(const S& s, BodyId body) { return "'" + s.name(body) + "'"; }

/// A function of a body and an array: errors name both.
template <typename List>
auto giving(void (S::*give)(BodyId, List), const char* name, const char* expected = "") {
  return [=](S& s, BodyId body, nb::handle given) {
    (s.*give)(body, read<Kept<List>>(given, quoted(s, body) + ": " + name, expected));
  };
}

/// A function of two bodies and a struct, which is given by its numbers.
template <typename... Numbers, typename Struct>
auto of_numbers(void (S::*set)(BodyId, BodyId, const Struct&)) {
  return [=](S& s, BodyId a, BodyId b, Numbers... numbers) { (s.*set)(a, b, Struct{numbers...}); };
}

/// Fields of a rest state by name: (numbers, per_element).
template <auto function, typename SceneReference>
void with_rest_state(SceneReference& s, BodyId body, nb::handle given) {
  (s.*function)(body, parameter_values_of(given, quoted(s, body)));
}

/// Static and kinetic coefficient and their shares along and across the direction.
auto friction(const S& s, BodyId a, BodyId b) {
  const FrictionCoefficient mu = s.friction(a, b);
  return std::tuple(mu.sticking, mu.sliding, mu.along, mu.across);
}

void set_surface_motion(S& s, BodyId body, const Vec3& velocity, const Vec3& spin, const Vec3& center) {
  s.set_surface_motion(body, {velocity, spin, center});
}

/// Of the mesh frame of a rigid body at time 0.
auto pose(const S& s, BodyId body) { return std::pair(s.rigid(body).position, s.rigid(body).rotation); }

/// With all of its layers [kg].
double mass(const S& s, BodyId body) { return total_mass(s, body); }
double skin_mass(const S& s, SkinId skin) { return total_mass(s, s.skin(skin)); }
double fibres_mass(const S& s, FibresId fibres) { return total_mass(s, s.fibres(fibres)); }

/// Of the nodes at time 0, path by path.
std::vector<Mat3> initial_fibre_frames(const S& s, FibresId fibres) {
  return initial_frames(s, s.fibres(fibres));
}

void bind_bodies(Class& c) {
  property<&S::body_count, &S::warnings>(c);
  def<&S::contains, &S::find>(c, {"name"});
  def<&S::free_name>(c, {"stem"});
  def<&S::name, &S::kind, &S::motion, &S::contact_distance, &S::contact_stiffness, &S::contact_core,
      &S::is_filled, &S::initial_positions, &S::initial_frames, pose, mass>(c, {"body"});
  def(c, "inertia", &S::rigid_inertia, {"body"});
  def(c, "set_rest_state", with_rest_state<&S::set_rest_state, S>, {"body", "values"});
  def(c, "check_rest_state", with_rest_state<&S::check_rest_state, const S>, {"body", "values"});
  def(c, "clamp", giving(&S::clamp, "clamped nodes", "a row of indices"), {"body", "nodes"});
  def(c, "clamped", path_of(&S::pins, &Pins::clamped), {"body"});
  def(c, "pin", giving(&S::pin, "pinned vertices", "a row of vertex indices"), {"body", "vertices"});
  def(c, "pins", path_of(&S::pins, &Pins::vertices), {"body"});
  def<check_contact_distances, check_units>(c, {"settings"});
  def(c, "contact_distance_in", contact_distance, {"body", "settings"});
}

void bind_friction(Class& c) {
  def(c, "set_friction", of_numbers<double, double>(&S::set_friction), {"a", "b", "sticking", "sliding"});
  def(c, "set_anisotropic_friction", of_numbers<double, double, double>(&S::set_anisotropic_friction),
      {"a", "b", "along", "across", "kinetic"});
  def<friction, &S::restitution>(c, {"a", "b"});
  def<&S::set_restitution>(c, {"a", "b", "coefficient"});
  def(c, "set_surface_directions", giving(&S::set_surface_directions, "surface_direction"),
      {"body", "directions"});
  def<&S::surface_directions, &S::surface_motion>(c, {"body"});
  def<set_surface_motion>(c, {"body", "surface_velocity", "surface_spin", "surface_center"});
  c.def_prop_rw("default_friction", &S::default_friction, &S::set_default_friction);
}

void bind_contact(Class& c) {
  def<&S::disable_contact, &S::enable_contact, &S::disable_contacts, &S::enable_contacts, &S::contact_enabled,
      &S::contact_possible, &S::meeting_matters>(c, {"a", "b"});
  c.def("pairs_without_contact", [](const S& scene) {
    return list_of(scene.pairs_without_contact(),
                   [](const auto& pair) { return nb::make_tuple(pair.first, pair.second); });
  });
  def(c, "joint_contact", path_of(&S::joint, &JointDescription::contact), {"joint"});
  def(c, "attachment_contact", path_of(&S::attachment, &AttachmentDescription::contact), {"attachment"});
}

/// Functions that add what dictionaries describe and return its index, and what is asked of it by that.
void bind_parts(Class& c) {
  def_adding(c, "add_cloth", &S::add_cloth, "cloth");
  def_adding(c, "add_solid", &S::add_solid, "solid");
  def_adding(c, "add_rigid", &S::add_rigid, "rigid body");
  def_adding(c, "add_rod", &S::add_rod, "rod");
  def_adding(c, "add_skin", &S::add_skin, "skin");
  def(c, "skin_name", path_of(&S::skin, &SkinDescription::name), {"skin"});
  def<skin_mass>(c, {"skin"});
  def_adding(c, "add_fibres", &S::add_fibres, "fibres", "vertices", "counts");
  def(c, "fibres_name", path_of(&S::fibres, &FibresDescription::name), {"fibres"});
  def<fibres_mass, initial_fibre_frames>(c, {"fibres"});
  def_adding(c, "add_energy", &S::add_energy, "energy", "formula_name", "doc", "points");
  def(c, "energy_name", path_of(&S::energy, &EnergyDescription::name), {"energy"});
  def_adding(c, "add_joint", &S::add_joint, "joint", "a", "b");
  def(c, "joint_name", path_of(&S::joint, &JointDescription::name), {"joint"});
  def_adding(c, "add_attachment", &S::add_attachment, "attachment", "a", "b");
  def(c, "attachment_name", path_of(&S::attachment, &AttachmentDescription::name), {"attachment"});
  def_adding(c, "add_actuator", &S::add_actuator, "actuator", "on");
  def(c, "actuator_name", path_of(&S::actuator, &ActuatorDescription::name), {"actuator"});
  def(c, "actuator_enabled", path_of(&S::actuator, &ActuatorDescription::enabled), {"actuator"});
  def<&S::actuator_value>(c, {"actuator", "name"});
  def<&S::set_actuator_value>(c, {"actuator", "name", "value"});
  def<&S::set_actuator_enabled>(c, {"actuator", "enabled"});
}

}  // namespace

void bind_scene(nb::module_& m) {
  Class scene(m, "Scene", "Description of what is simulated; bodies are indices in the order of adding.");
  scene.def(nb::init<>());
  def(scene, "copy", [](const S& s) { return S(s); });
  def(scene, "assign", [](S& s, const S& other) { s = other; }, {"other"});
  bind_bodies(scene);
  bind_friction(scene);
  bind_contact(scene);
  bind_parts(scene);
}

}  // namespace stark::bindings
