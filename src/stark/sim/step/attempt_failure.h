// What is said of an attempt at a step that failed, by how its solve ended. Phase: after the attempt.
#pragma once

#include <string>

#include <stark/solve/report.h>

namespace stark {

/// Why an attempt failed, and what could be done; both empty where others know better.
struct AttemptFailure {
  std::string cause, remedy;
  std::string text() const { return remedy.empty() ? cause : cause + "; " + remedy; }
};

AttemptFailure failure_of(SolveStatus status);

/// Newton's method came to no end, as where an impact has pressed a contact to next to nothing.
constexpr bool is_stuck(SolveStatus status) {
  return status == SolveStatus::MaxIterations || status == SolveStatus::LineSearchFailed ||
         status == SolveStatus::Blocked;
}

}  // namespace stark
