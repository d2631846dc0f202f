// Bindings of what a step reports: numbers of the step, and the diagnosis of one that failed.
#include <nanobind/nanobind.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <stark/sim/step_report.h>

#include "casters.h"
#include "domains.h"

namespace {

namespace nb = nanobind;
using namespace nb::literals;
using namespace stark;
using namespace stark::bindings;

template <typename... More>
nb::dict place(const BodyVertices& p, More&&... more) {
  return dict_of("body", p.body, "vertices", p.vertices, std::forward<More>(more)...);
}

nb::list forces(const Diagnosis& d) {
  return list_of(d.evidence.forces, [](const UnbalancedForce& f) {
    const Vec3& x = f.position;
    return place(f.at, "position", nb::make_tuple(x.x, x.y, x.z), "force", f.force, "acceleration",
                 f.acceleration);
  });
}

template <std::vector<NarrowGap> StepEvidence::* gaps>
nb::list gap_list(const Diagnosis& d) {
  return list_of(d.evidence.*gaps, [](const NarrowGap& gap) {
    return dict_of("a", place(gap.a), "b", place(gap.b), "distance", gap.distance, "contact_distance",
                   gap.contact_distance);
  });
}

nb::object blocking(const Diagnosis& d) {
  if (!d.evidence.blocking) return nb::none();
  const auto& [a, b, fraction] = *d.evidence.blocking;
  return dict_of("a", place(a), "b", place(b), "fraction", fraction);
}

nb::list elements(const Diagnosis& d) {
  return list_of(d.evidence.elements, [](const StrainedElement& e) {
    return place(e.at, "element", e.element, "stretch", e.stretch, "size", e.size);
  });
}

nb::list attempts(const Diagnosis& d) {
  return list_of(d.evidence.attempts, [](const Attempt& a) {
    return dict_of("time_step", a.time_step, "status", a.status, "iterations", a.iterations);
  });
}

nb::dict diagnosis_dict(nb::handle diagnosis) {
  return attributes_of(diagnosis,
                       {"cause", "finding", "remedy", "bodies", "forces", "gaps", "start_gaps", "blocking",
                        "elements", "pushing", "force_rounding", "acceleration_rounding", "stiffness_ratio",
                        "unit_suspicions", "attempts"});
}

void bind_diagnosis(nb::module_& m) {
  using D = Diagnosis;
  using E = StepEvidence;
  nb::class_<D>(m, "Diagnosis", "Why a step failed: cause, bodies, vertices and numbers, and what to change.")
      .def_prop_ro(
          "cause", path<&D::cause>,
          "'blocked_motion', 'overconstrained_pins', 'contradicting_joints', 'inverted_element', "
          "'not_finite', 'singular_energy', 'tolerance_below_round_off', 'no_equilibrium', "
          "'thickness_overlap', "
          "'unit_mistake', 'crushing_load', 'overload', 'detour', 'singular_system', 'stiffness_contrast', "
          "'iteration_budget', "
          "'time_budget', 'unknown'.")
      .def_ro("finding", &D::finding, "What was found, with names, numbers and units.")
      .def_ro("remedy", &D::remedy, "What to change.")
      .def_ro("bodies", &D::bodies, "Bodies involved: \"cloth 'towel'\".")
      .def_prop_ro(
          "forces", forces,
          "Largest unbalanced forces: body, vertices, position [m], force [N], acceleration [m/s^2].")
      .def_prop_ro("gaps", gap_list<&E::gaps>,
                   "Narrowest gaps where the last attempt ended: a, b, distance [m], contact_distance [m].")
      .def_prop_ro("start_gaps", gap_list<&E::start_gaps>, "Narrowest gaps at the start of the step.")
      .def_prop_ro("blocking", blocking,
                   "The parts that limit the last Newton step: a, b, fraction of it; None when nothing does.")
      .def_prop_ro("elements", elements,
                   "Elements farthest from rest: body, vertices, element, stretch of an edge, size (of "
                   "volume, area "
                   "or length, below 0 where inverted), both over those at rest.")
      .def_prop_ro("pushing", path<&D::evidence, &E::pushing>,
                   "Bodies with scripted or pinned parts that move in the step.")
      .def_prop_ro("force_rounding", path<&D::evidence, &E::force_rounding>,
                   "Unbalanced force that rounding of the positions makes [N].")
      .def_prop_ro("acceleration_rounding", path<&D::evidence, &E::acceleration_rounding>,
                   "The same over the mass of its node or body [m/s^2].")
      .def_prop_ro("stiffness_ratio", path<&D::evidence, &E::stiffness_ratio>,
                   "Of the stiffest to the softest node or body.")
      .def_prop_ro("unit_suspicions", path<&D::evidence, &E::unit_suspicions>,
                   "Numbers that look as if in other units.")
      .def_prop_ro("attempts", attempts, "Each attempt at the step: time_step [s], status, iterations.")
      .def("to_dict", diagnosis_dict, "All of it as dictionaries, lists, numbers and texts.")
      .def("__repr__", [](const D& d) {
        return "<stark.Diagnosis " + to_string(d.cause) + ": " + d.finding + "; " + d.remedy + ">";
      });
}

nb::dict energy_dict(const StepReport& r) {
  const EnergyLedger& e = r.energy;
  return dict_of("kinetic", e.kinetic, "elastic", e.elastic, "gravity", e.gravity, "contact", e.contact,
                 "damping", e.damping, "friction", e.friction, "external", e.external, "actuation",
                 e.actuation, "belts", e.belts, "restitution", e.restitution, "placed", e.placed, "numerical",
                 e.numerical);
}

nb::dict phases_dict(const StepReport& r) {
  nb::dict phases;
  for (size_t k = 0; k < r.phases.size(); ++k) phases[std::string(kPhaseNames[k]).c_str()] = r.phases[k];
  return phases;
}

nb::dict report_dict(nb::handle self) {
  nb::dict d = attributes_of(
      self, {"status", "message", "step", "time", "time_step", "integrator", "newton_iterations",
             "linear_iterations", "factorizations", "line_search_backtracks"});
  const auto& r = nb::cast<const StepReport&>(self);
  d["projected_iterations"] = r.solve.projected_iterations;
  d.update(attributes_of(
      self, {"rejected_steps", "solve_status", "at_rounding", "residual", "acceleration", "last_motion"}));
  if (!r.placed.empty()) d["placed"] = r.placed;
  d.update(attributes_of(self, {"contact_count", "min_distance", "friction_residual", "energy",
                                "contact_energy_at_start", "bristle_energy_at_start"}));
  const auto components = [](const Vec3& v) { return dict_of("x", v.x, "y", v.y, "z", v.z); };
  d["momentum"] = components(r.momentum.linear);
  d["angular_momentum"] = components(r.momentum.angular);
  d.update(attributes_of(self, {"phases", "caveats"}));
  if (r.diagnosis) d["diagnosis"] = diagnosis_dict(self.attr("diagnosis"));
  return d;
}

}  // namespace

