#include <stark/linalg/automatic_solver.h>

#include <algorithm>

namespace stark {

namespace {

// Rates of the cost model, in the round numbers of one core of 2020-2025. Only their ratio matters; a choice
// must not depend on the machine, or runs would not repeat elsewhere.
constexpr double kFlopsPerSecond = 30e9;
constexpr double kBytesPerSecond = 12e9;
// No conjugate gradients where direct costs less than so many: chains of rigid bodies, say. Without a coarse
// space only soft solids pay.
constexpr double kProbeMinCorrected = 20, kProbeMinPlain = 150;
// Above, single precision with refinement is faster than double.
constexpr double kFloatFlops = 2e7;
// Conjugate gradients give up where they have cost a few factorisations: the next system may need fewer.
constexpr double kPatience = 3.0;
constexpr double kLeastIterationCap = 100;

}  // namespace

AutomaticSolver::AutomaticSolver(const LinearSettings& settings, ThreadPool& pool)
    : pcg_(settings, pool),
      direct_(settings, pool),
      max_iterations_(settings.pcg_max_iterations),
      start_direct_(&direct_.in_double()),
      current_(start_direct_),
      last_used_(start_direct_) {}

void AutomaticSolver::prepare(const BlockPattern& pattern, std::span<const Vec3> positions) {
  if (pattern.block_count == 0) return;
  pcg_.prepare(pattern, positions);
  direct_.in_double().factor().update(pattern, positions);
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
  starts_with_pcg_ = break_even > (pcg_.has_coarse_space() ? kProbeMinCorrected : kProbeMinPlain);
  const double patience = std::max(kPatience * break_even, kLeastIterationCap);
  pcg_.set_max_iterations(static_cast<int>(std::min(patience, static_cast<double>(max_iterations_))));
}

void AutomaticSolver::begin_step() {
  current_ = starts_with_pcg_ ? static_cast<LinearSolver*>(&pcg_) : start_direct_;
  pcg_.begin_step();
  direct_.begin_step();
}

LinearSolveReport AutomaticSolver::solve_system(const LinearSystem& system, std::span<double> x) {
  int iterations = 0;
  if (current_ == &pcg_) {
    last_used_ = current_;
    const LinearSolveReport report = pcg_.solve(system, x);
    if (report.ok || report.indefinite) return report;
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
