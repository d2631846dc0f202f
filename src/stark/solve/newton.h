// Newton's method with line search (step phases 4, 4h to 4j): raw Hessians, projected ones where the matrix
// turns out indefinite; steps bounded by continuous collision detection; Armijo's rule on energy differences.
// [theory eq. 22, 23]
#pragma once

#include <chrono>
#include <functional>
#include <limits>
#include <optional>
#include <span>

#include <stark/base/timer.h>
#include <stark/linalg/linear_solver.h>
#include <stark/solve/low_rank.h>
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

  /// Asked of the first iterate that has converged, before lagged quantities are refreshed, and, if `early`,
  /// of some that have not; returning false then, or twice in a row, ends the minimisation with status
  /// Detour.
  void set_way_check(std::function<bool()> is_way_clear, bool early = true) {
    is_way_clear_ = std::move(is_way_clear);
    looks_early_ = early;
  }

  /// Minimisations are of energies without inertia.
  void set_static(bool is_static) { is_static_ = is_static; }

  /// From this time on, checked between iterations, minimisations end with status TimeBudget.
  void set_deadline(std::optional<std::chrono::steady_clock::time_point> deadline) { deadline_ = deadline; }

  /// Minimises from the objective's current iterate, which is left at the last accepted point. `time_step`
  /// [s] turns the motion of a Newton step into a velocity. `guess`: an increment to begin with, taken where
  /// nothing is in its way and its end has a lower energy; may be empty.
  SolveReport minimize(Objective& objective, double time_step, std::span<const double> guess = {});
  /// Of the minimisation under way, or the last one.
  const SolveReport& progress() const { return report_; }
  /// Last direction of the last minimisation.
  std::span<const double> direction() const { return direction_; }

 private:
  /// What a minimisation learns on its way.
  struct Progress {
    SolveReport settled;        ///< when lagged quantities were refreshed last
    int tiny_steps = 0;         ///< in a row
    int round_off_steps = 0;    ///< since the last refresh
    int cut_short = 0;          ///< directions since the tolerances were met first
    int unsure_steps_left = 0;  ///< of take_unsure_step()
    int projected_left = 0;     ///< iterations for which Hessians stay projected after a failure
    int blocked_looks = 0;      ///< in a row at which the way was not clear
    int early_refreshes = 0;    ///< of lagged quantities, before anything has converged
    int full_steps = 0;         ///< since the residual was halved last ...
    double halved_residual = std::numeric_limits<double>::infinity();  ///< ... to this [N]
    int held_steps = 0;      ///< in a row that the bound has kept short
    int late_refreshes = 0;  ///< the same of all of them, in minimisations that take long
    /// Lowest residual [N] of this part of the iterations, and of the one before.
    double lowest = std::numeric_limits<double>::infinity(), lowest_before = lowest;
    bool still_falls = false;       ///< whether it fell from part to part
    int static_patience = 0;        ///< iterations that met the tolerances, but moved by too much of the way
    double way = 0.0;               ///< sum of the motions of all steps [m]
    double place_rounding = 0.0;    ///< motion that places do not show [m]
    double extent = 0.0;            ///< of the objective of a static minimisation [m]
    bool is_hessian_exact = false;  ///< neither projected nor shifted
    bool stands_still = false;      ///< the last full step has reduced nothing
    double gradient_norm = 0.0;     ///< of the iteration before; 0: there was none
    double modelled_motion = 0.0;   ///< of the iteration before, if its model was right; else 0 [m]
    /// Motion [m] below which a direction of the last Hessian is good enough; 0: that Hessian is not.
    double simplified_limit = 0.0;
  };

  void start(const Objective& objective, double time_step);
  void try_guess(Objective& objective, std::span<const double> guess);
  /// One iteration; why the minimisation ends with it, if it does.
  std::optional<SolveStatus> iterate(Objective& objective);
  SolveReport finish(Objective& objective, SolveStatus status);
  std::optional<SolveStatus> reason_to_stop(const Objective& objective);

  /// Both give the direction of the iterate; the second one why there is none, if so.
  bool find_simplified_direction(Objective& objective);
  std::optional<SolveStatus> find_direction(Objective& objective);
  /// One with the Hessian at the iterate, projected or not. Failed: not a direction of descent.
  enum class Direction : uint8_t { Found, Failed, NotFinite, Interrupted };
  Direction solve_direction(Objective& objective, bool project);
  LinearSolveReport solve_linear(Objective& objective, double tolerance, bool may_be_indefinite);
  /// The same of a Hessian with terms of low rank beside its blocks.
  LinearSolveReport solve_with_low_rank(const LowRank& terms, const LinearSystem& system);
  bool solve_shifted(Objective& objective, double tolerance);
  bool is_descent() const;
  double slope() const;
  double forcing_tolerance();
  double useful_tolerance() const;

  void read_gradient(const Objective& objective);
  bool has_converged(const Objective& objective);
  /// All tolerances times a factor.
  bool meets_tolerances(const SolveReport& report, double factor = 1.0) const;
  /// Whether the next motion of a static minimisation is little beside those before it.
  bool is_short() const;
  /// Whether it is little because the matrix of a static minimisation is projected; once more for each
  /// patience.
  bool is_short_for_its_matrix();
  /// Whether the iterates went around something: the way from the start to them stays blocked.
  bool goes_around();
  /// Whether something stood in the way of the last direction that it has not pushed against yet.
  bool is_cut_short(SolveStatus searched);
  /// Takes the last step back if forces at its end miss the tolerances that they met before it.
  void look_back(Objective& objective);
  /// Whether a full step has reduced nothing, and another would move next to nothing.
  bool stands_still(const SolveReport& before) const;
  /// Whether nothing but rounding keeps the tolerances from being met.
  bool is_at_rounding(const Objective& objective);

  /// Whether it is better to move what is prescribed without the rest first; then done.
  bool moves_prescribed_alone(Objective& objective);
  SolveStatus line_search(Objective& objective);
  /// Whether the difference of energies along a share of the direction is rounding.
  bool is_rounding(double difference, double alpha) const;
  /// Goes beyond the full step, whose trial is known, as long as the energy keeps falling.
  void lengthen_step(Objective& objective, TrialEnergy full);
  /// Halvings of a step that has raised the energy after one that was longer by `halvings`; promised: what
  /// its slope gives.
  static int halvings_after(double rise, double longer, int halvings, double promised);
  /// Goes nearer to the longer step that was refused, where the accepted one met nothing on its way.
  void step_nearer(Objective& objective, double alpha, double refused, TrialEnergy trial);
  /// A full step on the basis of the gradient alone, where energies do not show the decrease.
  bool take_unsure_step(Objective& objective);
  /// Whether the iterate after a step is so near that the next direction may do without a new Hessian.
  void trust_hessian(SolveStatus searched, bool pending);
  /// Whether newton.max_iterations are used up, or a few times as many while the residual falls.
  bool is_used_up();
  /// Brings lagged quantities up to date on the way to the first solution with them.
  void refresh_early(Objective& objective);
  /// Has the objective give way where collisions keep steps short again and again.
  void relieve(Objective& objective);
  /// Whether full steps have not halved the residual for long.
  bool makes_no_headway();
  /// Whether refreshes keep moving the minimum to and fro.
  bool leads_nowhere();
  std::optional<SolveStatus> refresh_lagged(Objective& objective, SolveStatus reached);
  /// What follows from steps that fail or lead nowhere.
  std::optional<SolveStatus> handle_no_progress(Objective& objective, SolveStatus searched, bool pending);

  bool is_interrupted();
  /// The same where it has not been asked for a while.
  bool is_interrupted_meanwhile();

  NewtonSettings settings_;
  LinearSolver& linear_solver_;
  PhaseTimer& timer_;
  std::function<bool()> interrupted_, is_way_clear_;
  bool looks_early_ = true, is_static_ = false;
  std::chrono::steady_clock::time_point asked_;  ///< when interrupted_ was
  std::optional<std::chrono::steady_clock::time_point> deadline_;
  double time_step_ = 0.0;  ///< [s] of the minimisation under way
  SolveReport report_;      ///< of it
  Progress progress_;       ///< of it
  std::vector<double> gradient_, direction_, right_hand_side_;
  BlockMatrix hessian_;
  LowRankCorrection correction_;  ///< of solutions with it
};

}  // namespace stark
