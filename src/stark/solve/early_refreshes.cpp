// When lagged quantities are refreshed before the first solution with them (step phase 4i).
#include <cmath>

#include <stark/solve/newton.h>

namespace stark {

namespace {

constexpr int kEarlyRefreshLimit = 12;  ///< updates of friction before the first solution
constexpr int kFullStepsWithout = 16;   ///< half of the residual, from which friction of impacts counts
constexpr double kFull = 0.9;           ///< length of steps that nothing has held back
constexpr double kModelled =
    0.35;  ///< relative error of the decrease of a full step, below which the next is short
constexpr double kFrozen = 10.0;  ///< tolerances below which friction stays as it is until all is converged
constexpr double kAsLong = 0.5;   ///< of the motion before, above which a refresh has moved the minimum

}  // namespace

// Lagged quantities of the start of the step are far off, and what is minimised with them is far from what
// is minimised with those of the end; near a solution they stay as they are, so that there is one.
void NewtonSolver::refresh_early(Objective& objective) {
  if (report_.lag_updates > 0) return;
  const bool is_near = meets_tolerances(report_, kFrozen);
  if (makes_no_headway() && !is_near && progress_.late_refreshes < kEarlyRefreshLimit) {
    ++progress_.late_refreshes;
    objective.refresh_early(Lagged::All);
    return;
  }
  if (progress_.early_refreshes >= kEarlyRefreshLimit) return;
  if (is_near || leads_nowhere()) {
    progress_.early_refreshes = kEarlyRefreshLimit;
    return;
  }
  ++progress_.early_refreshes;
  objective.refresh_early(Lagged::FromStart);
}

// Without the friction of impacts, sheets that a press sweeps together slide off sideways, held by hardly
// more than their inertia: full steps that leave the forces as they are.
bool NewtonSolver::makes_no_headway() {
  const bool is_full = report_.last_step_length >= kFull;
  if (report_.residual < 0.5 * progress_.halved_residual) {
    progress_.halved_residual = report_.residual;
    progress_.full_steps = 0;
  } else if (is_full) {
    ++progress_.full_steps;
  }
  return is_full && progress_.full_steps >= kFullStepsWithout;
}

// A full step that gains what its model promises ends near the minimum. If the next step is as long all the
// same, the refresh has moved the minimum, and the next refresh would move it back: friction at the limit of
// sticking would go to and fro until kEarlyRefreshLimit.
bool NewtonSolver::leads_nowhere() {
  const double promised = 0.5 * report_.last_slope;
  const bool is_modelled = report_.last_step_length == 1.0 && progress_.is_hessian_exact &&
                           std::fabs(report_.last_difference - promised) <= kModelled * std::fabs(promised);
  const bool is_as_long = report_.last_motion > kAsLong * progress_.modelled_motion;
  const bool was_modelled = progress_.modelled_motion > 0.0;
  progress_.modelled_motion = is_modelled ? report_.last_motion : 0.0;
  return is_modelled && was_modelled && is_as_long;
}

}  // namespace stark
