#include "watch.h"

namespace stark::bindings {

namespace {

/// Between two looks at signals [s]: to wait for the GIL takes time.
constexpr double kSignalPeriod = 0.02;

/// What a callback is told.
struct LiveProgress {
  StepProgress step;
  double time;     ///< at the start of the step [s]
  double seconds;  ///< of wall-clock time since the step began
};

}  // namespace

Watch::Watch(Simulation& sim, const ProgressCallback& callback) : sim_(sim), callback_(callback) {
  sim_.set_interrupt([this] { return is_interrupted(); });
}

Watch::~Watch() { sim_.set_interrupt({}); }

double Watch::seconds() const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
}

bool Watch::is_interrupted() {
  if (must_end()) return true;
  const double now = seconds();
  const bool reports = !callback_.function.is_none() && now - reported_ >= callback_.period;
  if (!raised_ && (reports || now - looked_ >= kSignalPeriod)) look(reports);
  return raised_ != nullptr;
}

void Watch::look(bool reports) {
  const nb::gil_scoped_acquire gil;
  try {
    if (PyErr_CheckSignals() != 0) throw nb::python_error();
    if (reports) callback_.function(LiveProgress{sim_.progress(), sim_.time(), seconds()});
  } catch (...) {
    raised_ = std::current_exception();
  }
  looked_ = seconds();
  if (reports) reported_ = looked_;
}

void bind_step_progress(nb::module_& m) {
  using P = LiveProgress;
  nb::class_<P>(m, "StepProgress", "How far a time step has come that is under way.")
      .def_prop_ro(
          "step", [](const P& p) { return p.step.step; }, "Number of the step, from 1.")
      .def_ro("time", &P::time, "Simulated time at its start [s].")
      .def_ro("seconds", &P::seconds, "Wall-clock time since the step began [s].")
      .def_prop_ro(
          "attempt", [](const P& p) { return p.step.attempt; },
          "From 1; what fails is tried again with a shorter time step.")
      .def_prop_ro(
          "iterations", [](const P& p) { return p.step.iterations; },
          "Newton iterations, those of earlier attempts included.")
      .def_prop_ro(
          "refreshes", [](const P& p) { return p.step.solve.lag_updates; },
          "Refreshes of friction and joints in this attempt.")
      .def_prop_ro(
          "residual", [](const P& p) { return p.step.solve.residual; }, "Largest unbalanced force [N].")
      .def_prop_ro(
          "acceleration", [](const P& p) { return p.step.solve.acceleration; },
          "Largest M^-1 residual [m/s^2].")
      .def_prop_ro(
          "last_motion", [](const P& p) { return p.step.solve.last_motion; },
          "Largest motion of a vertex in the last Newton step, taken in full [m].")
      .def_prop_ro(
          "step_length", [](const P& p) { return p.step.solve.last_step_length; },
          "Share of it that was taken.")
      .def_prop_ro(
          "bound", [](const P& p) { return p.step.solve.last_bound; },
          "Largest share of it that collision detection and the limit of rotations allowed.")
      .def_prop_ro(
          "slope", [](const P& p) { return p.step.solve.last_slope; },
          "Of the energy along it [J]: a quadratic energy falls by half of that.")
      .def_prop_ro(
          "difference", [](const P& p) { return p.step.solve.last_difference; },
          "Change of the energy by what was taken of it [J].")
      .def_prop_ro(
          "backtracks", [](const P& p) { return p.step.solve.backtracks; },
          "Times that steps were halved in this attempt.")
      .def_prop_ro(
          "projected_iterations", [](const P& p) { return p.step.solve.projected_iterations; },
          "Iterations of this attempt whose Hessians were projected.")
      .def_prop_ro(
          "factorizations", [](const P& p) { return p.step.solve.factorizations; },
          "Of matrices, in this attempt.")
      .def_prop_ro(
          "linear_iterations", [](const P& p) { return p.step.solve.linear_iterations; },
          "Of conjugate gradients, in this attempt.")
      .def_prop_ro(
          "contacts", [](const P& p) { return p.step.contact_count; },
          "Pairs within their contact distance.");
}

}  // namespace stark::bindings
