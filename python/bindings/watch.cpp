#include "watch.h"

#include "casters.h"
#include "domains.h"

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

}  // namespace stark::bindings

void bind_step_progress(nanobind::module_& m) {
  using namespace stark;
  using namespace stark::bindings;
  using L = LiveProgress;
  using P = StepProgress;
  using S = SolveReport;
  nb::class_<L>(m, "StepProgress", "How far a time step has come that is under way.")
      .def_prop_ro("step", path<&L::step, &P::step>, "Number of the step, from 1.")
      .def_ro("time", &L::time, "Simulated time at its start [s].")
      .def_ro("seconds", &L::seconds, "Wall-clock time since the step began [s].")
      .def_prop_ro("attempt", path<&L::step, &P::attempt>,
                   "From 1; what fails is tried again with a shorter time step.")
      .def_prop_ro("iterations", path<&L::step, &P::iterations>,
                   "Newton iterations, those of earlier attempts included.")
      .def_prop_ro("refreshes", path<&L::step, &P::solve, &S::lag_updates>,
                   "Refreshes of friction and joints in this attempt.")
      .def_prop_ro("residual", path<&L::step, &P::solve, &S::residual>, "Largest unbalanced force [N].")
      .def_prop_ro("acceleration", path<&L::step, &P::solve, &S::acceleration>,
                   "Largest M^-1 residual [m/s^2].")
      .def_prop_ro("last_motion", path<&L::step, &P::solve, &S::last_motion>,
                   "Largest motion of a vertex in the last Newton step, taken in full [m].")
      .def_prop_ro("step_length", path<&L::step, &P::solve, &S::last_step_length>,
                   "Share of it that was taken.")
      .def_prop_ro("bound", path<&L::step, &P::solve, &S::last_bound>,
                   "Largest share of it that collision detection and the limit of rotations allowed.")
      .def_prop_ro("slope", path<&L::step, &P::solve, &S::last_slope>,
                   "Of the energy along it [J]: a quadratic energy falls by half of that.")
      .def_prop_ro("difference", path<&L::step, &P::solve, &S::last_difference>,
                   "Change of the energy by what was taken of it [J].")
      .def_prop_ro("backtracks", path<&L::step, &P::solve, &S::backtracks>,
                   "Times that steps were halved in this attempt.")
      .def_prop_ro("projected_iterations", path<&L::step, &P::solve, &S::projected_iterations>,
                   "Iterations of this attempt whose Hessians were projected.")
      .def_prop_ro("factorizations", path<&L::step, &P::solve, &S::factorizations>,
                   "Of matrices, in this attempt.")
      .def_prop_ro("linear_iterations", path<&L::step, &P::solve, &S::linear_iterations>,
                   "Of conjugate gradients, in this attempt.")
      .def_prop_ro("contacts", path<&L::step, &P::contact_count>, "Pairs within their contact distance.");
}
