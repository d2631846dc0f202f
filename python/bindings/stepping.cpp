#include "stepping.h"

#include <map>
#include <string>

#include <stark/base/error.h>
#include <stark/sim/report_readings.h>

namespace stark::bindings {

namespace {

/// Simulations inside a step, and the threads that step them. The GIL guards it.
std::map<const Simulation*, unsigned long>& under_way() {
  static std::map<const Simulation*, unsigned long> steps;
  return steps;
}

/// The simulation is inside a step of the thread `ident`.
[[noreturn]] void refuse(unsigned long ident) {
  if (ident == PyThread_get_thread_ident())
    throw Error(
        "the simulation is inside step(), which has called this function (a progress callback or a signal "
        "handler): leave it alone until the step is over; what is known of the step is in the callback's "
        "argument");
  for (const nb::handle thread : nb::module_::import_("threading").attr("enumerate")())
    if (nb::cast<unsigned long>(thread.attr("ident")) == ident)
      throw Error(
          "the simulation is inside step() of the thread '" + text(thread.attr("name")) +
          "': wait until it returns, or share a lock (with threading.Lock()); simulations of their own "
          "can be stepped by several threads at once");
  throw Error(
      "the simulation is inside step() of a thread that this process does not have, as it was forked "
      "meanwhile: make another simulation here, or fork between steps");
}

/// Between two looks at signals [s]: to wait for the GIL takes time.
constexpr double kSignalPeriod = 0.02;

/// What a callback is told.
struct LiveProgress : StepProgress {
  double time;     ///< at the start of the step [s]
  double seconds;  ///< of wall-clock time since the step began
};

}  // namespace

void require_at_rest(const Simulation& simulation) {
  if (under_way().empty()) return;
  const auto step = under_way().find(&simulation);
  if (step != under_way().end()) refuse(step->second);
}

Watch::Watch(Simulation& sim, const ProgressCallback& callback) : sim_(sim), callback_(callback) {
  under_way().emplace(&sim, PyThread_get_thread_ident());
  sim_.set_interrupt([this] { return is_interrupted(); });
}

Watch::~Watch() {
  sim_.set_interrupt({});
  under_way().erase(&sim_);
}

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

void bind_step_progress(nb::module_& m) {
  using L = LiveProgress;
  nb::class_<L> progress(m, "StepProgress", "How far a time step has come that is under way.");
  def_readings<StepProgress>(progress);
  progress.def_ro("time", &L::time, "Simulated time at its start [s].")
      .def_ro("seconds", &L::seconds, "Wall-clock time since the step began [s].");
}

}  // namespace stark::bindings
