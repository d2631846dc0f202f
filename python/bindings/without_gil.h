// Work of the core that other threads of Python need not wait for. At the end of the process the interpreter
// waits for it in turn: it would kill daemon threads where they ask for the GIL again, in the middle of C++.
#pragma once

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

/// Lets the end of the interpreter wait for work without the GIL.
void wait_at_exit();

}  // namespace stark::bindings
