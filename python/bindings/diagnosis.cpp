#include "diagnosis.h"

#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

namespace stark::bindings {

namespace {

namespace nb = nanobind;

nb::dict place(const BodyVertices& p) {
  nb::dict d;
  d["body"] = p.body;
  d["vertices"] = p.vertices;
  return d;
}

nb::list forces(const StepEvidence& e) {
  nb::list rows;
  for (const UnbalancedForce& force : e.forces) {
    nb::dict row = place(force.at);
    row["position"] = nb::make_tuple(force.position.x, force.position.y, force.position.z);
    row["force"] = force.force;
    row["acceleration"] = force.acceleration;
    rows.append(row);
  }
  return rows;
}

nb::list gaps(const std::vector<NarrowGap>& all) {
  nb::list rows;
  for (const NarrowGap& gap : all) {
    nb::dict row;
    row["a"] = place(gap.a);
    row["b"] = place(gap.b);
    row["distance"] = gap.distance;
    row["contact_distance"] = gap.contact_distance;
    rows.append(row);
  }
  return rows;
}

nb::object blocking(const StepEvidence& e) {
  if (!e.blocking) return nb::none();
  nb::dict row;
  row["a"] = place(e.blocking->a);
  row["b"] = place(e.blocking->b);
  row["fraction"] = e.blocking->fraction;
  return row;
}

nb::list elements(const StepEvidence& e) {
  nb::list rows;
  for (const StrainedElement& element : e.elements) {
    nb::dict row = place(element.at);
    row["element"] = element.element;
    row["stretch"] = element.stretch;
    row["size"] = element.size;
    rows.append(row);
  }
  return rows;
}

nb::list attempts(const StepEvidence& e) {
  nb::list rows;
  for (const Attempt& attempt : e.attempts) {
    nb::dict row;
    row["time_step"] = attempt.time_step;
    row["status"] = to_string(attempt.status);
    row["iterations"] = attempt.iterations;
    rows.append(row);
  }
  return rows;
}

}  // namespace

nb::dict diagnosis_dict(const Diagnosis& diagnosis) {
  const StepEvidence& e = diagnosis.evidence;
  nb::dict d;
  d["cause"] = to_string(diagnosis.cause);
  d["finding"] = diagnosis.finding;
  d["remedy"] = diagnosis.remedy;
  d["bodies"] = diagnosis.bodies;
  d["forces"] = forces(e);
  d["gaps"] = gaps(e.gaps);
  d["start_gaps"] = gaps(e.start_gaps);
  d["blocking"] = blocking(e);
  d["elements"] = elements(e);
  d["pushing"] = e.pushing;
  d["force_rounding"] = e.force_rounding;
  d["acceleration_rounding"] = e.acceleration_rounding;
  d["stiffness_ratio"] = e.stiffness_ratio;
  d["unit_suspicions"] = e.unit_suspicions;
  d["attempts"] = attempts(e);
  return d;
}

void bind_diagnosis(nb::module_& m) {
  nb::class_<Diagnosis>(m, "Diagnosis",
                        "Why a step failed: cause, bodies, vertices and numbers, and what to change.")
      .def_prop_ro(
          "cause", [](const Diagnosis& d) { return to_string(d.cause); },
          "'blocked_motion', 'overconstrained_pins', 'contradicting_joints', 'inverted_element', "
          "'not_finite', 'singular_energy', 'tolerance_below_round_off', 'no_equilibrium', "
          "'thickness_overlap', "
          "'unit_mistake', 'crushing_load', 'overload', 'detour', 'singular_system', 'stiffness_contrast', "
          "'iteration_budget', "
          "'time_budget', 'unknown'.")
      .def_ro("finding", &Diagnosis::finding, "What was found, with names, numbers and units.")
      .def_ro("remedy", &Diagnosis::remedy, "What to change.")
      .def_ro("bodies", &Diagnosis::bodies, "Bodies involved: \"cloth 'towel'\".")
      .def_prop_ro(
          "forces", [](const Diagnosis& d) { return forces(d.evidence); },
          "Largest unbalanced forces: body, vertices, position [m], force [N], acceleration [m/s^2].")
      .def_prop_ro(
          "gaps", [](const Diagnosis& d) { return gaps(d.evidence.gaps); },
          "Narrowest gaps where the last attempt ended: a, b, distance [m], contact_distance [m].")
      .def_prop_ro(
          "start_gaps", [](const Diagnosis& d) { return gaps(d.evidence.start_gaps); },
          "Narrowest gaps at the start of the step.")
      .def_prop_ro(
          "blocking", [](const Diagnosis& d) { return blocking(d.evidence); },
          "The parts that limit the last Newton step: a, b, fraction of it; None when nothing does.")
      .def_prop_ro(
          "elements", [](const Diagnosis& d) { return elements(d.evidence); },
          "Elements farthest from rest: body, vertices, element, stretch of an edge, size (of volume, area "
          "or length, below 0 where inverted), both over those at rest.")
      .def_prop_ro(
          "pushing", [](const Diagnosis& d) { return d.evidence.pushing; },
          "Bodies with scripted or pinned parts that move in the step.")
      .def_prop_ro(
          "force_rounding", [](const Diagnosis& d) { return d.evidence.force_rounding; },
          "Unbalanced force that rounding of the positions makes [N].")
      .def_prop_ro(
          "acceleration_rounding", [](const Diagnosis& d) { return d.evidence.acceleration_rounding; },
          "The same over the mass of its node or body [m/s^2].")
      .def_prop_ro(
          "stiffness_ratio", [](const Diagnosis& d) { return d.evidence.stiffness_ratio; },
          "Of the stiffest to the softest node or body.")
      .def_prop_ro(
          "unit_suspicions", [](const Diagnosis& d) { return d.evidence.unit_suspicions; },
          "Numbers that look as if in other units.")
      .def_prop_ro(
          "attempts", [](const Diagnosis& d) { return attempts(d.evidence); },
          "Each attempt at the step: time_step [s], status, iterations.")
      .def("to_dict", diagnosis_dict, "All of it as dictionaries, lists, numbers and texts.")
      .def("__repr__", [](const Diagnosis& d) {
        return "<stark.Diagnosis " + to_string(d.cause) + ": " + d.finding + "; " + d.remedy + ">";
      });
}

}  // namespace stark::bindings