void bind_report(nb::module_& m) {
  bind_diagnosis(m);
  using R = StepReport;
  using S = SolveReport;
  nb::class_<R>(m, "StepReport", "What a time step did, whether it succeeded or not.")
      .def_prop_ro(
          "status", path<&R::status>,
          "'accepted', 'retried' (after halvings of the step), 'failed' (state unchanged) or 'interrupted'.")
      .def_prop_ro("failed", &R::failed, "Whether no step was taken: status is 'failed' or 'interrupted'.")
      .def_ro("message", &R::message,
              "Why the step was retried, failed or has caveats, and what to do; else empty.")
      .def_prop_ro("solve_status", path<&R::solve, &S::status>,
                   "How the last attempt ended: 'converged', 'round_off', 'max_iterations', 'blocked', ...")
      .def_prop_ro("at_rounding", path<&R::solve, &S::is_at_rounding>,
                   "Whether it converged because all that is left is rounding: tolerances ask for less.")
      .def_prop_ro("caveats", path<&R::caveats>,
                   "What is not quite as asked of a step that was accepted: 'round_off' (the tolerances are "
                   "not met, forces are rounding), 'old_friction' (friction or joints are a refresh "
                   "behind).")
      .def_prop_ro(
          "diagnosis", [](const R& r) { return r.diagnosis ? nb::cast(r.diagnosis) : nb::none(); },
          nb::sig("def diagnosis(self) -> Diagnosis | None"), "Why the step failed; None when it did not.")
      .def_ro("step", &R::step, "Number of the step, from 1.")
      .def_ro("time", &R::time, "Time at the end of the step [s].")
      .def_ro("time_step", &R::time_step, "Length of the step that was taken [s].")
      .def_prop_ro(
          "integrator", path<&R::integrator>,
          "What the step was taken with: 'implicit_euler', 'bdf2' or 'quasistatic'. Steps of bdf2 are "
          "'implicit_euler' at the start and where steps more than double.")
      .def_ro("rejected_steps", &R::rejected_steps,
              "Attempts thrown away before this one, each with a longer step.")
      .def_prop_ro("placed", path<&R::placed>,
                   "Numbers of the bodies that were placed between the step before and this one.")
      .def_ro("contact_count", &R::contact_count, "Pairs of surfaces within their contact distance.")
      .def_ro("min_distance", &R::min_distance,
              "Smallest distance of an active contact [m], inf without any.")
      .def_ro("friction_residual", &R::friction_residual,
              "Largest difference of a friction limit in this step from mu times the normal force at its end "
              "[N].")
      .def_prop_ro("newton_iterations", path<&R::solve, &S::iterations>, "Newton iterations of the step.")
      .def_prop_ro("linear_iterations", path<&R::solve, &S::linear_iterations>,
                   "Iterations of conjugate gradients in all Newton iterations.")
      .def_prop_ro("factorizations", path<&R::solve, &S::factorizations>,
                   "Factorisations of the matrix in all Newton iterations.")
      .def_prop_ro("line_search_backtracks", path<&R::solve, &S::backtracks>,
                   "How often the line search halved a Newton step.")
      .def_prop_ro("residual", path<&R::solve, &S::residual>, "Largest unbalanced force [N].")
      .def_prop_ro("acceleration", path<&R::solve, &S::acceleration>, "Largest M^-1 residual [m/s^2].")
      .def_prop_ro(
          "last_motion", path<&R::solve, &S::last_motion>,
          "Largest motion of a vertex in the last Newton step, taken in full [m]; over the time step "
          "it is what newton.step_tolerance bounds.")
      .def_ro("contact_energy_at_start", &R::contact_energy_at_start,
              "Of the barriers at the start of the step, with the stiffness of this step [J].")
      .def_ro("bristle_energy_at_start", &R::bristle_energy_at_start,
              "Stored by sticking friction at the start of the step, with the limits of this step [J]: what "
              "friction can give back in it.")
      .def_prop_ro(
          "energy", energy_dict,
          "Stored at the end of the step: kinetic, elastic, gravity, contact [J]. Turned over by the "
          "step: damping, friction (dissipated), external (work of scripted and pinned parts), "
          "actuation (work of actuators), belts (work of the drives of moving surfaces), placed (given by "
          "placing bodies before the step), "
          "numerical (what closes the balance) [J].")
      .def_prop_ro("momentum", path<&R::momentum, &Momentum::linear>,
                   "Momentum of all free masses (3,) [N s].")
      .def_prop_ro("angular_momentum", path<&R::momentum, &Momentum::angular>,
                   "Angular momentum of all free masses about the origin (3,) [N m s].")
      .def_prop_ro("phases", phases_dict, "Wall-clock time of the step by phase [s].")
      .def("brief", &R::brief, "One line.")
      .def("to_dict", report_dict, "All of it as dictionaries, lists, numbers and texts.")
      .def("__repr__", [](const R& r) { return "<stark.StepReport " + r.brief() + ">"; });
}
