// Step lengths (step phase 4i): sufficient decrease of the energy within what collision detection allows,
// longer steps where the matrix is too stiff, steps that the gradient alone decides where energies are
// rounding.
#include <algorithm>
#include <cmath>

#include <stark/solve/newton.h>

namespace stark {

namespace {

constexpr double kEnergyRounding = 1e-15;  ///< relative rounding of a sum of element energies
constexpr double kNoiseRise = 1e3;         ///< rise over the noise that may be rounding where steps are tiny
constexpr int kRoundingProbe = 10;         ///< halvings after which the energy shows whether it is rounding
constexpr int kTinyHalvings = 7;           ///< halvings after which what is accepted must lower the energy
constexpr double kUnsureRise = 1e-3;       ///< relative rise that may be rounding in stiff elements
/// Share of the slope that a full step gains, above which it is too short: half where the model fits, 7/12
/// where the energy is the cube of a depth, as that of a barrier is that is hardly touched.
constexpr double kTooShort = 0.56;
constexpr double kStillFalling = 0.5;  ///< share of it along longer steps, above which they go on
constexpr double kLengthening = 2.0, kLongestStep = 32.0;  ///< of full steps that are too short
constexpr double kUnbent = 0.95;  ///< part of what the model promises that a step gains which met nothing new
constexpr double kSmallestPower =
    3.0;                            ///< of the length, with which what contact raises the energy by shrinks
constexpr int kMostHalvings = 4;    ///< at once
constexpr double kHeld = 0.05;      ///< bound of steps that collisions keep short
constexpr int kReliefInterval = 6;  ///< such steps in a row
constexpr int kNearerTrials = 4;    ///< between such a step and the longer one that was refused

}  // namespace

SolveStatus NewtonSolver::line_search(Objective& objective) {
  const bool pending = objective.has_pending_motion();
  double alpha = 0.0;
  {
    const PhaseTimer::Scope scope(timer_, Phase::StepBound);
    alpha = objective.bound_step(direction_, settings_.max_rotation);
  }
  const PhaseTimer::Scope scope(timer_, Phase::LineSearch);
  const double decrease = slope();
  report_.last_bound = alpha;
  report_.last_slope = decrease;
  double longer = 0.0;           // what the trial before has raised the energy by
  double refused = 2.0 * alpha;  // its length
  int halvings = 1;
  for (int k = 0; k <= settings_.max_backtracks; k += halvings, alpha = std::ldexp(alpha, -halvings)) {
    if (is_interrupted_meanwhile()) return SolveStatus::Interrupted;
    const TrialEnergy trial = objective.try_step(direction_, alpha);
    const double noise = kEnergyRounding * trial.magnitude;
    // What the step should lower the energy by is below its rounding, which stiff elements show as more than
    // their magnitude tells: only the gradient knows better, and it asks for the whole step.
    const bool is_below_noise = !pending && -decrease < noise;
    const double allowed = is_below_noise ? kNoiseRise * noise : settings_.armijo * alpha * decrease + noise;
    if (trial.feasible && (pending || trial.difference <= allowed)) {
      const bool is_seen = !pending && !is_below_noise;
      // A tiny step that is accepted for the noise alone, or gains more than its slope, shows nothing either.
      const bool is_tiny = is_seen && k >= kTinyHalvings;
      if (is_tiny && (trial.difference > 0.0 || is_rounding(trial.difference, alpha))) {
        if (take_unsure_step(objective)) return SolveStatus::Converged;
        objective.try_step(direction_, alpha);
      }
      report_.last_step_length = alpha;
      report_.last_difference = trial.difference;
      if (is_seen && alpha == 1.0) lengthen_step(objective, trial);
      if (is_seen && k > 0) step_nearer(objective, alpha, refused, trial);
      objective.accept_trial();
      return is_below_noise ? SolveStatus::RoundOff : SolveStatus::Converged;
    }
    ++report_.backtracks;
    refused = alpha;
    halvings =
        !pending && trial.feasible ? halvings_after(trial.difference, longer, halvings, alpha * decrease) : 1;
    if (k < kRoundingProbe) halvings = std::min(halvings, kRoundingProbe - k);
    // A tiny part of the step that raises the energy by more than all of it should lower it: differences are
    // rounding of stiff elements, more than their magnitude shows. The gradient, exact still, decides.
    const bool is_hidden =
        k == kRoundingProbe && trial.feasible && trial.difference > -decrease && -decrease >= noise;
    // So they are where half of a step raises it by no less than the whole one, by as little as rounding may.
    const bool is_uneven = !pending && trial.feasible && longer > 0.0 && trial.difference >= longer &&
                           trial.difference <= objective.energy_rounding(hessian_);
    longer = trial.difference;
    if ((is_hidden || is_uneven) && take_unsure_step(objective)) return SolveStatus::Converged;
  }
  report_.last_step_length = 0.0;
  return SolveStatus::LineSearchFailed;
}

// What a contact that the matrix does not know raises the energy by shrinks with a power of the length, the
// third at least: as many halvings as bring it below what the slope promises.
int NewtonSolver::halvings_after(double rise, double longer, int halvings, double promised) {
  if (!(longer > rise) || !(rise > 0.0) || !(promised < 0.0)) return 1;
  const double power = std::max(kSmallestPower, std::log2(longer / rise) / halvings);
  return std::clamp(static_cast<int>(std::log2(rise / -promised) / (power - 1.0)), 1, kMostHalvings);
}

// Where the matrix is exact and positive definite, nothing gains more than its slope.
bool NewtonSolver::is_rounding(double difference, double alpha) const {
  return progress_.is_hessian_exact && difference < alpha * slope();
}

// Of a quadratic model that fits, a full step gains half of what its slope promises. One that gains more
// stops before the minimum along the direction: the matrix, projected as a rule, is too stiff, or a barrier
// fades on the way.
void NewtonSolver::lengthen_step(Objective& objective, TrialEnergy full) {
  double best = full.difference, longest = 1.0;
  if (best > kTooShort * slope() || is_rounding(best, 1.0)) return;
  while (longest < kLongestStep) {
    const double wish = kLengthening * longest;
    const double alpha = objective.bound_step(direction_, settings_.max_rotation, wish);
    if (alpha <= longest) break;
    const TrialEnergy trial = objective.try_step(direction_, alpha);
    if (!trial.feasible || !(trial.difference < best)) break;
    const bool keeps_falling = trial.difference - best <= kStillFalling * (alpha - longest) * slope();
    best = trial.difference;
    longest = alpha;
    report_.last_difference = best;
    if (alpha < wish || !keeps_falling) {
      report_.last_step_length = longest;
      return;  // the trial point is the best one
    }
  }
  if (longest > 1.0) report_.last_step_length = longest;
  objective.try_step(direction_, longest);
}

// A step that gains all that the model promises, where one of twice its length is refused, ends before what
// refuses the longer one: a contact, as a rule, that the matrix does not know yet. So it goes on until it
// meets that.
void NewtonSolver::step_nearer(Objective& objective, double alpha, double refused, TrialEnergy trial) {
  const auto promised = [&](double share) { return slope() * share * (1.0 - 0.5 * share); };
  if (trial.difference > kUnbent * promised(alpha) || is_rounding(trial.difference, alpha)) return;
  double best = alpha, at = alpha;
  for (int k = 0; k < kNearerTrials; ++k) {
    at = std::min(2.0 * best, 0.5 * (best + refused));
    const TrialEnergy nearer = objective.try_step(direction_, at);
    if (!nearer.feasible || !(nearer.difference < trial.difference)) {
      refused = at;
      continue;
    }
    best = at;
    trial = nearer;
    if (trial.difference > kUnbent * promised(best)) break;
  }
  if (at != best) objective.try_step(direction_, best);
  report_.last_step_length = best;
  report_.last_difference = trial.difference;
}

void NewtonSolver::relieve(Objective& objective) {
  progress_.held_steps = report_.last_bound < kHeld ? progress_.held_steps + 1 : 0;
  if (progress_.held_steps > 0 && progress_.held_steps % kReliefInterval == 0) objective.relieve();
}

bool NewtonSolver::take_unsure_step(Objective& objective) {
  if (progress_.unsure_steps_left == 0) return false;
  const double alpha = objective.bound_step(direction_, settings_.max_rotation);
  const TrialEnergy trial = objective.try_step(direction_, alpha);
  if (alpha < 1.0 || !trial.feasible) return false;
  if (!(trial.difference <= kUnsureRise * trial.magnitude) &&
      !(trial.difference <= objective.energy_rounding(hessian_)))
    return false;
  --progress_.unsure_steps_left;
  objective.accept_trial();
  report_.last_step_length = alpha;
  report_.last_difference = trial.difference;
  return true;
}

// Without inertia nothing limits how far a step goes where nothing resists, as in a sheet without stress, and
// energies do not, while prescribed parts move. Where moving these alone costs less energy, all else follows
// from there.
bool NewtonSolver::moves_prescribed_alone(Objective& objective) {
  const double alpha = objective.bound_step(direction_, settings_.max_rotation);
  const TrialEnergy together = objective.try_step(direction_, alpha);
  const std::vector<double> none(direction_.size(), 0.0);
  if (objective.bound_step(none, settings_.max_rotation) < 1.0) return false;
  const TrialEnergy alone = objective.try_step(none, 1.0);
  if (!alone.feasible || (together.feasible && together.difference <= alone.difference)) return false;
  objective.accept_trial();
  report_.last_step_length = 1.0;
  report_.last_difference = alone.difference;
  return true;
}

}  // namespace stark
