// What goes on while a step runs without the GIL: signals are checked between Newton iterations, so that
// Ctrl-C acts within one of them, and a function of Python is told how far the step has come.
#pragma once

#include <nanobind/nanobind.h>

#include <chrono>
#include <exception>

#include <stark/sim/simulation.h>

#include "stepping.h"
#include "without_gil.h"

namespace stark::bindings {

namespace nb = nanobind;

struct ProgressCallback {
  nb::object function = nb::none();
  double period = 0.0;  ///< from one call to the next, and to the first [s]
};

/// While it lives, steps of the simulation are watched. What a signal handler or the callback raises ends the
/// step, and is to be raised again when it is over.
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
  const Stepping stepping(sim);
  const Watch watch(sim, callback);
  const auto result = [&] {
    const WithoutGil without;
    return steps();
  }();
  watch.raise_again();
  leave_at_end();
  return result;
}

}  // namespace stark::bindings
