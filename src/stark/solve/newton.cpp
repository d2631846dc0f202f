#include <stark/solve/newton.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace stark {

namespace {

constexpr int kProjectedIterations =
    4;  ///< kept projected after an indefinite matrix (Newton slows down otherwise)
constexpr int kRoundOffIterations = 4;  ///< full steps taken where energy differences are rounding errors
constexpr int kUnsureSteps = 8;         ///< full steps on the basis of the gradient, between refreshes
constexpr double kSmallestShift = 1e-12, kShiftGrowth = 100.0;  ///< of the diagonal of an unsolvable matrix
constexpr double kTinyStep = 1e-6;       ///< step lengths below it make no progress ...
constexpr int kTinyStepLimit = 12;       ///< ... and so many in a row end the minimisation
constexpr double kUnmoved = 1e-6;        ///< velocity that an obstacle may take in silence [m/s]
constexpr int kCutShortLimit = 12;       ///< iterations beyond the tolerances for directions cut short
constexpr int kBudgetPart = 100;         ///< iterations after which a long minimisation is judged ...
constexpr double kStillFalls = 0.5;      ///< ... by its lowest residual, over that of the part before
constexpr int kBudgets = 5;              ///< newton.max_iterations that it may take
constexpr int kLagUpdateLimit = 100;     ///< updates of lagged quantities; joints need a few
constexpr double kNear = 5.0;            ///< motions over their tolerance from where the next may converge
constexpr double kWorthGuessing = 10.0;  ///< motions over their tolerance from which a guess is worth it
constexpr double kPushed = 1e-4;      ///< rise of contact energy over the gain of a guess that hits something
constexpr double kStandstill = 0.01;  ///< motions over their tolerance that move next to nothing
constexpr double kUsualStepTolerance = 1e-3;  ///< of motions that stand still, if none is set [m/s]
constexpr double kStaticShare = 1e-3;  ///< of the way of static minimisations, for the next motion to be less
constexpr double kPlaceRounding =
    1e-15;  ///< of distances from the origin, for motions that places do not show
constexpr double kStaticRounding = 1e-10;  ///< of the extent of the objective, for motions that are nothing
constexpr int kStaticPatience = 12;  ///< iterations of static minimisations for that share, beyond tolerances
constexpr double kContraction = 0.5;  ///< of directions of an older Hessian, below which they are trusted
constexpr double kSimplifiedTolerance = 1e-2;  ///< relative residual asked of conjugate gradients for them
constexpr double kSmallestForcing = 1e-4, kLargestForcing = 0.05;  ///< relative residuals of linear solves
constexpr double kColumnTolerance = 1e-6;         ///< relative residual of columns of low rank
constexpr double kNoForce = 1e-140;               ///< [N] products with forces below it underflow
constexpr int kFirstLook = 8, kLookInterval = 4;  ///< iterations at which the way is looked at
constexpr int kLooksBlocked = 2;                  ///< looks in a row that found it blocked, and end a detour
constexpr std::chrono::milliseconds kLongPart{
    100};  ///< of an iteration, after which interrupts are asked for

bool all_finite(std::span<const double> values) {
  return std::all_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); });
}

/// Diagonal of the box around all blocks [m].
double extent_of(std::span<const Vec3> positions) {
  Vec3 low = positions.empty() ? Vec3{} : positions.front(), high = low;
  for (const Vec3& p : positions)
    for (size_t k = 0; k < 3; ++k) low[k] = std::min(low[k], p[k]), high[k] = std::max(high[k], p[k]);
  return norm(high - low);
}

double dot(std::span<const double> a, std::span<const double> b) {
  double sum = 0.0;
  for (size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
  return sum;
}

}  // namespace

NewtonSolver::NewtonSolver(const NewtonSettings& settings, LinearSolver& linear_solver, PhaseTimer& timer)
    : settings_(settings), linear_solver_(linear_solver), timer_(timer) {}

SolveReport NewtonSolver::minimize(Objective& objective, double time_step, std::span<const double> guess) {
  start(objective, time_step);
  try_guess(objective, guess);
  std::optional<SolveStatus> end;
  while (!end) end = iterate(objective);
  return finish(objective, *end);
}

