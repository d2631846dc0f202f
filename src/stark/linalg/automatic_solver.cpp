#include <stark/linalg/automatic_solver.h>

#include <algorithm>

namespace stark {

namespace {

// Rates of the cost model, in the round numbers of one core of 2020-2025. Only their ratio matters; a choice
// must not depend on the machine, or runs would not repeat elsewhere.
constexpr double kFlopsPerSecond = 20e9;
constexpr double kBytesPerSecond = 12e9;
// With a coarse space conjugate gradients pay for solids whose factorisation takes more than so many flops,
// some milliseconds. For cloth they do not: it takes about 100 iterations, and steps of Newton's method grow
// in number by a tenth.
constexpr double kSolidFlops = 6e7;
// Where sweeps precondition them, they pay from this on.
constexpr double kSweptFlops = 1e6;
// Without a coarse space they pay where a factorisation costs so many iterations.
constexpr double kProbeMinIterations = 150;
// Above, single precision with refinement is faster than double.
constexpr double kFloatFlops = 2e7;
// Conjugate gradients give up where one solve has cost a few factorisations, or all of the step on average
// more than one: the model is no better than that for systems of which all is in the cache.
constexpr double kPatience = 3.0, kPatienceOnAverage = 1.5;
constexpr double kLeastBreakEven = 80.0;
// Those with sweeps give up earlier: the model is right for them.
constexpr double kSweptPatience = 2.0, kSweptPatienceOnAverage = 1.0;

}  // namespace

AutomaticSolver::AutomaticSolver(const LinearSettings& settings, ThreadPool& pool)
    : pcg_(settings, pool),
      direct_(settings, pool),
      max_iterations_(settings.pcg_max_iterations),
      start_direct_(&direct_.in_double()),
      last_used_(start_direct_) {}

void AutomaticSolver::prepare(const BlockPattern& pattern, std::span<const uint8_t> in_solid) {
  if (pattern.block_count == 0) return;
  pcg_.prepare(pattern, in_solid);
  direct_.in_double().analyze(pattern);
  const double n = pattern.block_count, off_diagonal = static_cast<double>(pattern.slot_count()) - n;
  const double flops = cholesky().flops();
  // A factor is written, read by its parents, and read twice by the triangular solves; an iteration reads
  // every block in single precision and its index, two diagonal blocks, and passes over about ten vectors.
  const double direct_cost = flops / kFlopsPerSecond +
                             4.0 * 8.0 * static_cast<double>(cholesky().factor_nonzeros()) / kBytesPerSecond;
  const double iteration_cost = (2.0 * off_diagonal * 40.0 + n * (144.0 + 10.0 * 24.0)) / kBytesPerSecond;
  const double break_even = direct_cost / iteration_cost;
  if (flops > kFloatFlops)
    start_direct_ = &direct_;
  else
    start_direct_ = &direct_.in_double();
  const bool is_solid = static_cast<double>(std::ranges::count(in_solid, 1)) > 0.5 * n;
  starts_with_pcg_ = break_even > kProbeMinIterations;
  if (pcg_.has_coarse_space()) starts_with_pcg_ = is_solid && flops > kSolidFlops;
  may_sweep_ = is_solid && flops > kSweptFlops;
  break_even_ = break_even;
}

// What the first system of a step says: whether conjugate gradients are worth a try, and for how long.
void AutomaticSolver::choose(const BlockMatrix& matrix) {
  const bool is_swept = may_sweep_ && pcg_.is_swept(matrix);
  current_ = is_swept || starts_with_pcg_ ? static_cast<LinearSolver*>(&pcg_) : start_direct_;
  const double break_even = is_swept ? break_even_ : std::max(break_even_, kLeastBreakEven);
  const double most = (is_swept ? kSweptPatience : kPatience) * break_even;
  pcg_.set_max_iterations(static_cast<int>(std::min(most, static_cast<double>(max_iterations_))));
  most_on_average_ = (is_swept ? kSweptPatienceOnAverage : kPatienceOnAverage) * break_even;
}

void AutomaticSolver::begin_step() {
  current_ = nullptr;
  solves_ = iterations_ = 0;
  pcg_.begin_step();
  direct_.begin_step();
}

LinearSolveReport AutomaticSolver::solve_system(const LinearSystem& system, std::span<double> x) {
  int iterations = 0;
  if (current_ == nullptr) choose(system.A);
  if (current_ == &pcg_) {
    last_used_ = current_;
    const LinearSolveReport report = pcg_.solve(system, x);
    iterations_ += report.iterations;
    // A system that takes so many is ill-conditioned, and its solution of little use to Newton's method.
    const bool are_too_many = iterations_ > most_on_average_ * ++solves_;
    if (are_too_many) current_ = start_direct_;
    if ((report.ok && !are_too_many) || report.indefinite) return report;
    iterations = report.iterations;
    current_ = start_direct_;  // for the rest of the step
  }
  last_used_ = current_;
  LinearSolveReport report = current_->solve(system, x);
  report.iterations += iterations;
  // Too ill-conditioned for single precision: double for the rest of the step.
  if (report.ok && report.used == CholeskySolver::kName) current_ = &direct_.in_double();
  return report;
}

LinearSolveReport AutomaticSolver::solve_kept(const LinearSystem& system, std::span<double> x) {
  return last_used_->solve_again(system, x);
}

}  // namespace stark
