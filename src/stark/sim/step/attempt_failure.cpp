#include <stark/sim/step/attempt_failure.h>

namespace stark {

AttemptFailure failure_of(SolveStatus status) {
  switch (status) {
    case SolveStatus::MaxIterations:
      return {"Newton's method did not converge within newton.max_iterations",
              "raise it, or loosen the tolerances"};
    case SolveStatus::NotFinite:
      return {"the energy or its derivatives are not finite",
              "look for collapsed elements and extreme stiffness"};
    case SolveStatus::LineSearchFailed:
      return {"no step along the Newton direction lowers the energy",
              "look for over-constrained bodies and for tolerances below rounding"};
    case SolveStatus::LinearSolveFailed:
      return {"the linear system could not be solved", "look for free bodies without inertia"};
    case SolveStatus::Blocked:
      return {"a scripted body or pinned vertex is blocked by an obstacle",
              "change its motion or the obstacle, or raise newton.max_iterations if it could give way"};
    case SolveStatus::Detour:
      return {"bodies would change places within the step", "lower time.step"};
    case SolveStatus::Interrupted:
      return {"interrupted", ""};
    case SolveStatus::TimeBudget:
      return {"newton.max_seconds is used up", "raise it, make the scene smaller, or loosen the tolerances"};
    case SolveStatus::RunAway:
      return {"the bodies moved beyond any scale of the scene",
              "hold them, or use an integrator with inertia"};
    case SolveStatus::ConstraintViolated:  // StepJoints::violation_text() says which joint
    case SolveStatus::Converged:
    case SolveStatus::RoundOff:
      break;
  }
  return {};
}

}  // namespace stark