void NewtonSolver::start(const Objective& objective, double time_step) {
  time_step_ = time_step;
  report_ = {};
  progress_ = {.settled = {}, .unsure_steps_left = kUnsureSteps};
  if (is_static_) progress_.extent = extent_of(objective.block_positions());
  for (const Vec3& p : objective.block_positions())
    progress_.place_rounding = std::max(progress_.place_rounding, kPlaceRounding * norm(p));
  const size_t n = 3 * static_cast<size_t>(objective.block_count());
  gradient_.assign(n, 0.0);
  direction_.assign(n, 0.0);
  right_hand_side_.assign(n, 0.0);
}

void NewtonSolver::try_guess(Objective& objective, std::span<const double> guess) {
  // Energies along a step are not comparable while prescribed parts move.
  if (guess.empty() || objective.has_pending_motion()) return;
  std::ranges::copy(guess, direction_.begin());
  if (!(objective.motion(direction_) > kWorthGuessing * settings_.step_tolerance * time_step_)) return;
  objective.evaluate_gradient(gradient_);
  if (!(slope() < 0.0)) return;
  {
    const PhaseTimer::Scope scope(timer_, Phase::StepBound);
    if (objective.bound_step(direction_, settings_.max_rotation) < 1.0) return;
  }
  const PhaseTimer::Scope scope(timer_, Phase::LineSearch);
  const TrialEnergy trial = objective.try_step(direction_, 1.0);
  const bool is_pushed = trial.contact > kPushed * -trial.difference;
  if (trial.feasible && trial.difference < 0.0 && !is_pushed) objective.accept_trial();
}

std::optional<SolveStatus> NewtonSolver::iterate(Objective& objective) {
  if (const auto reason = reason_to_stop(objective)) return reason;
  const bool pending = objective.has_pending_motion();
  const SolveReport before = report_;
  const bool is_simplified = find_simplified_direction(objective);
  if (!is_simplified)
    if (const auto failure = find_direction(objective)) return failure;
  report_.last_motion = objective.motion(direction_);
  report_.is_at_rounding = false;
  progress_.stands_still = stands_still(before);
  const bool converged = !pending && has_converged(objective);
  if (is_used_up() && !converged) return pending ? SolveStatus::Blocked : SolveStatus::MaxIterations;

  if (pending && is_static_ && moves_prescribed_alone(objective)) {
    ++report_.iterations;
    return {};
  }
  // The last direction is known, so it is taken even when its size already says "converged".
  const SolveStatus searched = line_search(objective);
  if (searched == SolveStatus::Interrupted) return searched;
  trust_hessian(searched, pending);
  progress_.way += report_.last_step_length * report_.last_motion;
  const bool is_last = converged && !is_cut_short(searched);
  if (!is_last) ++report_.iterations;
  if (searched == SolveStatus::RoundOff) ++progress_.round_off_steps;
  const bool is_unseen = is_simplified && searched == SolveStatus::RoundOff && report_.lag_updates > 0;
  if (is_last && (is_unseen || !progress_.is_hessian_exact)) look_back(objective);
  if (is_last) return refresh_lagged(objective, SolveStatus::Converged);
  if (searched == SolveStatus::RoundOff && progress_.round_off_steps >= kRoundOffIterations)
    return refresh_lagged(objective, SolveStatus::RoundOff);
  if (!pending && goes_around()) return SolveStatus::Detour;
  if (!pending) relieve(objective);
  if (!pending) refresh_early(objective);
  return handle_no_progress(objective, searched, pending);
}

SolveReport NewtonSolver::finish(Objective& objective, SolveStatus status) {
  // A solution whose friction is a round behind is better than none.
  const bool given_up =
      !is_success(status) && status != SolveStatus::Interrupted && status != SolveStatus::Detour;
  report_.status = status;
  report_.is_settled = given_up && objective.restore_settled();
  if (report_.is_settled) {
    const SolveReport& settled = progress_.settled;
    report_.status = settled.status;
    report_.residual = settled.residual;
    report_.acceleration = settled.acceleration;
    report_.last_motion = settled.last_motion;
    report_.is_at_rounding = settled.is_at_rounding;
  }
  return report_;
}

