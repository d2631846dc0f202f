// Accumulated seconds by phase of the time step. Compiled in always; costs two clock reads a phase.
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <string_view>

namespace stark {

enum class Phase : uint8_t {
  Predict,
  BroadPhase,
  ActiveSet,
  Assemble,
  LinearSolve,
  StepBound,
  LineSearch,
  Friction,
  Stiffness,
  Commit,
  kCount
};
inline constexpr std::array<std::string_view, static_cast<size_t>(Phase::kCount)> kPhaseNames{
    "predict",    "broad_phase", "active_set", "assemble",  "linear_solve",
    "step_bound", "line_search", "friction",   "stiffness", "commit"};

class PhaseTimer {
 public:
  /// Adds the time until the end of the scope to a phase; a phase entered inside another one is not counted
  /// twice.
  class Scope {
   public:
    Scope(PhaseTimer& timer, Phase phase) : timer_(timer), outer_(timer.current_) { timer_.enter(phase); }
    ~Scope() { timer_.enter(outer_); }
    Scope(const Scope&) = delete;
    Scope& operator=(const Scope&) = delete;

   private:
    PhaseTimer& timer_;
    Phase outer_;
  };

  double seconds(Phase phase) const { return seconds_[static_cast<size_t>(phase)]; }
  void reset() { seconds_.fill(0.0); }

 private:
  using Clock = std::chrono::steady_clock;
  void enter(Phase phase) {
    const auto now = Clock::now();
    if (current_ != Phase::kCount)
      seconds_[static_cast<size_t>(current_)] += std::chrono::duration<double>(now - since_).count();
    current_ = phase;
    since_ = now;
  }

  std::array<double, static_cast<size_t>(Phase::kCount)> seconds_{};
  Phase current_ = Phase::kCount;
  Clock::time_point since_{};
};

}  // namespace stark
