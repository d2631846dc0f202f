// Bindings of Simulation. The Python front end is stark/simulation.py.
#include <optional>

#include <stark/base/hash.h>
#include <stark/base/thread_pool.h>
#include <stark/sim/contact_arrays.h>
#include <stark/sim/placing.h>

#include "stepping.h"
#include "with_arrays.h"

namespace stark::bindings {

/// Force, then torque.
template <>
struct NumbersOf<Wrench> : NumbersOf<Vec3> {};

namespace {

/// What Ctrl-C raises.
void raise_signals() {
  if (PyErr_CheckSignals() != 0) throw nb::python_error();
}

StepReport run_step(Simulation& sim, std::optional<double> max_time_step, nb::object progress,
                    double progress_period) {
  return watched(sim, {std::move(progress), progress_period},
                 [&]() -> StepReport { return max_time_step ? sim.step(*max_time_step) : sim.step(); });
}

bool resume(Simulation& sim, const State& before, std::optional<double> max_time_step, const State& state,
            double placed) {
  return watched(sim, {}, [&] { return sim.resume(before, max_time_step.value_or(1e300), state, placed); });
}

/// First row and count of points, then of bodies, in the arrays of the state.
nb::list place_list(const Simulation& sim) {
  return list_of(sim.model().bodies(), [](const ModelBody& body) {
    if (has_points(body.kind)) return nb::make_tuple(body.first_site, body.site_count, 0, 0);
    return nb::make_tuple(0, 0, body.rigid_index, body.rigid_count());
  });
}

/// First number of a constraint in held_places, -1 if it holds nothing but what it was added with.
int64_t first_held_place(const Simulation& sim, int32_t constraint) {
  const HeldPlace* place = sim.find_held_place(constraint);
  return place ? place->first : -1;
}

nb::list part_list(const Simulation& sim) {
  return list_of(sim.model().parts(), [](const ModelPart& part) {
    return nb::make_tuple(part.name, part.is_structure, to_hex(part.hash));
  });
}

/// Frames of the nodes of a rod, or of fibres.
template <typename Id>
constexpr auto kFrames = static_cast<std::vector<Mat3> (Simulation::*)(Id) const>(&Simulation::frames);

nb::dict surface_dict(const Simulation& sim) {
  const SurfaceMesh& mesh = sim.surface_mesh();
  return dict_of("positions", to_numpy(sim.site_positions()), "edges", to_numpy(all_edges(mesh)), "triangles",
                 to_numpy(mesh.triangles), "vertex_groups", to_numpy(mesh.vertex_group));
}

nb::list kernel_list(const Simulation& sim) {
  return list_of(sim.energies().batches, [](const ModelBatch& batch) {
    const Potential& potential = batch.batch.potential();
    return dict_of("name", potential.name(), "body", batch.owner, "elements", batch.batch.size(), "backend",
                   potential.kernel().backend());
  });
}

/// Pairs of bodies that started within their contact distance, and the one that they have now [m].
nb::list close_bodies(const Simulation& sim) {
  nb::list pairs;
  for (size_t k = 0; k < sim.state().contact_close_bodies.size(); ++k) {
    const auto [a, b] = groups_of_code(sim.state().contact_close_bodies[k]);
    pairs.append(nb::make_tuple(a, b, sim.state().contact_close_distance[k]));
  }
  return pairs;
}

std::pair<Vec3, Mat3> target_pose(const Simulation& sim, BodyId body) {
  std::pair<Vec3, Mat3> pose;
  sim.target_pose(body, pose.first, pose.second);
  return pose;
}

nb::tuple poses(const Simulation& sim, const std::vector<BodyId>& bodies) {
  std::vector<Vec3> positions;
  std::vector<Mat3> rotations;
  for (const BodyId body : bodies) {
    positions.push_back(sim.position(body));
    rotations.push_back(sim.rotation(body));
  }
  return nb::make_tuple(to_numpy(positions), to_numpy(rotations, {bodies.size(), 3, 3}));
}

std::optional<SurfaceMotion> surface_motion(const Simulation& sim, BodyId body) {
  if (!sim.scene().surface_motion(body)) return std::nullopt;
  return sim.surface_motion(body);
}

nb::dict contact_dict(const Simulation& sim) {
  nb::dict dict;
  contact_arrays(sim).for_each(
      [&](const char* name, auto& array) { dict[name] = ArrayOf{std::move(array)}; });
  return dict;
}

nb::dict variable_dict(Simulation& sim, BodyId body) {
  nb::dict found;
  for (InternalVariable& variable : sim.internal_variables(body))
    found[variable.name.c_str()] =
        nb::make_tuple(variable.points, variable.width, ArrayOf{std::move(variable.values)});
  return found;
}

/// Two answers about a body as a pair.
template <auto first, auto second>
constexpr auto both = [](const Simulation& s, BodyId body) {
  return std::pair(std::invoke(first, s, body), std::invoke(second, s, body));
};

/// Sets numbers by name, which errors tell.
template <typename Id>
auto setting_numbers(void (Simulation::*set)(Id, const std::string&, std::span<const double>)) {
  return [=](Simulation& s, Id id, const std::string& name, nb::handle numbers) {
    (s.*set)(id, name, array_of<double>(numbers, name, "a flat array of numbers"));
  };
}

/// How many of a kind the scene has.
template <auto parts>
constexpr auto count_of = [](const Simulation& s) { return (s.scene().*parts)().size(); };

void bind_time(nb::class_<Simulation>& c) {
  c.def("step", &run_step, "max_time_step"_a = nb::none(), "progress"_a = nb::none(),
        "progress_period"_a = 0.0)
      .def_prop_ro("report", &Simulation::report, nb::rv_policy::copy, "Report of the last step.")
      .def_prop_ro("time", &Simulation::time)
      .def_prop_ro("time_step", [](const Simulation& s) { return s.next_step().length; })
      .def(
          "next_step",
          [](const Simulation& s, std::optional<double> limit) {
            const PlannedStep planned = s.next_step(limit.value_or(1e300));
            return nb::make_tuple(planned.length, planned.end);
          },
          "max_time_step"_a = nb::none(), "Length of the coming step and the time at its end [s].")
      .def_prop_rw("state", &Simulation::state, &Simulation::set_state, nb::for_getter(nb::rv_policy::copy))
      .def("reset", &Simulation::reset, "Rewinds to the start.")
      .def("check_state", &Simulation::check_state, "Findings about the state that do not prevent a step.")
      .def("close_bodies", &close_bodies,
           "Pairs of bodies that started within their contact distance, and the one that they have now [m].")
      .def("resume", &resume, "before"_a, "max_time_step"_a.none(), "state"_a, "placed"_a,
           "Takes the step from `before` to `state` again; whether it came to the same places.")
      .def_prop_ro("state_hash", [](const Simulation& s) { return to_hex(s.state().hash()); })
      .def_prop_ro("thread_count", &Simulation::thread_count)
      .def_prop_ro("gravity", path<&Simulation::settings, &Settings::gravity>, "(3,) [m/s^2]")
      .def_prop_ro("dof_count", &Simulation::dof_count)
      .def_prop_ro("body_count", path<&Simulation::scene, &Scene::body_count>);
}

void bind_bodies(nb::class_<Simulation>& c) {
  c.def("positions", with_arrays<&Simulation::positions>)
      .def("velocities", with_arrays<&Simulation::velocities>)
      .def("pose", both<&Simulation::position, &Simulation::rotation>)
      .def("poses", &poses, "bodies"_a, "Of mesh frames: positions (k, 3) [m], rotations (k, 3, 3).")
      .def("twist", both<&Simulation::linear_velocity, &Simulation::angular_velocity>)
      .def("center_velocity", &Simulation::centre_velocity, "body"_a, "Of the centre of mass (3,) [m/s].")
      .def("acceleration", with_arrays<&Simulation::acceleration, "point">)
      .def("set_pose", with_arrays<&Simulation::set_pose, "position", "rotation: a 3 x 3 matrix">, "body"_a,
           "position"_a, "rotation"_a, "duration"_a = nb::none())
      .def("target_pose", &target_pose)
      .def("set_twist", with_arrays<&Simulation::set_velocity, "velocity", "angular_velocity">)
      .def("set_surface_motion",
           with_arrays<&Simulation::set_surface_motion, "surface_velocity", "surface_spin">, "body"_a,
           "velocity"_a, "spin"_a)
      .def("surface_motion", &surface_motion, "body"_a,
           "Velocity, spin and center of the motion of a surface; None where it rests.")
      .def("pin_targets", with_arrays<&Simulation::pin_targets>)
      .def("set_pin_targets",
           with_arrays<&Simulation::set_pin_targets, "targets: an (n, 3) array of positions">, "body"_a,
           "targets"_a, "duration"_a = nb::none())
      .def("frames", with_arrays<kFrames<BodyId>>)
      .def("clamp_targets", with_arrays<&Simulation::clamp_targets>)
      .def("set_clamp_targets",
           with_arrays<&Simulation::set_clamp_targets, "targets: an (n, 9) array of rotations">, "body"_a,
           "targets"_a, "duration"_a = nb::none())
      .def("set_rest_state", setting_numbers(&Simulation::set_rest_state), "body"_a, "name"_a, "values"_a);
}

void bind_energies_and_joints(nb::class_<Simulation>& c) {
  c.def("set_energy_value", setting_numbers(&Simulation::set_energy_value), "energy"_a, "name"_a, "values"_a)
      .def("element_energies", with_arrays<&Simulation::element_energies>, "energy"_a,
           "Energies of its elements (n,) [J].")
      .def("element_forces", with_arrays<&Simulation::element_forces>, "energy"_a,
           "Forces on the points of its elements in the last step (n * points, 3) [N].")
      .def("energy_totals", path_of(&Simulation::energy_plane, &TouchingPlane::totals), "energy"_a)
      .def("energy_slopes", path_of(&Simulation::energy_plane, &TouchingPlane::slopes), "energy"_a,
           "Derivatives of an energy by its totals.")
      .def("mean_stresses", with_arrays<&Simulation::mean_stresses>, "body"_a,
           "Cauchy stress of each element (m, 3, 3) [Pa], of cloth times the thickness [N/m].")
      .def("internal_variables", &variable_dict, "body"_a,
           "By name: quadrature points of an element, numbers of a value, all numbers.")
      .def("pin_forces", with_arrays<&Simulation::pin_forces>, "body"_a,
           "Forces that hold the pins in the last step (k, 3) [N].")
      .def("clamp_torques", with_arrays<&Simulation::clamp_torques>, "body"_a,
           "Torques that hold the clamped frames in the last step (k, 3) [N m].")
      .def("section_wrenches", with_arrays<&Simulation::section_wrenches>, "body"_a,
           "Forces [N] and torques [N m] that the segments of a rod transmit (m, 6).")
      .def("holding_wrench", &Simulation::holding_wrench, "body"_a,
           "(force [N], torque [N m]) that hold or drive a rigid body in the last step, about its origin.")
      .def_prop_ro("joint_count", count_of<&Scene::joints>)
      .def_prop_ro("exclusion_count", &Simulation::exclusion_count)
      .def("joint_coordinates", with_arrays<&Simulation::joint_coordinates>, "joint"_a, "[m, rad]")
      .def(
          "joint_coordinate",
          [](const Simulation& s, JointId joint, int32_t k) { return s.joint_coordinates(joint).at(k); },
          "joint"_a, "coordinate"_a, "One of them [m, rad].")
      .def("joint_rates", with_arrays<&Simulation::joint_rates>, "joint"_a, "[m/s, rad/s]")
      .def("joint_residuals", with_arrays<&Simulation::joint_residuals>, "joint"_a, "[m, rad]")
      .def("joint_reaction", &Simulation::joint_reaction, "joint"_a,
           "(force [N], torque [N m]) on frame b in the last step.")
      .def("joint_enabled", &Simulation::joint_enabled, "joint"_a)
      .def("joint_broken", &Simulation::joint_broken, "joint"_a)
      .def("set_joint_enabled", &Simulation::set_joint_enabled, "joint"_a, "enabled"_a)
      .def("check_joint_agrees", &Simulation::check_joint_agrees, "joint"_a)
      .def("hold_joint_here", &Simulation::hold_joint_here, "joint"_a)
      .def(
          "first_joint_place",
          [](const Simulation& s, JointId joint) { return first_held_place(s, joint.index); }, "joint"_a,
          "First of its 12 or 3 numbers in held_places, -1 if it has none there.");
}

void bind_actuators_and_attachments(nb::class_<Simulation>& c) {
  c.def_prop_ro("actuator_count", count_of<&Scene::actuators>)
      .def("actuator_value", &Simulation::actuator_value, "actuator"_a, "name"_a)
      .def("set_actuator_value", &Simulation::set_actuator_value, "actuator"_a, "name"_a, "value"_a,
           "From the next step on.")
      .def("actuator_enabled", &Simulation::actuator_enabled, "actuator"_a)
      .def("set_actuator_enabled", &Simulation::set_actuator_enabled, "actuator"_a, "enabled"_a)
      .def("actuator_effort", &Simulation::actuator_effort, "actuator"_a,
           "Along its first coordinate in the last step [N, N m].")
      .def("actuator_power", &Simulation::actuator_power, "actuator"_a,
           "Fed into the motion in the last step [W].")
      .def("surface", surface_dict, "All collision primitives: positions, edges, triangles, vertex_groups.")
      .def("places", place_list,
           "Where each body is in the arrays of the state: first row and count of points, then of bodies.")
      .def("parts", part_list, "What the model was made of: name, whether a state depends on it, hash.")
      .def("kernels", kernel_list, "Energies of the model: name, body, elements, backend.")
      .def_prop_ro("attachment_count", count_of<&Scene::attachments>)
      .def("attachment_forces", with_arrays<&Simulation::attachment_forces>, "attachment"_a,
           "On side a in the last step (n, 3) [N].")
      .def("attachment_gaps", with_arrays<&Simulation::attachment_gaps>, "attachment"_a,
           "By pair: distance from where it is attached [m].")
      .def("attachment_status", with_arrays<&Simulation::attachment_status>, "attachment"_a,
           "By pair: 1 held, 0 released, -1 broken.")
      .def("set_attachment_enabled", &Simulation::set_attachment_enabled, "attachment"_a, "enabled"_a)
      .def("check_attachment_agrees", &Simulation::check_attachment_agrees, "attachment"_a)
      .def("hold_pairs_here", with_arrays<&Simulation::hold_pairs_here, "pairs: numbers">, "attachment"_a,
           "pairs"_a)
      .def("release_pairs", with_arrays<&Simulation::release_pairs, "pairs: numbers">, "attachment"_a,
           "pairs"_a)
      .def(
          "first_held_place",
          [](const Simulation& s, AttachmentId attachment) {
            return first_held_place(s, s.model().attachments()[attachment.index].first_constraint);
          },
          "attachment"_a,
          "First number of its pairs in held_places, three for each; -1 if it has none there.")
      .def_prop_ro(
          "held_places", with_arrays<&Simulation::held_places>,
          "Where side a is on the carriers of side b, of joints, then of pairs that hold what they find.")
      .def_prop_ro("skin_count", count_of<&Scene::skins>)
      .def_prop_ro("fibres_count", [](const Simulation& s) { return s.scene().fibres().size(); })
      .def("fibre_frames", with_arrays<kFrames<FibresId>>, "fibres"_a,
           "Frames of the nodes, path by path (n, 3, 3).");
}

/// Bodies put elsewhere between steps. The Python front end is stark/placing.py.
void bind_placing(nb::class_<Simulation>& c) {
  c.def("begin_placing", &Simulation::begin_placing)
      .def("end_placing", &Simulation::end_placing, "Checks what was placed; puts all back where it fails.")
      .def("cancel_placing", &Simulation::cancel_placing)
      .def_prop_ro("is_placing", &Simulation::is_placing)
      .def_prop_ro(
          "placed_bodies", [](const Simulation& s) { return ArrayOf{s.placed().bodies}; },
          "Bodies placed since the last step, by number.")
      .def("place", with_arrays<&Simulation::place, "position", "rotation: a 3x3 matrix">, "body"_a,
           "position"_a, "rotation"_a)
      .def("push", with_arrays<&Simulation::push, "velocity", "angular_velocity">, "body"_a, "velocity"_a,
           "angular_velocity"_a)
      .def("place_together",
           with_arrays<&Simulation::place_together, "bodies: numbers", "rotation: a 3x3 matrix", "shift">,
           "bodies"_a, "rotation"_a, "shift"_a)
      .def("place_vertices",
           with_arrays<&Simulation::place_vertices, "positions: an (n, 3) array of positions">, "body"_a,
           "positions"_a)
      .def("push_vertices",
           with_arrays<&Simulation::push_vertices, "velocities: an (n, 3) array of velocities">, "body"_a,
           "velocities"_a)
      .def("place_joint", with_arrays<&Simulation::place_joint, "coordinates: numbers">, "joint"_a,
           "coordinates"_a)
      .def("push_joint", with_arrays<&Simulation::push_joint, "rates: numbers">, "joint"_a, "rates"_a);
}

/// What is asked of contact.
void bind_contacts(nb::module_& m) {
  m.def("contacts", &contact_dict, "simulation"_a,
        "The contacts of the last step: arrays with one row each; forces are on the first body.");
  m.def("contact_force", &Simulation::contact_force, "simulation"_a, "body"_a,
        "Sum of the contact forces on a body in the last step (3,) [N].");
  m.def("vertex_contact_forces", with_arrays<&Simulation::vertex_contact_forces>, "simulation"_a, "body"_a,
        "Sum of the contact forces on each vertex of a body in the last step (n, 3) [N].");
  m.def("closest_points", &Simulation::closest_points, "simulation"_a, "a"_a, "b"_a,
        "Distance of two bodies [m], and where they are nearest [m].");
  m.def("inner_vertices", with_arrays<inner_vertices>, "simulation"_a, "body"_a,
        "Vertices inside flat faces of a rigid body, where contact never acts (n,).");
}

}  // namespace

void bind_simulation(nb::module_& m) {
  bind_state(m);
  bind_report(m);
  bind_step_progress(m);
  m.def("usable_threads", &usable_threads, "asked"_a = 0,
        "Threads that a simulation runs on that asks for so many, 0 for all.");
  nb::class_<Simulation> simulation(m, "Simulation",
                                    "Model, state and solver of a scene; bodies are indices.");
  simulation.def(
      "__init__",
      [](Simulation* self, const Scene& scene, const Settings& settings) {
        new (self) Simulation(scene, settings, raise_signals);
      },
      "scene"_a, "settings"_a);
  bind_time(simulation);
  bind_bodies(simulation);
  bind_energies_and_joints(simulation);
  bind_actuators_and_attachments(simulation);
  bind_placing(simulation);
  bind_contacts(m);
}

}  // namespace stark::bindings
