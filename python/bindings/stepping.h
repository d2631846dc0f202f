// One thread at a time. A step runs without the GIL, so that other threads of Python go on; whatever they ask
// of the simulation meanwhile is refused, as it would read and write what the step works on. Arrays that were
// handed out are copies and do not change. Every file that binds functions of simulations includes this one:
// the caster at its end is the door that all of their calls go through. Between Newton iterations signals are
// checked, so that Ctrl-C acts within one, and a function of Python is told how far the step has come.
#pragma once

#include <map>

#include <stark/sim/simulation.h>

#include "casters.h"
#include "without_gil.h"

namespace stark::bindings {

/// Simulations inside a step, and the threads that step them. The GIL guards it.
inline std::map<const Simulation*, unsigned long>& under_way() {
  static std::map<const Simulation*, unsigned long> steps;
  return steps;
}

/// The simulation is inside a step of the thread `ident`.
[[noreturn]] inline void refuse(unsigned long ident) {
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

/// What a callback is told.
struct LiveProgress : StepProgress {
  double time;     ///< at the start of the step [s]
  double seconds;  ///< of wall-clock time since the step began
};

/// While it lives, steps of the simulation are under way, and watched. What a signal handler or the callback
/// raises ends the step, and is to be raised again when it is over. Made and destroyed with the GIL.
class Watch {
 public:
  Watch(Simulation& sim, nb::object progress, double period)
      : sim_(sim), progress_(std::move(progress)), period_(period) {
    under_way().emplace(&sim, PyThread_get_thread_ident());
    sim_.set_interrupt([this] { return is_interrupted(); });
  }
  ~Watch() {
    sim_.set_interrupt({});
    under_way().erase(&sim_);
  }
  Watch(const Watch&) = delete;
  Watch& operator=(const Watch&) = delete;

  void raise_again() const { signals_.raise_again(); }

 private:
  bool is_interrupted() {
    if (signals_.have_come()) return true;
    const double now = signals_.seconds();
    if (progress_.is_none() || now - reported_ < period_) return false;
    signals_.look([&] { progress_(LiveProgress{{sim_.progress()}, sim_.time(), now}); });
    reported_ = now;
    return signals_.have_come();
  }

  Simulation& sim_;
  const nb::object progress_;  ///< the callback, or None
  const double period_;        ///< from one call of it to the next, and to the first [s]
  double reported_ = 0.0;      ///< when it was called last [s]
  Signals signals_;
};

/// Calls steps() without the GIL; nothing else may use the simulation meanwhile.
template <typename Steps>
auto watched(Simulation& sim, const Steps& steps, nb::object progress = nb::none(), double period = 0.0) {
  const Watch watch(sim, std::move(progress), period);
  const auto result = without_gil(steps);
  watch.raise_again();
  return result;
}

}  // namespace stark::bindings

namespace nanobind::detail {

/// Refuses, by Error, a simulation of which a step is under way. Called with the GIL.
template <>
struct type_caster<stark::Simulation> : type_caster_base<stark::Simulation> {
  using Base = type_caster_base<stark::Simulation>;
  operator stark::Simulation*() { return &checked(); }
  operator stark::Simulation&() { return checked(); }
  operator stark::Simulation&&() { return std::move(checked()); }

 private:
  stark::Simulation& checked() {
    auto& simulation = Base::operator stark::Simulation&();
    const auto step = stark::bindings::under_way().find(&simulation);
    if (step != stark::bindings::under_way().end()) stark::bindings::refuse(step->second);
    return simulation;
  }
};

}  // namespace nanobind::detail
