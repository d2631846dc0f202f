// Bindings of Simulation, State and StepReport. The Python front end is stark/simulation.py.
#include <nanobind/nanobind.h>
#include <nanobind/operators.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <cstdio>
#include <optional>

#include <stark/base/thread_pool.h>
#include <stark/geometry/topology.h>
#include <stark/sim/simulation.h>

#include "arrays.h"
#include "attachments.h"
#include "diagnosis.h"
#include "formulas.h"
#include "joints.h"
#include "layers.h"
#include "placing.h"
#include "stepping.h"
#include "watch.h"

namespace {

namespace nb = nanobind;
using namespace nb::literals;
using namespace stark;
using namespace stark::bindings;

/// What Ctrl-C raises.
void raise_signals() {
  if (PyErr_CheckSignals() != 0) throw nb::python_error();
}

const char* status_name(StepStatus status) {
  constexpr const char* kNames[] = {"accepted", "retried", "failed", "interrupted"};
  return kNames[static_cast<int>(status)];
}

nb::dict energy_dict(const StepReport& r) {
  nb::dict energy;
  energy["kinetic"] = r.energy.kinetic;
  energy["elastic"] = r.energy.elastic;
  energy["gravity"] = r.energy.gravity;
  energy["contact"] = r.energy.contact;
  energy["damping"] = r.energy.damping;
  energy["friction"] = r.energy.friction;
  energy["external"] = r.energy.external;
  energy["actuation"] = r.energy.actuation;
  energy["restitution"] = r.energy.restitution;
  energy["placed"] = r.energy.placed;
  energy["numerical"] = r.energy.numerical;
  return energy;
}

nb::dict components(const Vec3& v) {
  nb::dict d;
  d["x"] = v.x;
  d["y"] = v.y;
  d["z"] = v.z;
  return d;
}

nb::dict phases_dict(const StepReport& r) {
  nb::dict phases;
  for (size_t k = 0; k < r.phases.size(); ++k) phases[std::string(kPhaseNames[k]).c_str()] = r.phases[k];
  return phases;
}

std::vector<std::string> caveat_names(const StepReport& r) {
  std::vector<std::string> names;
  for (const Caveat caveat : r.caveats) names.push_back(to_string(caveat));
  return names;
}

nb::dict report_dict(const StepReport& r) {
  nb::dict d;
  d["status"] = status_name(r.status);
  d["message"] = r.message;
  d["step"] = r.step;
  d["time"] = r.time;
  d["time_step"] = r.time_step;
  d["integrator"] = to_string(r.integrator);
  d["newton_iterations"] = r.solve.iterations;
  d["linear_iterations"] = r.solve.linear_iterations;
  d["factorizations"] = r.solve.factorizations;
  d["line_search_backtracks"] = r.solve.backtracks;
  d["projected_iterations"] = r.solve.projected_iterations;
  d["rejected_steps"] = r.rejected_steps;
  d["solve_status"] = to_string(r.solve.status);
  d["at_rounding"] = r.solve.is_at_rounding;
  d["residual"] = r.solve.residual;
  d["acceleration"] = r.solve.acceleration;
  d["last_motion"] = r.solve.last_motion;
  if (!r.placed.empty()) d["placed"] = r.placed;
  d["contact_count"] = r.contact_count;
  d["min_distance"] = r.min_distance;
  d["friction_residual"] = r.friction_residual;
  d["energy"] = energy_dict(r);
  d["contact_energy_at_start"] = r.contact_energy_at_start;
  d["bristle_energy_at_start"] = r.bristle_energy_at_start;
  d["momentum"] = components(r.momentum.linear);
  d["angular_momentum"] = components(r.momentum.angular);
  d["phases"] = phases_dict(r);
  d["caveats"] = caveat_names(r);
  if (r.diagnosis) d["diagnosis"] = diagnosis_dict(r.diagnosis);
  return d;
}

std::string hex(uint64_t value) {
  char text[17];
  std::snprintf(text, sizeof(text), "%016llx", static_cast<unsigned long long>(value));
  return text;
}

/// A 3x3 matrix as a (3, 3) array.
nb::ndarray<nb::numpy, double> matrix(const Mat3& m) {
  return to_numpy<double>(std::vector<Vec3>{m.row(0), m.row(1), m.row(2)});
}

nb::ndarray<nb::numpy, double> vector3(const Vec3& v) {
  return to_numpy<double>(std::vector<double>{v.x, v.y, v.z});
}

Vec3 to_vec3(nb::handle object, const std::string& name) {
  const auto column = array<Column<double>>(object, name, "three numbers");
  if (column.shape(0) != 3)
    throw InvalidArgument(name + ": got " + std::to_string(column.shape(0)) + " numbers, need three");
  return {column.data()[0], column.data()[1], column.data()[2]};
}

Mat3 to_mat3(nb::handle object, const std::string& name) {
  const auto m = array<Rows<double, 3>>(object, name, "a 3x3 matrix");
  if (m.shape(0) != 3)
    throw InvalidArgument(name + ": got " + std::to_string(m.shape(0)) + " rows, need a 3x3 matrix");
  Mat3 result;
  std::copy_n(m.data(), 9, result.m.begin());
  return result;
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

/// A field as an array of its own.
nb::object copied(const StateArray& field) {
  size_t count = 1;
  for (const size_t extent : field.shape) count *= extent;
  const auto owned = [&]<typename T>(const T* data) {
    auto* values = new std::vector<T>(data, data + count);
    nb::capsule owner(values, [](void* p) noexcept { delete static_cast<std::vector<T>*>(p); });
    return nb::cast(nb::ndarray<nb::numpy, T>(values->data(), field.shape.size(), field.shape.data(), owner));
  };
  return field.is_integer ? owned(static_cast<const int64_t*>(field.data))
                          : owned(static_cast<const double*>(field.data));
}

nb::dict state_arrays(const State& state) {
  nb::dict arrays;
  for (const StateArray& field : arrays_of(state)) arrays[field.name.c_str()] = copied(field);
  return arrays;
}

nb::list state_fields() {
  nb::list fields;
  const State none;
  for (const StateArray& field : arrays_of(none)) {
    nb::dict row;
    row["name"] = field.name;
    row["unit"] = field.unit;
    row["meaning"] = field.meaning;
    fields.append(row);
  }
  return fields;
}

State state_of_arrays(const nb::dict& given) {
  using Any = nb::ndarray<nb::ro, nb::c_contig, nb::device::cpu>;
  std::vector<Any> kept;  // the arrays live as long as they are read
  std::vector<StateArray> arrays;
  for (const auto& [key, value] : given) {
    const std::string name = text(key);
    Any array;
    if (!nb::try_cast<Any>(value, array, false) ||
        (array.dtype() != nb::dtype<double>() && array.dtype() != nb::dtype<int64_t>()))
      throw InvalidArgument("state: the field '" + name +
                            "' must be a contiguous array of the type float64 or int64");
    StateArray field{.name = name, .unit = "", .meaning = ""};
    field.is_integer = array.dtype() == nb::dtype<int64_t>();
    for (size_t k = 0; k < array.ndim(); ++k) field.shape.push_back(array.shape(k));
    field.data = array.data();
    kept.push_back(array);
    arrays.push_back(field);
  }
  return make_state(arrays);
}

nb::list place_list(const Simulation& sim) {
  nb::list places;
  for (const ModelBody& body : sim.model().bodies()) {
    const bool is_rod = body.kind == BodyKind::Rod;
    const bool has_points = body.kind == BodyKind::Cloth || body.kind == BodyKind::Solid;
    places.append(nb::make_tuple(has_points ? body.first_site : 0, has_points ? body.site_count : 0,
                                 has_points ? 0 : body.rigid_index,
                                 is_rod ? body.site_count : (has_points ? 0 : 1)));
  }
  return places;
}

nb::list part_list(const Simulation& sim) {
  nb::list parts;
  for (const ModelPart& part : sim.model().parts())
    parts.append(nb::make_tuple(part.name, part.is_structure, hex(part.hash)));
  return parts;
}

void bind_state(nb::module_& m) {
  nb::class_<State>(m, "State", "Everything that changes in time, as a value.")
      .def_prop_ro(
          "time", [](const State& s) { return s.time; }, "Simulated time [s].")
      .def_prop_ro(
          "time_step", [](const State& s) { return s.time_step; },
          "Length of the next step, or less for the next mark [s].")
      .def_prop_ro(
          "step_count", [](const State& s) { return s.step_count; }, "Accepted steps so far.")
      .def_prop_ro(
          "point_positions",
          [](const State& s) { return to_numpy<double>(std::vector<Vec3>(s.point_position)); },
          nb::rv_policy::automatic, "Positions of the points of cloth and solids (n, 3) [m].")
      .def_prop_ro(
          "point_velocities",
          [](const State& s) { return to_numpy<double>(std::vector<Vec3>(s.point_velocity)); },
          nb::rv_policy::automatic, "Their velocities (n, 3) [m/s].")
      .def_prop_ro(
          "body_positions",
          [](const State& s) { return to_numpy<double>(std::vector<Vec3>(s.body_position)); },
          nb::rv_policy::automatic, "Centres of mass of rigid bodies, nodes of rods (n, 3) [m].")
      .def_prop_ro(
          "hash", [](const State& s) { return hex(s.hash()); }, "Hash of all bits, 16 hexadecimal digits.")
      .def(
          "copy", [](const State& s) { return s; }, "A state of its own: the same value.")
      .def("arrays", &state_arrays,
           "All fields by name, as arrays of their own; State.fields() describes them.")
      .def_static(
          "of_arrays", &state_of_arrays, "arrays"_a,
          "The state of what arrays() gave. Raises InvalidArgument for fields that are missing, unknown "
          "or of another type or shape.")
      .def_static("fields", &state_fields, "Name, unit and meaning of every field, in order.")
      .def("__eq__", [](const State& a, const State& b) { return first_difference(a, b).empty(); })
      .def(
          "first_difference", [](const State& a, const State& b) { return first_difference(a, b); },
          "Name of the first field that differs, '' when all bits are equal.");
}

void bind_report(nb::module_& m) {
  nb::class_<StepReport>(m, "StepReport", "What a time step did, whether it succeeded or not.")
      .def_prop_ro(
          "status", [](const StepReport& r) { return status_name(r.status); },
          "'accepted', 'retried' (after halvings of the step), 'failed' (state unchanged) or 'interrupted'.")
      .def_prop_ro("failed", [](const StepReport& r) { return r.failed(); })
      .def_ro("message", &StepReport::message)
      .def_prop_ro(
          "solve_status", [](const StepReport& r) { return to_string(r.solve.status); },
          "How the last attempt ended: 'converged', 'round_off', 'max_iterations', 'blocked', ...")
      .def_prop_ro(
          "at_rounding", [](const StepReport& r) { return r.solve.is_at_rounding; },
          "Whether it converged because all that is left is rounding: tolerances ask for less.")
      .def_prop_ro("caveats", caveat_names,
                   "What is not quite as asked of a step that was accepted: 'round_off' (the tolerances are "
                   "not met, forces are rounding), 'old_friction' (friction or joints are a refresh "
                   "behind).")
      .def_prop_ro(
          "diagnosis", [](const StepReport& r) { return r.diagnosis ? nb::cast(r.diagnosis) : nb::none(); },
          nb::sig("def diagnosis(self) -> Diagnosis | None"), "Why the step failed; None when it did not.")
      .def_ro("step", &StepReport::step, "Number of the step, from 1.")
      .def_ro("time", &StepReport::time, "Time at its end [s].")
      .def_ro("time_step", &StepReport::time_step, "[s]")
      .def_prop_ro(
          "integrator", [](const StepReport& r) { return to_string(r.integrator); },
          "What the step was taken with: 'implicit_euler', 'bdf2' or 'quasistatic'. Steps of bdf2 are "
          "'implicit_euler' at the start and where steps more than double.")
      .def_ro("rejected_steps", &StepReport::rejected_steps)
      .def_prop_ro(
          "placed", [](const StepReport& r) { return r.placed; },
          "Numbers of the bodies that were placed between the step before and this one.")
      .def_ro("contact_count", &StepReport::contact_count)
      .def_ro("min_distance", &StepReport::min_distance,
              "Smallest distance of an active contact [m], inf without any.")
      .def_ro("friction_residual", &StepReport::friction_residual,
              "Largest difference of a friction limit in this step from mu times the normal force at its end "
              "[N].")
      .def_prop_ro("newton_iterations", [](const StepReport& r) { return r.solve.iterations; })
      .def_prop_ro("linear_iterations", [](const StepReport& r) { return r.solve.linear_iterations; })
      .def_prop_ro("factorizations", [](const StepReport& r) { return r.solve.factorizations; })
      .def_prop_ro("line_search_backtracks", [](const StepReport& r) { return r.solve.backtracks; })
      .def_prop_ro(
          "residual", [](const StepReport& r) { return r.solve.residual; }, "Largest unbalanced force [N].")
      .def_prop_ro(
          "acceleration", [](const StepReport& r) { return r.solve.acceleration; },
          "Largest M^-1 residual [m/s^2].")
      .def_prop_ro(
          "last_motion", [](const StepReport& r) { return r.solve.last_motion; },
          "Largest motion of a vertex in the last Newton step, taken in full [m]; over the time step it is "
          "what newton.step_tolerance bounds.")
      .def_ro("contact_energy_at_start", &StepReport::contact_energy_at_start,
              "Of the barriers at the start of the step, with the stiffness of this step [J].")
      .def_ro("bristle_energy_at_start", &StepReport::bristle_energy_at_start,
              "Stored by sticking friction at the start of the step, with the limits of this step [J]: what "
              "friction can give back in it.")
      .def_prop_ro(
          "energy", energy_dict,
          "Stored at the end of the step: kinetic, elastic, gravity, contact [J]. Turned over by the "
          "step: damping, friction (dissipated), external (work of scripted and pinned parts), "
          "actuation (work of actuators), placed (given by placing bodies before the step), "
          "numerical (what closes the balance) [J].")
      .def_prop_ro(
          "momentum", [](const StepReport& r) { return vector3(r.momentum.linear); },
          nb::rv_policy::automatic, "Momentum of all free masses (3,) [N s].")
      .def_prop_ro(
          "angular_momentum", [](const StepReport& r) { return vector3(r.momentum.angular); },
          nb::rv_policy::automatic, "Angular momentum of all free masses about the origin (3,) [N m s].")
      .def_prop_ro("phases", phases_dict, "Seconds by phase.")
      .def("brief", &StepReport::brief, "One line.")
      .def("to_dict", report_dict)
      .def("__repr__", [](const StepReport& r) { return "<stark.StepReport " + r.brief() + ">"; });
}

using Duration = std::optional<double>;  // [s]

/// All edges, those inside flat faces of rigid bodies included, which contact leaves out: for judges.
std::vector<Index2> all_edges(const SurfaceMesh& mesh) {
  std::vector<Index2> edges = find_edges(std::span<const Index3>(mesh.triangles));
  const size_t of_triangles = edges.size();
  for (const Index2& e : mesh.edges)
    if (!std::binary_search(edges.begin(), edges.begin() + of_triangles, e)) edges.push_back(e);
  return edges;
}

nb::dict surface_dict(const Simulation& sim) {
  const SurfaceMesh& mesh = sim.surface_mesh();
  nb::dict d;
  d["positions"] = to_numpy<double>(sim.site_positions());
  d["edges"] = to_numpy<int32_t>(all_edges(mesh));
  d["triangles"] = to_numpy<int32_t>(std::vector<Index3>(mesh.triangles));
  d["vertex_groups"] = to_numpy<int32_t>(std::vector<int32_t>(mesh.vertex_group));
  return d;
}

nb::list kernel_list(const Simulation& sim) {
  nb::list kernels;
  for (const ModelBatch& batch : sim.energies().batches) {
    const Potential& potential = batch.batch.potential();
    nb::dict row;
    row["name"] = potential.name();
    row["body"] = batch.owner;
    row["elements"] = batch.batch.size();
    row["backend"] = symbolic::to_string(potential.kernel().backend());
    kernels.append(row);
  }
  return kernels;
}

}  // namespace

void bind_simulation(nb::module_& m) {
  bind_state(m);
  bind_diagnosis(m);
  bind_report(m);
  bind_step_progress(m);
  m.def("usable_threads", &usable_threads, "asked"_a = 0,
        "Threads that a simulation runs on that asks for so many, 0 for all.");
  nb::class_<Simulation>(m, "Simulation", "Model, state and solver of a scene; bodies are indices.")
      .def(
          "__init__",
          [](Simulation* self, const Scene& scene, const Settings& settings) {
            new (self) Simulation(scene, settings, raise_signals);
          },
          "scene"_a, "settings"_a)
      .def("step", &run_step, "max_time_step"_a = nb::none(), "progress"_a = nb::none(),
           "progress_period"_a = 0.0)
      .def_prop_ro(
          "report", [](const Simulation& s) { return s.report(); }, "Report of the last step.")
      .def_prop_ro("time", &Simulation::time)
      .def_prop_ro("time_step", [](const Simulation& s) { return s.next_step().length; })
      .def(
          "next_step",
          [](const Simulation& s, std::optional<double> limit) {
            const PlannedStep planned = s.next_step(limit.value_or(1e300));
            return nb::make_tuple(planned.length, planned.end);
          },
          "max_time_step"_a = nb::none(), "Length of the coming step and the time at its end [s].")
      .def_prop_rw(
          "state", [](const Simulation& s) { return s.state(); }, &Simulation::set_state)
      .def("reset", &Simulation::reset, "Rewinds to the start.")
      .def("check_state", &Simulation::check_state, "Findings about the state that do not prevent a step.")
      .def(
          "close_bodies",
          [](const Simulation& s) {
            nb::list pairs;
            for (size_t k = 0; k < s.state().contact_close_bodies.size(); ++k) {
              const int64_t code = s.state().contact_close_bodies[k];
              pairs.append(
                  nb::make_tuple(code >> 32, code & 0xffffffff, s.state().contact_close_distance[k]));
            }
            return pairs;
          },
          "Pairs of bodies that started within their contact distance, and the one that they have now [m].")
      .def("resume", &resume, "before"_a, "max_time_step"_a.none(), "state"_a, "placed"_a,
           "Takes the step from `before` to `state` again; whether it came to the same places.")
      .def_prop_ro("state_hash", [](const Simulation& s) { return hex(s.state().hash()); })
      .def_prop_ro("thread_count", &Simulation::thread_count)
      .def_prop_ro(
          "gravity", [](const Simulation& s) { return vector3(s.settings().gravity); },
          nb::rv_policy::automatic, "(3,) [m/s^2]")
      .def_prop_ro("dof_count", &Simulation::dof_count)
      .def_prop_ro("body_count", [](const Simulation& s) { return s.scene().body_count(); })
      .def("positions",
           [](const Simulation& s, int body) { return to_numpy<double>(s.positions(BodyId{body})); })
      .def("velocities",
           [](const Simulation& s, int body) { return to_numpy<double>(s.velocities(BodyId{body})); })
      .def("pose",
           [](const Simulation& s, int body) {
             return nb::make_tuple(vector3(s.position(BodyId{body})), matrix(s.rotation(BodyId{body})));
           })
      .def("twist",
           [](const Simulation& s, int body) {
             return nb::make_tuple(vector3(s.linear_velocity(BodyId{body})),
                                   vector3(s.angular_velocity(BodyId{body})));
           })
      .def(
          "center_velocity",
          [](const Simulation& s, int body) { return vector3(s.centre_velocity(BodyId{body})); }, "body"_a,
          "Of the centre of mass (3,) [m/s].")
      .def("acceleration",
           [](const Simulation& s, int body, nb::object point) {
             return vector3(s.acceleration(BodyId{body}, to_vec3(point, "point")));
           })
      .def(
          "set_pose",
          [](Simulation& s, int body, nb::object position, nb::object rotation, Duration duration) {
            s.set_pose(BodyId{body}, to_vec3(position, "position"), to_mat3(rotation, "rotation"), duration);
          },
          "body"_a, "position"_a, "rotation"_a, "duration"_a = nb::none())
      .def("target_pose",
           [](const Simulation& s, int body) {
             Vec3 position;
             Mat3 rotation;
             s.target_pose(BodyId{body}, position, rotation);
             return nb::make_tuple(vector3(position), matrix(rotation));
           })
      .def("set_twist",
           [](Simulation& s, int body, nb::object velocity, nb::object angular_velocity) {
             s.set_velocity(BodyId{body}, to_vec3(velocity, "velocity"),
                            to_vec3(angular_velocity, "angular_velocity"));
           })
      .def("pin_targets",
           [](const Simulation& s, int body) { return to_numpy<double>(s.pin_targets(BodyId{body})); })
      .def(
          "set_pin_targets",
          [](Simulation& s, int body, nb::object targets, Duration duration) {
            const auto t = array<Rows<double, 3>>(targets, "targets", "an (n, 3) array of positions");
            s.set_pin_targets(BodyId{body}, rows<Vec3>(t), duration);
          },
          "body"_a, "targets"_a, "duration"_a = nb::none())
      .def("frames", [](const Simulation& s, int body) { return to_numpy<double>(s.frames(BodyId{body})); })
      .def("clamp_targets",
           [](const Simulation& s, int body) { return to_numpy<double>(s.clamp_targets(BodyId{body})); })
      .def(
          "set_clamp_targets",
          [](Simulation& s, int body, nb::object targets, Duration duration) {
            const auto t = array<Rows<double, 9>>(targets, "targets", "an (n, 9) array of rotations");
            s.set_clamp_targets(BodyId{body}, rows<Mat3>(t), duration);
          },
          "body"_a, "targets"_a, "duration"_a = nb::none())
      .def("set_energy_value", &set_energy_value, "energy"_a, "name"_a, "values"_a)
      .def(
          "element_energies",
          [](const Simulation& s, int32_t energy) { return to_numpy<double>(s.element_energies({energy})); },
          "energy"_a, "Energies of its elements (n,) [J].")
      .def(
          "element_forces",
          [](const Simulation& s, int32_t energy) { return to_numpy<double>(s.element_forces({energy})); },
          "energy"_a, "Forces on the points of its elements in the last step (n * points, 3) [N].")
      .def_prop_ro("joint_count", [](const Simulation& s) { return s.scene().joints().size(); })
      .def_prop_ro("exclusion_count", &Simulation::exclusion_count)
      .def(
          "joint_coordinates",
          [](const Simulation& s, int32_t joint) { return to_numpy<double>(s.joint_coordinates({joint})); },
          "joint"_a, "[m, rad]")
      .def(
          "joint_coordinate",
          [](const Simulation& s, int32_t joint, int32_t k) { return s.joint_coordinates({joint}).at(k); },
          "joint"_a, "coordinate"_a, "One of them [m, rad].")
      .def(
          "joint_rates",
          [](const Simulation& s, int32_t joint) { return to_numpy<double>(s.joint_rates({joint})); },
          "joint"_a, "[m/s, rad/s]")
      .def(
          "joint_residuals",
          [](const Simulation& s, int32_t joint) { return to_numpy<double>(s.joint_residuals({joint})); },
          "joint"_a, "[m, rad]")
      .def("joint_reaction", &joint_reaction, "joint"_a,
           "(force [N], torque [N m]) on frame b in the last step.")
      .def(
          "joint_enabled", [](const Simulation& s, int32_t joint) { return s.joint_enabled({joint}); },
          "joint"_a)
      .def(
          "set_joint_enabled",
          [](Simulation& s, int32_t joint, bool enabled) { s.set_joint_enabled({joint}, enabled); },
          "joint"_a, "enabled"_a)
      .def_prop_ro("actuator_count", [](const Simulation& s) { return s.scene().actuators().size(); })
      .def(
          "actuator_value",
          [](const Simulation& s, int32_t k, const std::string& name) { return s.actuator_value({k}, name); },
          "actuator"_a, "name"_a)
      .def(
          "set_actuator_value",
          [](Simulation& s, int32_t k, const std::string& name, double value) {
            s.set_actuator_value({k}, name, value);
          },
          "actuator"_a, "name"_a, "value"_a, "From the next step on.")
      .def(
          "actuator_enabled", [](const Simulation& s, int32_t k) { return s.actuator_enabled({k}); },
          "actuator"_a)
      .def(
          "set_actuator_enabled",
          [](Simulation& s, int32_t k, bool enabled) { s.set_actuator_enabled({k}, enabled); }, "actuator"_a,
          "enabled"_a)
      .def(
          "actuator_effort", [](const Simulation& s, int32_t k) { return s.actuator_effort({k}); },
          "actuator"_a, "Along its first coordinate in the last step [N, N m].")
      .def(
          "actuator_power", [](const Simulation& s, int32_t k) { return s.actuator_power({k}); },
          "actuator"_a, "Fed into the motion in the last step [W].")
      .def("surface", surface_dict, "All collision primitives: positions, edges, triangles, vertex_groups.")
      .def("places", place_list,
           "Where each body is in the arrays of the state: first row and count of points, then of bodies.")
      .def("parts", part_list, "What the model was made of: name, whether a state depends on it, hash.")
      .def("kernels", kernel_list, "Energies of the model: name, body, elements, backend.");
  bind_attachments_of_simulation(m.attr("Simulation"));
  bind_layers_of_simulation(m.attr("Simulation"));
  bind_placing_of_simulation(m.attr("Simulation"));
}
