// Bindings of Simulation. The Python front end is stark/simulation.py.
#include <stark/base/hash.h>
#include <stark/base/thread_pool.h>
#include <stark/sim/contact_arrays.h>
#include <stark/sim/step/placing.h>

#include "functions.h"
#include "stepping.h"

namespace stark::bindings {

namespace {

using S = Simulation;
using Class = nb::class_<Simulation>;

void make(S* self, const Scene& scene, const Settings& settings) {
  const auto raise_signals = [] {  // of Ctrl-C
    if (PyErr_CheckSignals() != 0) throw nb::python_error();
  };
  new (self) S(scene, settings, raise_signals);
}

StepReport run_step(S& sim, std::optional<double> limit, nb::object progress, double period) {
  const auto step = [&]() -> StepReport { return sim.step(limit.value_or(1e300)); };
  return watched(sim, step, std::move(progress), period);
}

bool resume(S& sim, const State& before, std::optional<double> limit, const State& state, double placed) {
  return watched(sim, [&] { return sim.resume(before, limit.value_or(1e300), state, placed); });
}

auto next_step(const S& sim, std::optional<double> limit) {
  const PlannedStep planned = sim.next_step(limit.value_or(1e300));
  return std::pair(planned.length, planned.end);
}

nb::list place_list(const S& sim) {
  return list_of(sim.model().bodies(), [](const ModelBody& body) {
    if (has_points(body.kind)) return nb::make_tuple(body.first_site, body.site_count, 0, 0);
    return nb::make_tuple(0, 0, body.rigid_index, body.rigid_count());
  });
}

nb::list part_list(const S& sim) {
  return list_of(sim.model().parts(), [](const ModelPart& part) {
    return nb::make_tuple(part.name, part.is_structure, to_hex(part.hash));
  });
}

nb::dict surface_dict(const S& sim) {
  const SurfaceMesh& mesh = sim.surface_mesh();
  nb::dict dict;
  dict["positions"] = to_numpy(sim.site_positions());
  dict["edges"] = to_numpy(all_edges(mesh));
  dict["triangles"] = to_numpy(mesh.triangles);
  dict["vertex_groups"] = to_numpy(mesh.vertex_group);
  return dict;
}

nb::dict contact_dict(const S& sim) {
  nb::dict dict;
  contact_arrays(sim).for_each(
      [&](const char* name, auto& array) { dict[name] = to_array(std::move(array)); });
  return dict;
}

nb::dict variable_dict(S& sim, BodyId body) {
  nb::dict found;
  for (InternalVariable& variable : sim.internal_variables(body))
    found[variable.name.c_str()] =
        nb::make_tuple(variable.points, variable.width, to_array(std::move(variable.values)));
  return found;
}

/// Two answers about a body as a pair.
template <auto first, auto second>
constexpr auto both = [](const S& s, BodyId body) {
  return std::pair(std::invoke(first, s, body), std::invoke(second, s, body));
};

/// Sets numbers by name, which errors tell.
template <typename Id>
auto setting_numbers(void (S::*set)(Id, const std::string&, std::span<const double>)) {
  return [=](S& s, Id id, const std::string& name, nb::handle numbers) {
    (s.*set)(id, name, array_of<double>(numbers, name, "a flat array of numbers"));
  };
}

/// How many of a kind the scene has.
template <auto parts>
constexpr auto count_of = [](const S& s) { return std::invoke(parts, s.scene()).size(); };

void bind_time(Class& c) {
  c.def("step", run_step, "max_time_step"_a = nb::none(), "progress"_a = nb::none(),
        "progress_period"_a = 0.0);
  c.def_prop_rw("state", &S::state, &S::set_state, nb::for_getter(nb::rv_policy::copy));
  def(c, "next_step", next_step, {{"max_time_step", nb::none()}});
  def(c, "resume", resume, {"before", "max_time_step", "state", "placed"});
  def<&S::reset, &S::check_state, &S::close_bodies>(c);
  property<&S::report, &S::time, &S::thread_count, &S::dof_count>(c);
  property(c, "time_step", [](const S& s) { return s.next_step().length; });
  property(c, "state_hash", [](const S& s) { return to_hex(s.state().hash()); });
  property(c, "gravity", path<&S::settings, &Settings::gravity>);
  property(c, "body_count", path<&S::scene, &Scene::body_count>);
}

void bind_bodies(Class& c) {
  def<&S::positions, &S::velocities, &S::target_pose, &S::surface_motion, &S::pin_targets, &S::pin_forces,
      &S::clamp_targets, &S::clamp_torques, &S::mean_stresses, &S::volume_ratios, &S::section_wrenches,
      &S::holding_wrench>(c, {"body"});
  def(c, "frames", nb::overload_cast<BodyId>(&S::frames, nb::const_), {"body"});
  def(c, "pose", both<&S::position, &S::rotation>, {"body"});
  def<&S::poses>(c, {"bodies"});
  def(c, "twist", both<&S::linear_velocity, &S::angular_velocity>, {"body"});
  def(c, "center_velocity", &S::centre_velocity, {"body"});
  def<&S::acceleration>(c, {"body", "point"});
  def(c, "internal_variables", variable_dict, {"body"},
      "By name: quadrature points of an element, numbers of a value, all numbers.");
  const Argument duration("duration", nb::none());
  def<&S::set_pose>(c, {"body", "position", "rotation: a 3 x 3 matrix", duration});
  def<&S::set_pin_targets>(c, {"body", "targets: an (n, 3) array of positions", duration});
  def<&S::set_clamp_targets>(c, {"body", "targets: an (n, 9) array of rotations", duration});
  def(c, "set_twist", &S::set_velocity, {"body", "velocity", "angular_velocity"});
  def<&S::set_surface_motion>(c, {"body", "surface_velocity", "surface_spin"});
  def(c, "set_rest_state", setting_numbers(&S::set_rest_state), {"body", "name", "values"});
}

void bind_energies_and_actuators(Class& c) {
  def<&S::element_energies, &S::element_forces>(c, {"energy"});
  def(c, "energy_totals", path_of(&S::energy_plane, &TouchingPlane::totals), {"energy"});
  def(c, "energy_slopes", path_of(&S::energy_plane, &TouchingPlane::slopes), {"energy"});
  def(c, "set_energy_value", setting_numbers(&S::set_energy_value), {"energy", "name", "values"});
  property(c, "actuator_count", count_of<&Scene::actuators>);
  def<&S::actuator_enabled, &S::actuator_effort, &S::actuator_power>(c, {"actuator"});
  def<&S::set_actuator_enabled>(c, {"actuator", "enabled"});
  def<&S::actuator_value>(c, {"actuator", "name"});
  def<&S::set_actuator_value>(c, {"actuator", "name", "value"});
}

void bind_constraints(Class& c) {
  property<&S::exclusion_count, &S::held_places>(c);
  property(c, "joint_count", count_of<&Scene::joints>);
  def<&S::joint_coordinates, &S::joint_rates, &S::joint_residuals, &S::joint_reaction, &S::joint_enabled,
      &S::joint_broken, &S::check_joint_agrees, &S::hold_joint_here>(c, {"joint"});
  def(c, "first_joint_place", nb::overload_cast<JointId>(&S::first_held_place, nb::const_), {"joint"});
  def<&S::set_joint_enabled>(c, {"joint", "enabled"});
  property(c, "attachment_count", count_of<&Scene::attachments>);
  def<&S::attachment_forces, &S::attachment_gaps, &S::attachment_status, &S::check_attachment_agrees>(
      c, {"attachment"});
  def(c, "first_held_place", nb::overload_cast<AttachmentId>(&S::first_held_place, nb::const_),
      {"attachment"});
  def<&S::set_attachment_enabled>(c, {"attachment", "enabled"});
  def<&S::hold_pairs_here, &S::release_pairs>(c, {"attachment", "pairs: numbers"});
}

void bind_model(Class& c) {
  property(c, "skin_count", count_of<&Scene::skins>);
  property(c, "fibres_count", [](const S& s) { return s.scene().fibres().size(); });
  def(c, "fibre_frames", nb::overload_cast<FibresId>(&S::frames, nb::const_), {"fibres"});
  def(c, "surface", surface_dict, "All collision primitives: positions, edges, triangles, vertex_groups.");
  def(c, "places", place_list,
      "Where each body is in the arrays of the state: first row and count of points, then of bodies.");
  def(c, "parts", part_list, "What the model was made of: name, whether a state depends on it, hash.");
}

/// Bodies put elsewhere between steps. The Python front end is stark/placing.py.
void bind_placing(Class& c) {
  def<&S::begin_placing, &S::end_placing, &S::cancel_placing>(c);
  property<&S::is_placing>(c);
  property(c, "placed_bodies", path<&S::placed, &Placed::bodies>);
  def<&S::place>(c, {"body", "position", "rotation: a 3x3 matrix"});
  def<&S::push>(c, {"body", "velocity", "angular_velocity"});
  def<&S::place_together>(c, {"bodies: numbers", "rotation: a 3x3 matrix", "shift"});
  def<&S::place_vertices>(c, {"body", "positions: an (n, 3) array of positions"});
  def<&S::push_vertices>(c, {"body", "velocities: an (n, 3) array of velocities"});
  def<&S::place_joint>(c, {"joint", "coordinates: numbers"});
  def<&S::push_joint>(c, {"joint", "rates: numbers"});
}

/// What is asked of contact.
void bind_contacts(nb::module_& m) {
  def(m, "contacts", contact_dict, {"simulation"},
      "The contacts of the last step: arrays with one row each; forces are on the first body.");
  def<&S::contact_force, &S::vertex_contact_forces, inner_vertices>(m, {"simulation", "body"});
  def<&S::closest_points>(m, {"simulation", "a", "b"});
}

}  // namespace

void bind_simulation(nb::module_& m) {
  bind_state(m);
  bind_report(m);
  def<usable_threads>(m, {{"asked", 0}});
  Class simulation(m, "Simulation", "Model, state and solver of a scene; bodies are indices.");
  def(simulation, "__init__", make, {"scene", "settings"});
  bind_time(simulation);
  bind_bodies(simulation);
  bind_energies_and_actuators(simulation);
  bind_constraints(simulation);
  bind_model(simulation);
  bind_placing(simulation);
  bind_contacts(m);
}

}  // namespace stark::bindings
