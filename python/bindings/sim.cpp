// Bindings of Simulation. The Python front end is stark/simulation.py.
#include <nanobind/nanobind.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
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
#include "report.h"
#include "small_arrays.h"
#include "state.h"
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

StepReport run_step(Simulation& sim, std::optional<double> max_time_step, nb::object progress,
                    double progress_period) {
  return watched(sim, {std::move(progress), progress_period},
                 [&]() -> StepReport { return max_time_step ? sim.step(*max_time_step) : sim.step(); });
}

bool resume(Simulation& sim, const State& before, std::optional<double> max_time_step, const State& state,
            double placed) {
  return watched(sim, {}, [&] { return sim.resume(before, max_time_step.value_or(1e300), state, placed); });
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
          "gravity", [](const Simulation& s) { return vector_to_numpy(s.settings().gravity); },
          nb::rv_policy::automatic, "(3,) [m/s^2]")
      .def_prop_ro("dof_count", &Simulation::dof_count)
      .def_prop_ro("body_count", [](const Simulation& s) { return s.scene().body_count(); })
      .def("positions",
           [](const Simulation& s, int body) { return to_numpy<double>(s.positions(BodyId{body})); })
      .def("velocities",
           [](const Simulation& s, int body) { return to_numpy<double>(s.velocities(BodyId{body})); })
      .def("pose",
           [](const Simulation& s, int body) {
             return nb::make_tuple(vector_to_numpy(s.position(BodyId{body})),
                                   matrix_to_numpy(s.rotation(BodyId{body})));
           })
      .def("twist",
           [](const Simulation& s, int body) {
             return nb::make_tuple(vector_to_numpy(s.linear_velocity(BodyId{body})),
                                   vector_to_numpy(s.angular_velocity(BodyId{body})));
           })
      .def(
          "center_velocity",
          [](const Simulation& s, int body) { return vector_to_numpy(s.centre_velocity(BodyId{body})); },
          "body"_a, "Of the centre of mass (3,) [m/s].")
      .def("acceleration",
           [](const Simulation& s, int body, nb::object point) {
             return vector_to_numpy(s.acceleration(BodyId{body}, vector_of(point, "point")));
           })
      .def(
          "set_pose",
          [](Simulation& s, int body, nb::object position, nb::object rotation, Duration duration) {
            s.set_pose(BodyId{body}, vector_of(position, "position"),
                       matrix_of(rotation, "rotation", "a 3 x 3 matrix"), duration);
          },
          "body"_a, "position"_a, "rotation"_a, "duration"_a = nb::none())
      .def("target_pose",
           [](const Simulation& s, int body) {
             Vec3 position;
             Mat3 rotation;
             s.target_pose(BodyId{body}, position, rotation);
             return nb::make_tuple(vector_to_numpy(position), matrix_to_numpy(rotation));
           })
      .def("set_twist",
           [](Simulation& s, int body, nb::object velocity, nb::object angular_velocity) {
             s.set_velocity(BodyId{body}, vector_of(velocity, "velocity"),
                            vector_of(angular_velocity, "angular_velocity"));
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
      .def(
          "set_rest_state",
          [](Simulation& s, int32_t body, const std::string& name, nb::handle numbers) {
            s.set_rest_state({body}, name,
                             values(array<Column<double>>(numbers, name, "a flat array of numbers")));
          },
          "body"_a, "name"_a, "values"_a)
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
          "joint_broken", [](const Simulation& s, int32_t joint) { return s.joint_broken({joint}); },
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
