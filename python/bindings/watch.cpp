#include "watch.h"

#include <stark/sim/report_readings.h>

#include "casters.h"
#include "domains.h"

namespace stark::bindings {

namespace {

/// Between two looks at signals [s]: to wait for the GIL takes time.
constexpr double kSignalPeriod = 0.02;

/// What a callback is told.
struct LiveProgress : StepProgress {
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
    if (reports) callback_.function(LiveProgress{{sim_.progress()}, sim_.time(), seconds()});
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
  nb::class_<L> progress(m, "StepProgress", "How far a time step has come that is under way.");
  def_readings<StepProgress>(progress);
  progress.def_ro("time", &L::time, "Simulated time at its start [s].")
      .def_ro("seconds", &L::seconds, "Wall-clock time since the step began [s].");
}