void NewtonSolver::trust_hessian(SolveStatus searched, bool pending) {
  const bool is_full = searched == SolveStatus::Converged && report_.last_step_length == 1.0;
  const bool is_near = report_.last_motion < kNear * settings_.step_tolerance * time_step_;
  progress_.simplified_limit = !pending && is_full && is_near ? kContraction * report_.last_motion : 0.0;
}

// Half of the step takes more than half of the iterations, and what has been gained is lost: sheets that a
// press sweeps together come to rest at last in hundreds of short steps.
bool NewtonSolver::is_used_up() {
  progress_.lowest = std::min(progress_.lowest, report_.residual);
  if (report_.iterations > 0 && report_.iterations % kBudgetPart == 0) {
    progress_.still_falls =
        std::isfinite(progress_.lowest_before) && progress_.lowest < kStillFalls * progress_.lowest_before;
    progress_.lowest_before = progress_.lowest;
    progress_.lowest = std::numeric_limits<double>::infinity();
  }
  const int budgets = progress_.still_falls ? kBudgets : 1;
  return report_.iterations >= budgets * settings_.max_iterations;
}

// Whose end lies behind something takes many iterations to get there, and will be thrown away.
bool NewtonSolver::goes_around() {
  if (!is_way_clear_ || !looks_early_) return false;
  if (report_.iterations < kFirstLook || report_.iterations % kLookInterval != 0) return false;
  progress_.blocked_looks = is_way_clear_() ? 0 : progress_.blocked_looks + 1;
  return progress_.blocked_looks == kLooksBlocked;
}

// Slow bodies meet the tolerances before they have met each other: what stands in the way of the last
// direction has not pushed back yet, and would take momentum without giving it to anything.
bool NewtonSolver::is_cut_short(SolveStatus searched) {
  const double missing = (1.0 - report_.last_step_length) * report_.last_motion;
  return searched == SolveStatus::Converged && missing > kUnmoved * time_step_ &&
         report_.last_step_length >= kTinyStep && report_.iterations < settings_.max_iterations &&
         progress_.cut_short++ < kCutShortLimit;
}

// A projected matrix knows nothing of a way down between two ways up, and one of before a refresh nothing of
// friction that is new: steps along them may add to forces where energies do not show it.
void NewtonSolver::look_back(Objective& objective) {
  if (report_.last_motion == 0.0) return;
  const SolveReport found = report_;
  objective.evaluate_gradient(gradient_);
  read_gradient(objective);
  if (meets_tolerances(found) && !meets_tolerances(report_) && objective.take_back()) report_ = found;
}

std::optional<SolveStatus> NewtonSolver::refresh_lagged(Objective& objective, SolveStatus reached) {
  if (report_.lag_updates == 0 && is_way_clear_ && !is_way_clear_()) return SolveStatus::Detour;
  report_.lag_residual = objective.refresh_lagged(report_.lag_updates);
  if (report_.lag_residual == 0.0) return reached;
  if (++report_.lag_updates >= kLagUpdateLimit || std::isinf(report_.lag_residual))
    return SolveStatus::ConstraintViolated;
  progress_.settled = report_;
  progress_.settled.status = reached;
  // What has changed are forces, little as a rule.
  progress_.simplified_limit = std::numeric_limits<double>::infinity();
  progress_.unsure_steps_left = kUnsureSteps;
  progress_.round_off_steps = 0;
  return {};
}

std::optional<SolveStatus> NewtonSolver::handle_no_progress(Objective& objective, SolveStatus searched,
                                                            bool pending) {
  if (searched == SolveStatus::LineSearchFailed) {
    // Descent for certain, and yet no step lowers the energy: differences are rounding errors that the
    // magnitude does not show, as in stiff elements whose energy is a difference of large terms. The
    // gradient is exact still.
    if (!pending && take_unsure_step(objective)) return {};
    if (progress_.projected_left > 0 || settings_.projection != Projection::OnDemand) return searched;
    progress_.projected_left = kProjectedIterations;
  }
  progress_.tiny_steps = report_.last_step_length < kTinyStep ? progress_.tiny_steps + 1 : 0;
  if (progress_.tiny_steps > 1 && !pending && take_unsure_step(objective)) progress_.tiny_steps = 0;
  if (progress_.tiny_steps < kTinyStepLimit) return {};
  return pending ? SolveStatus::Blocked : SolveStatus::LineSearchFailed;
}

