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

/// Calls work(interrupted) without the GIL. It should ask interrupted() now and then, on this thread, and end
/// once that is true: a signal has come, whose handler's exception is raised then, or the process ends.
template <typename Function>
auto interruptible(const Function& work) {
  using Clock = std::chrono::steady_clock;
  constexpr std::chrono::milliseconds kPeriod(20);  // to wait for the GIL takes time
  Clock::time_point looked = Clock::now();
  std::exception_ptr raised;
  const auto interrupted = [&] {
    if (raised || must_end()) return true;
    if (Clock::now() - looked < kPeriod) return false;
    const nb::gil_scoped_acquire gil;
    try {
      if (PyErr_CheckSignals() != 0) throw nb::python_error();
    } catch (...) {
      raised = std::current_exception();
    }
    looked = Clock::now();
    return raised != nullptr;
  };
  auto result = without_gil([&] { return work(interrupted); });
  if (raised) std::rethrow_exception(raised);
  leave_at_end();
  return result;
}

/// Lets the end of the interpreter wait for work without the GIL.
void wait_at_exit();

}  // namespace stark::bindings
