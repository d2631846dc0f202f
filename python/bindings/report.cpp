// Bindings of what a step reports: numbers of the step, and the diagnosis of one that failed. What they have
// to tell is listed in sim/report_readings.h.
#include "casters.h"

namespace stark::bindings {

namespace {

nb::dict phases_dict(const StepReport& r) {
  nb::dict phases;
  for (size_t k = 0; k < r.phases.size(); ++k) phases[std::string(kPhaseNames[k]).c_str()] = r.phases[k];
  return phases;
}

nb::dict report_dict(const StepReport& r) {
  const auto components = [](const Vec3& v) { return dict_of("x", v.x, "y", v.y, "z", v.z); };
  nb::dict d = dict_of_readings(r);
  if (r.placed.empty()) d.attr("pop")("placed");
  d["projected_iterations"] = r.solve.projected_iterations;
  d["momentum"] = components(r.momentum.linear);
  d["angular_momentum"] = components(r.momentum.angular);
  d["phases"] = phases_dict(r);
  if (r.diagnosis) d["diagnosis"] = plain(r.diagnosis);
  return d;
}

constexpr const char* kAllOfIt = "All of it as dictionaries, lists, numbers and texts.";

}  // namespace

void bind_report(nb::module_& m) {
  using D = Diagnosis;
  using R = StepReport;
  nb::class_<D> diagnosis(m, "Diagnosis",
                          "Why a step failed: cause, bodies, vertices and numbers, and what to change.");
  def_readings<D>(diagnosis);
  diagnosis.def("to_dict", &dict_of_readings<D>, kAllOfIt).def("__repr__", [](const D& d) {
    return "<stark.Diagnosis " + to_string(d.cause) + ": " + d.finding + "; " + d.remedy + ">";
  });
  nb::class_<R> report(m, "StepReport", "What a time step did, whether it succeeded or not.");
  def_readings<R>(report);
  report.def_prop_ro("failed", &R::failed, "Whether no step was taken: status is 'failed' or 'interrupted'.")
      .def_prop_ro(
          "diagnosis", [](const R& r) { return r.diagnosis ? nb::cast(r.diagnosis) : nb::none(); },
          nb::sig("def diagnosis(self) -> Diagnosis | None"), "Why the step failed; None when it did not.")
      .def_prop_ro("phases", phases_dict, "Wall-clock time of the step by phase [s].")
      .def("brief", &R::brief, "One line.")
      .def("to_dict", report_dict, kAllOfIt)
      .def("__repr__", [](const R& r) { return "<stark.StepReport " + r.brief() + ">"; });
}

}  // namespace stark::bindings