bool NewtonSolver::is_interrupted() {
  if (!interrupted_) return false;
  const bool is_over = interrupted_();
  asked_ = std::chrono::steady_clock::now();
  return is_over;
}

bool NewtonSolver::is_interrupted_meanwhile() {
  return std::chrono::steady_clock::now() - asked_ > kLongPart && is_interrupted();
}

std::optional<SolveStatus> NewtonSolver::reason_to_stop(const Objective& objective) {
  if (is_interrupted()) return SolveStatus::Interrupted;
  if (deadline_ && std::chrono::steady_clock::now() >= *deadline_) return SolveStatus::TimeBudget;
  if (objective.has_run_away()) return SolveStatus::RunAway;
  return {};
}

// Whether an iterate has converged takes a direction, but no new Hessian where the last one is nearly that of
// the iterate: the simplified Newton correction d with its contraction Theta bounds the distance to the
// solution by |d| / (1 - Theta) [theory eq. 23a; Deuflhard 2011, sec. 2.1]. It is taken where it says
// "converged".
bool NewtonSolver::find_simplified_direction(Objective& objective) {
  if (!progress_.is_hessian_exact || progress_.simplified_limit == 0.0 || progress_.projected_left > 0)
    return false;
  objective.evaluate_gradient(gradient_);
  if (!all_finite(gradient_)) return false;
  read_gradient(objective);
  const PhaseTimer::Scope scope(timer_, Phase::LinearSolve);
  const LinearSolveReport solved = linear_solver_.solve_again(
      {.A = hessian_, .b = right_hand_side_, .tolerance = std::max(kSimplifiedTolerance, useful_tolerance())},
      direction_);
  report_.linear_iterations += solved.iterations;
  if (!solved.ok || !all_finite(direction_)) return false;
  if (!objective.low_rank().empty()) correction_.apply(direction_);
  report_.last_motion = objective.motion(direction_);
  const bool is_trusted = report_.last_motion <= progress_.simplified_limit && slope() <= 0.0;
  report_.last_motion /= 1.0 - kContraction;
  return is_trusted && meets_tolerances(report_) && is_short();
}

std::optional<SolveStatus> NewtonSolver::find_direction(Objective& objective) {
  bool project = settings_.projection == Projection::Always || progress_.projected_left > 0;
  if (progress_.projected_left > 0) --progress_.projected_left;
  Direction found = solve_direction(objective, project);
  if (found == Direction::Failed && !project && settings_.projection == Projection::OnDemand) {
    progress_.projected_left = kProjectedIterations - 1;
    found = solve_direction(objective, true);
  }
  switch (found) {
    case Direction::Found:
      break;
    case Direction::Failed:
      return SolveStatus::LinearSolveFailed;
    case Direction::NotFinite:
      return SolveStatus::NotFinite;
    case Direction::Interrupted:
      return SolveStatus::Interrupted;
  }
  return {};
}

NewtonSolver::Direction NewtonSolver::solve_direction(Objective& objective, bool project) {
  objective.linearize(project, gradient_, hessian_);
  if (is_interrupted_meanwhile()) return Direction::Interrupted;
  if (!all_finite(gradient_)) return Direction::NotFinite;
  // A projected matrix after the exact one is a rough model: its gradient is the same, so the forcing rule
  // gives the loosest tolerance.
  read_gradient(objective);
  const double tolerance = forcing_tolerance();
  progress_.is_hessian_exact = !project;
  if (project) ++report_.projected_iterations;
  const PhaseTimer::Scope scope(timer_, Phase::LinearSolve);
  const bool may_be_indefinite = !project && settings_.projection != Projection::Never;
  const LinearSolveReport solved = solve_linear(objective, tolerance, may_be_indefinite);
  if (is_interrupted_meanwhile()) return Direction::Interrupted;
  const bool is_found = solved.ok && is_descent();
  if (!project) return is_found ? Direction::Found : Direction::Failed;
  if (is_found && objective.is_within_reach(direction_)) return Direction::Found;
  return solve_shifted(objective, tolerance) ? Direction::Found : Direction::Failed;
}

