#include "without_gil.h"

#include <unistd.h>

#include <atomic>
#include <chrono>
#include <thread>

namespace stark::bindings {

namespace {

/// Longer than what goes on between two looks at must_end(): an iteration of Newton's method, a picture [s].
constexpr std::chrono::seconds kLongestWait{20};

std::atomic<unsigned long> exiting_thread{0};  ///< waits for the others; 0 before
// The GIL guards these.
int running = 0;
pid_t process = 0;  ///< whose threads `running` counts: forks copy none of them

void enter() {
  if (process != getpid()) running = 0;
  process = getpid();
  ++running;
}

void wait_for_the_others() {
  exiting_thread = PyThread_get_thread_ident();
  const auto deadline = std::chrono::steady_clock::now() + kLongestWait;
  while (running > 0 && process == getpid() && std::chrono::steady_clock::now() < deadline) {
    const nb::gil_scoped_release release;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
}

}  // namespace

WithoutGil::WithoutGil() {
  leave_at_end();
  enter();
  state_ = PyEval_SaveThread();
}

WithoutGil::~WithoutGil() {
  PyEval_RestoreThread(state_);
  --running;
}

bool must_end() { return exiting_thread != 0 && exiting_thread != PyThread_get_thread_ident(); }

void leave_at_end() {
  if (!must_end()) return;
  PyErr_SetNone(PyExc_SystemExit);
  throw nb::python_error();
}

void wait_at_exit() {
  nb::module_::import_("atexit").attr("register")(nb::cpp_function(&wait_for_the_others));
}

}  // namespace stark::bindings
