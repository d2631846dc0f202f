#include "report.h"

#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <stark/sim/step_report.h>

#include "diagnosis.h"
#include "small_arrays.h"

namespace stark::bindings {

namespace {

using namespace nb::literals;

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

}  // namespace

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
          "momentum", [](const StepReport& r) { return vector_to_numpy(r.momentum.linear); },
          nb::rv_policy::automatic, "Momentum of all free masses (3,) [N s].")
      .def_prop_ro(
          "angular_momentum", [](const StepReport& r) { return vector_to_numpy(r.momentum.angular); },
          nb::rv_policy::automatic, "Angular momentum of all free masses about the origin (3,) [N m s].")
      .def_prop_ro("phases", phases_dict, "Seconds by phase.")
      .def("brief", &StepReport::brief, "One line.")
      .def("to_dict", report_dict)
      .def("__repr__", [](const StepReport& r) { return "<stark.StepReport " + r.brief() + ">"; });
}

}  // namespace stark::bindings