LinearSolveReport NewtonSolver::solve_linear(Objective& objective, double tolerance, bool may_be_indefinite) {
  const LinearSystem system{.A = hessian_,
                            .b = right_hand_side_,
                            .tolerance = tolerance,
                            .positions = objective.block_positions(),
                            .may_be_indefinite = may_be_indefinite};
  const LowRank& beside = objective.low_rank();
  const LinearSolveReport solved =
      beside.empty() ? linear_solver_.solve(system, direction_) : solve_with_low_rank(beside, system);
  report_.linear_iterations += solved.iterations;
  report_.factorizations += solved.factorizations;
  return solved;
}

// The columns first and well. What the right-hand side has along them is then known to their precision, and
// the tolerance holds for the rest: of a liquid the pressure would hide all other forces.
LinearSolveReport NewtonSolver::solve_with_low_rank(const LowRank& terms, const LinearSystem& system) {
  LinearSolveReport all;
  bool is_first = true;
  const auto solve = [&](std::span<const double> b, double tolerance, std::span<double> x) {
    LinearSystem one{.A = system.A,
                     .b = b,
                     .tolerance = tolerance,
                     .positions = system.positions,
                     .may_be_indefinite = system.may_be_indefinite};
    LinearSolveReport found;
    if (!is_first) found = linear_solver_.solve_again(one, x);
    if (!found.ok) found = linear_solver_.solve(one, x);  // some solvers keep nothing
    is_first = false;
    found.iterations += all.iterations;
    found.factorizations += all.factorizations;
    all = found;
    return found.ok;
  };
  all.ok = correction_.begin(terms, [&](std::span<const double> b, std::span<double> x) {
    return solve(b, std::min(system.tolerance, kColumnTolerance), x);
  });
  if (!all.ok) return all;
  std::vector<double> rest(system.b.begin(), system.b.end());
  const std::vector<double> along = correction_.take_out(rest);
  if (!solve(rest, system.tolerance, direction_)) return all;
  correction_.put_back(along, direction_);
  correction_.apply(direction_);
  return all;
}

// A gradient of zero has the direction zero.
bool NewtonSolver::is_descent() const {
  return all_finite(direction_) && (slope() < 0.0 || dot(gradient_, gradient_) == 0.0);
}

// Forces that are left over, and the right-hand side of the linear solve that is to balance them.
void NewtonSolver::read_gradient(const Objective& objective) {
  const Residual residual = objective.residual(gradient_);
  report_.residual = residual.force;
  report_.acceleration = residual.acceleration;
  const auto is_nothing = [](double force) { return std::fabs(force) < kNoForce; };
  if (std::ranges::all_of(gradient_, is_nothing)) std::ranges::fill(gradient_, 0.0);
  std::transform(gradient_.begin(), gradient_.end(), right_hand_side_.begin(), std::negate<>());
}

bool NewtonSolver::solve_shifted(Objective& objective, double tolerance) {
  progress_.is_hessian_exact = false;
  // Projected and still not solvable: singular, or so badly scaled that rounding makes it indefinite. Or next
  // to singular, as without inertia for sheets without stress across their plane: directions of a million
  // times the scene take its whole search for collisions, and more halvings than there are. A multiple of the
  // diagonal shortens the step where nothing else holds it [Levenberg 1944, Marquardt 1963].
  const auto diagonal = [&](size_t i) -> double& {
    return hessian_.values[9 * hessian_.pattern.row_start[i / 3] + 4 * (i % 3)];
  };
  double mean = 0.0;
  for (size_t i = 0; i < gradient_.size(); ++i) mean += std::fabs(diagonal(i));
  mean /= static_cast<double>(gradient_.size());
  for (double shift = kSmallestShift; shift <= 1.0; shift *= kShiftGrowth) {
    for (size_t i = 0; i < gradient_.size(); ++i) diagonal(i) += shift * (std::fabs(diagonal(i)) + mean);
    const LinearSolveReport solved = solve_linear(objective, tolerance, false);
    const bool is_largest = shift * kShiftGrowth > 1.0;
    const bool is_down = solved.ok && all_finite(direction_) && slope() < 0.0;
    if (is_down && (is_largest || objective.is_within_reach(direction_))) return true;
  }
  return false;
}

double NewtonSolver::slope() const { return dot(gradient_, direction_); }

