// Bindings of what a step reports: numbers of the step, and the diagnosis of one that failed. What they have
// to tell is listed in sim/step/report_readings.h.
#include "functions.h"
#include "stepping.h"

namespace stark::bindings {

namespace {

nb::dict phases_dict(const StepReport& r) {
  nb::dict phases;
  for (size_t k = 0; k < r.phases.size(); ++k) phases[std::string(kPhaseNames[k]).c_str()] = r.phases[k];
  return phases;
}

nb::dict report_dict(const StepReport& r) {
  const auto components = [](const Vec3& v) {
    return std::map<std::string, double>{{"x", v.x}, {"y", v.y}, {"z", v.z}};
  };
  nb::dict d = dict_of_readings(r);
  if (r.placed.empty()) d.attr("pop")("placed");
  d["projected_iterations"] = r.solve.projected_iterations;
  d["momentum"] = components(r.momentum.linear);
  d["angular_momentum"] = components(r.momentum.angular);
  d["phases"] = phases_dict(r);
  if (r.diagnosis) d["diagnosis"] = plain(r.diagnosis);
  return d;
}

std::optional<Diagnosis> diagnosis_of(const StepReport& r) {
  return r.diagnosis ? std::optional(r.diagnosis) : std::nullopt;
}

constexpr const char* kAllOfIt = "All of it as dictionaries, lists, numbers and texts.";

}  // namespace

void bind_report(nb::module_& m) {
  using D = Diagnosis;
  using R = StepReport;
  using L = LiveProgress;
  nb::class_<D> diagnosis(m, "Diagnosis",
                          "Why a step failed: cause, bodies, vertices and numbers, and what to change.");
  def_readings<D>(diagnosis);
  def(diagnosis, "to_dict", dict_of_readings<D>, kAllOfIt);
  def(diagnosis, "__repr__", [](const D& d) {
    return "<stark.Diagnosis " + to_string(d.cause) + ": " + d.finding + "; " + d.remedy + ">";
  });
  nb::class_<R> report(m, "StepReport", "What a time step did, whether it succeeded or not.");
  def_readings<R>(report);
  property(report, "failed", &R::failed, "Whether no step was taken: status is 'failed' or 'interrupted'.");
  property(report, "diagnosis", diagnosis_of, "Why the step failed; None when it did not.");
  property(report, "phases", phases_dict, "Wall-clock time of the step by phase [s].");
  def(report, "brief", &R::brief, "One line.");
  def(report, "to_dict", report_dict, kAllOfIt);
  def(report, "__repr__", [](const R& r) { return "<stark.StepReport " + r.brief() + ">"; });
  nb::class_<L> progress(m, "StepProgress", "How far a time step has come that is under way.");
  def_readings<StepProgress>(progress);
  property(progress, "time", &L::time, "Simulated time at its start [s].");
  property(progress, "seconds", &L::seconds, "Wall-clock time since the step began [s].");
}

}  // namespace stark::bindings
