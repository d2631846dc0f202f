// What a minimisation did and how it ended.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

#include <stark/base/settings.h>

namespace stark {

enum class SolveStatus : uint8_t {
  Converged,
  RoundOff,  ///< stopped where energies cannot be told apart any more; counts as success
  MaxIterations,
  NotFinite,  ///< the objective or its derivatives are not finite at the iterate
  LineSearchFailed,
  LinearSolveFailed,
  Blocked,  ///< prescribed motion cannot go on: an obstacle is in the way
  Interrupted,
  Detour,              ///< the straight way from start to end of the step leads through something
  ConstraintViolated,  ///< joints that contradict each other, or are beyond the reach of their bodies
  TimeBudget,          ///< max_seconds is used up
  RunAway,             ///< the iterate is beyond any scale of the objective: there is no minimum
};

template <>
struct EnumNames<SolveStatus> {
  static constexpr std::array<std::string_view, 12> kNames{
      "converged",           "round_off", "max_iterations", "not_finite", "line_search_failed",
      "linear_solve_failed", "blocked",   "interrupted",    "detour",     "constraint_violated",
      "time_budget",         "run_away"};
};

constexpr bool is_success(SolveStatus status) {
  return status == SolveStatus::Converged || status == SolveStatus::RoundOff;
}

struct SolveReport {
  SolveStatus status = SolveStatus::Converged;
  int iterations = 0;  ///< linear systems solved for a direction and stepped along
  int64_t linear_iterations = 0;
  int factorizations = 0;
  int backtracks = 0;
  int projected_iterations = 0;  ///< iterations that needed projected Hessians
  int lag_updates = 0;
  double residual = 0.0;      ///< last evaluated [N]
  double acceleration = 0.0;  ///< last evaluated [m/s^2]
  double lag_residual = 0.0;  ///< change of the lagged forces at their last update [N]
  double last_motion = 0.0;   ///< of the last full Newton step [m]
  double last_step_length = 1.0;
  double last_bound = 1.0;       ///< largest step length that collision detection and rotations allowed
  double last_slope = 0.0;       ///< of the energy along the last full Newton step, before it [J]
  double last_difference = 0.0;  ///< change of the energy by the last step that was taken [J]
  bool is_at_rounding = false;   ///< converged: tolerances ask for less than what doubles resolve
  bool is_settled = false;  ///< the last refresh of lagged quantities did not converge; the one before counts
};

}  // namespace stark
