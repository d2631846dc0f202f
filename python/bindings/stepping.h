// One thread at a time. A step runs without the GIL, so that other threads of Python go on; whatever they ask
// of the simulation meanwhile is refused, as it would read and write what the step works on. Arrays that were
// handed out are copies and do not change. Every file that binds functions of simulations includes this one:
// the caster at its end is the door that all of their calls go through. Signals are checked between Newton
// iterations, so that Ctrl-C acts within one of them, and a function of Python is told how far the step has
// come.
#pragma once

#include <chrono>
#include <exception>

#include <stark/sim/simulation.h>

#include "casters.h"
#include "without_gil.h"

namespace stark::bindings {

template <>
inline constexpr int kMembers<ClosestPoints> = 3;

/// Throws Error while a step of the simulation is under way; names its thread. Call it with the GIL.
void require_at_rest(const Simulation& simulation);

struct ProgressCallback {
  nb::object function = nb::none();
  double period = 0.0;  ///< from one call to the next, and to the first [s]
};

/// While it lives, steps of the simulation are under way, and watched. What a signal handler or the callback
/// raises ends the step, and is to be raised again when it is over. Made and destroyed with the GIL.
class Watch {
 public:
  Watch(Simulation& sim, const ProgressCallback& callback);
  ~Watch();
  Watch(const Watch&) = delete;
  Watch& operator=(const Watch&) = delete;

  void raise_again() const {
    if (raised_) std::rethrow_exception(raised_);
  }

 private:
  double seconds() const;  ///< since the beginning [s]
  bool is_interrupted();
  void look(bool reports);

  Simulation& sim_;
  const ProgressCallback& callback_;
  const std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
  double looked_ = 0.0, reported_ = 0.0;  ///< when it did so last [s]
  std::exception_ptr raised_;
};

/// Calls steps() without the GIL; nothing else may use the simulation meanwhile.
template <typename Steps>
auto watched(Simulation& sim, const ProgressCallback& callback, const Steps& steps) {
  const Watch watch(sim, callback);
  const auto result = without_gil(steps);
  watch.raise_again();
  leave_at_end();
  return result;
}

}  // namespace stark::bindings

namespace nanobind::detail {

template <>
struct type_caster<stark::Simulation> : type_caster_base<stark::Simulation> {
  using Base = type_caster_base<stark::Simulation>;
  operator stark::Simulation*() { return &checked(); }
  operator stark::Simulation&() { return checked(); }
  operator stark::Simulation&&() { return std::move(checked()); }

 private:
  stark::Simulation& checked() {
    auto& simulation = Base::operator stark::Simulation&();
    stark::bindings::require_at_rest(simulation);
    return simulation;
  }
};

}  // namespace nanobind::detail
