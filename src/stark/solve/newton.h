// Newton's method with line search (step phases 4, 4h to 4j): raw Hessians, projected ones where the matrix
// turns out indefinite; steps bounded by continuous collision detection; Armijo's rule on energy differences.
// [theory eq. 22, 23]
#pragma once

#include <chrono>
#include <functional>
#include <optional>
#include <span>

#include <stark/base/timer.h>
#include <stark/linalg/linear_solver.h>
#include <stark/solve/newton_settings.h>
#include <stark/solve/objective.h>
#include <stark/solve/report.h>

namespace stark {

class NewtonSolver {
 public:
  NewtonSolver(const NewtonSettings& settings, LinearSolver& linear_solver, PhaseTimer& timer);

  /// Asked between iterations, and within those that take long; returning true ends the minimisation with
  /// status Interrupted.
  void set_interrupt(std::function<bool()> interrupted) { interrupted_ = std::move(interrupted); }

  /// From this time on, looked at between iterations, minimisations end with status TimeBudget.
  void set_deadline(std::optional<std::chrono::steady_clock::time_point> deadline) { deadline_ = deadline; }

  /// Minimises from the objective's current iterate, which is left at the last accepted point. `time_step`
  /// [s] turns the motion of a Newton step into a velocity.
  SolveReport minimize(Objective& objective, double time_step);
  /// Of the minimisation under way, or the last one.
  const SolveReport& progress() const { return report_; }
  /// Last direction of the last minimisation.
  std::span<const double> direction() const { return direction_; }

 private:
  enum class Direction : uint8_t { Found, NotFinite, Failed, Interrupted };
  Direction find_direction(Objective& objective, double time_step, SolveReport& report);
  bool find_simplified_direction(Objective& objective, double time_step, SolveReport& report);
  void read_gradient(const Objective& objective, SolveReport& report);
  bool is_converged(const SolveReport& report, double time_step) const;
  /// Whether nothing but rounding keeps the tolerances from being met.
  bool is_at_rounding(const Objective& objective, SolveReport& report, double time_step) const;
  SolveStatus line_search(Objective& objective, SolveReport& report);
  /// A full step on the word of the gradient, where energies do not show the decrease.
  bool take_unsure_step(Objective& objective, SolveReport& report);
  bool solve_shifted(Objective& objective, double tolerance, SolveReport& report);
  std::optional<SolveStatus> reason_to_stop(const Objective& objective);
  bool is_interrupted();
  /// The same where it has not been asked for a while.
  bool is_interrupted_meanwhile();
  double slope() const;
  double forcing_tolerance(const SolveReport& report, double time_step);
  double useful_tolerance(const SolveReport& report, double time_step) const;

  NewtonSettings settings_;
  LinearSolver& linear_solver_;
  PhaseTimer& timer_;
  std::function<bool()> interrupted_;
  std::chrono::steady_clock::time_point asked_;  ///< when interrupted_ was
  std::optional<std::chrono::steady_clock::time_point> deadline_;
  SolveReport report_;
  std::vector<double> gradient_, direction_, right_hand_side_;
  BlockMatrix hessian_;
  int unsure_steps_left_ = 0;      ///< of take_unsure_step()
  bool is_hessian_exact_ = false;  ///< neither projected nor shifted
  /// Motion [m] below which a direction of the last Hessian is good enough; 0: that Hessian is not.
  double simplified_limit_ = 0.0;
  int projection_countdown_ = 0;  ///< iterations for which Hessians stay projected after a failure
  double previous_gradient_norm_ = 0.0;
};

}  // namespace stark
