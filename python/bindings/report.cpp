// Bindings of what a step reports: numbers of the step, and the diagnosis of one that failed. What they have
// to tell is listed in sim/report_readings.h.
#include <nanobind/nanobind.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <concepts>
#include <optional>

#include <stark/sim/report_readings.h>

#include "casters.h"
#include "domains.h"

namespace stark::bindings {

/// Parts of reports that are dictionaries in Python.
template <typename T>
concept Record = HasReadings<T> && !std::same_as<T, Diagnosis> && !std::same_as<T, StepReport>;

/// All readings as a dictionary of dictionaries, lists, numbers and texts.
template <typename T>
nb::object plain(const T& value) {
  if constexpr (HasReadings<T>) {
    nb::dict dict;
    for_each_reading<T>([&](const auto& row) { dict[row.name] = plain(row.read(value)); });
    return dict;
  } else if constexpr (std::same_as<T, Vec3>) {
    return nb::make_tuple(value.x, value.y, value.z);
  } else {
    return nb::cast(value);
  }
}

}  // namespace stark::bindings

namespace nanobind::detail {

/// To Python only.
template <stark::bindings::Record T>
struct type_caster<T> {
  NB_TYPE_CASTER(T, const_name("dict"))
  bool from_python(handle, uint32_t, cleanup_list*) noexcept { return false; }
  static handle from_cpp(const T& value, rv_policy, cleanup_list*) noexcept {
    return stark::bindings::plain(value).release();
  }
};
template <stark::bindings::Record T>
struct type_caster<std::vector<T>> {
  NB_TYPE_CASTER(std::vector<T>, const_name("list"))
  bool from_python(handle, uint32_t, cleanup_list*) noexcept { return false; }
  static handle from_cpp(const std::vector<T>& values, rv_policy, cleanup_list*) noexcept {
    return stark::bindings::list_of(values, stark::bindings::plain<T>).release();
  }
};
template <stark::bindings::Record T>
struct type_caster<std::optional<T>> {
  NB_TYPE_CASTER(std::optional<T>, const_name("object"))
  bool from_python(handle, uint32_t, cleanup_list*) noexcept { return false; }
  static handle from_cpp(const std::optional<T>& value, rv_policy, cleanup_list*) noexcept {
    return (value ? stark::bindings::plain(*value) : none()).release();
  }
};

}  // namespace nanobind::detail

namespace {

namespace nb = nanobind;
using namespace stark;
using namespace stark::bindings;

nb::dict phases_dict(const StepReport& r) {
  nb::dict phases;
  for (size_t k = 0; k < r.phases.size(); ++k) phases[std::string(kPhaseNames[k]).c_str()] = r.phases[k];
  return phases;
}

nb::dict report_dict(const StepReport& r) {
  const auto components = [](const Vec3& v) { return dict_of("x", v.x, "y", v.y, "z", v.z); };
  nb::dict d = nb::borrow<nb::dict>(plain(r));
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
  diagnosis.def(
               "to_dict", [](const D& d) { return nb::borrow<nb::dict>(plain(d)); }, kAllOfIt)
      .def("__repr__", [](const D& d) {
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
