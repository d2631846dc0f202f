// Work of the core that other threads of Python need not wait for. At the end of the process the interpreter
// waits for it in turn: it would kill daemon threads where they ask for the GIL again, in the middle of C++.
#pragma once

#include <chrono>
#include <exception>

#include "domains.h"

namespace stark::bindings {

/// Releases the GIL while it lives. In daemon threads that go on after the end of the main program it raises
/// SystemExit instead, which ends them without a word.
class WithoutGil {
 public:
  WithoutGil();
  ~WithoutGil();
  WithoutGil(const WithoutGil&) = delete;
  WithoutGil& operator=(const WithoutGil&) = delete;

 private:
  PyThreadState* state_;
};

/// Whether the interpreter waits for this thread: what it does without the GIL should come to an end.
bool must_end();

/// Throws SystemExit where must_end(). Call it with the GIL.
void leave_at_end();

/// Calls the function without the GIL.
template <typename Function>
auto without_gil(const Function& function) {
  const WithoutGil without;
  return function();
}

/// What handlers of signals raise while work goes on without the GIL: to be raised again when it is over.
class Signals {
 public:
  /// Whether the work should end, because one has raised or the process ends.
  bool have_come() {
    if (!raised_ && !must_end() && seconds() - looked_ >= kPeriod) look([] {});
    return raised_ || must_end();
  }
  /// Looks now, and calls a function with the GIL, whose exception counts as well.
  template <typename Function>
  void look(const Function& also) {
    const nb::gil_scoped_acquire gil;
    try {
      if (PyErr_CheckSignals() != 0) throw nb::python_error();
      also();
    } catch (...) {
      raised_ = std::current_exception();
    }
    looked_ = seconds();
  }
  void raise_again() const {
    if (raised_) std::rethrow_exception(raised_);
    leave_at_end();
  }
  double seconds() const {  ///< since the beginning [s]
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
  }

 private:
  static constexpr double kPeriod = 0.02;  ///< [s], as to wait for the GIL takes time
  const std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
  double looked_ = 0.0;
  std::exception_ptr raised_;
};

/// Lets the end of the interpreter wait for work without the GIL.
void wait_at_exit();

}  // namespace stark::bindings