double NewtonSolver::forcing_tolerance() {
  // Eisenstat and Walker 1996, choice 2: solve only as exactly as the quadratic model is worth ...
  const double norm = std::sqrt(dot(gradient_, gradient_));
  const double ratio = progress_.gradient_norm > 0.0 ? norm / progress_.gradient_norm : 0.3;
  progress_.gradient_norm = norm;
  const double model = std::clamp(0.9 * ratio * ratio, kSmallestForcing, kLargestForcing);
  // ... and not beyond what convergence takes.
  return std::max(model, useful_tolerance());
}

// Relative residual of a linear solve that brings the forces to half of their tolerances [Kelley 1995,
// eq. 6.20], and what is left of the last motion where that must have settled, too.
double NewtonSolver::useful_tolerance() const {
  const bool all = settings_.termination == Termination::All;
  std::optional<double> useful;
  const auto ask = [&](double tolerance, double value) {
    if (tolerance <= 0.0) return;
    const double share = value > 0.0 ? std::min(0.5 * tolerance / value, kLargestForcing) : kLargestForcing;
    useful = !useful ? share : all ? std::min(*useful, share) : std::max(*useful, share);
  };
  ask(settings_.residual_tolerance, report_.residual);
  ask(settings_.acceleration_tolerance, report_.acceleration);
  if (all) ask(settings_.step_tolerance * time_step_, report_.last_motion);
  if (all && is_static_ && progress_.way > 0.0) ask(kStaticShare * progress_.way, report_.last_motion);
  return useful.value_or(0.0);
}

bool NewtonSolver::has_converged(const Objective& objective) {
  const bool may_be_rounding = progress_.round_off_steps > 0 || progress_.stands_still;
  if (meets_tolerances(report_) && (is_short() || progress_.static_patience++ >= kStaticPatience))
    return !is_short_for_its_matrix();
  return may_be_rounding && is_at_rounding(objective);
}

// Without inertia a projected matrix may hold back what is far from its equilibrium. The next direction is of
// the exact one again, where that has one.
bool NewtonSolver::is_short_for_its_matrix() {
  if (!is_static_ || progress_.is_hessian_exact || settings_.projection != Projection::OnDemand) return false;
  if (report_.last_motion == 0.0 || progress_.static_patience++ >= kStaticPatience) return false;
  progress_.projected_left = 0;
  return true;
}

// Without inertia nothing relates forces to masses, nor motions to the time step: what settings tolerate may
// be all of the load and all of its deflection.
bool NewtonSolver::is_short() const {
  if (!is_static_ || settings_.step_tolerance <= 0.0) return true;
  if (report_.last_motion <= kStaticShare * progress_.way || report_.last_motion == 0.0) return true;
  return report_.iterations > 0 && report_.last_motion <= kStaticRounding * progress_.extent;
}

// Energies of stiff elements at rest are rounding, and differences of them look like a way up or down. A full
// step near the solution leaves a fraction of the forces; what one leaves as they were, where another would
// move next to nothing, may be rounding.
bool NewtonSolver::stands_still(const SolveReport& before) const {
  if (before.iterations == 0 || report_.residual < kContraction * before.residual ||
      report_.acceleration < kContraction * before.acceleration)
    return false;
  if (report_.last_motion <= progress_.place_rounding) return true;  // whatever part of it was taken
  const double tolerance = settings_.step_tolerance > 0.0 ? settings_.step_tolerance : kUsualStepTolerance;
  return before.last_step_length == 1.0 && report_.last_motion < kStandstill * tolerance * time_step_;
}

bool NewtonSolver::meets_tolerances(const SolveReport& report, double factor) const {
  bool all = true, any = false;
  const auto test = [&](double tolerance, double value) {
    if (tolerance <= 0.0) return;
    all = all && value < factor * tolerance;
    any = any || value < factor * tolerance;
  };
  test(settings_.residual_tolerance, report.residual);
  test(settings_.acceleration_tolerance, report.acceleration);
  test(settings_.step_tolerance, report.last_motion / time_step_);
  return settings_.termination == Termination::All ? all : any;
}

bool NewtonSolver::is_at_rounding(const Objective& objective) {
  const Residual beyond = objective.residual_beyond_rounding(gradient_, hessian_);
  SolveReport without = report_;
  without.residual = beyond.force;
  without.acceleration = beyond.acceleration;
  report_.is_at_rounding = meets_tolerances(without);
  return report_.is_at_rounding;
}

}  // namespace stark
