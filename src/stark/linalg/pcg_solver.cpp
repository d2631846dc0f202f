#include <stark/linalg/pcg_solver.h>

#include <algorithm>

namespace stark {

namespace {

constexpr double kFloatPcgTolerance = 1e-5;  // from there on matrices may be rounded to single precision
constexpr double kLargestTolerance = 0.5;

}  // namespace

void PcgSolver::iterate(std::span<const double> b, double tolerance, std::span<double> x,
                        LinearSolveReport& report) {
  const PcgReport result = pcg_.solve(b, x, tolerance, max_iterations_, pool_);
  report.iterations += result.iterations;
  report.indefinite = result.indefinite;
  report.failed_block = result.failed_block;
  report.relative_residual = result.relative_residual;
  report.ok = result.converged;
}

LinearSolveReport PcgSolver::solve_system(const LinearSystem& system, std::span<double> x) {
  LinearSolveReport report;
  report.used = kName;
  const double tolerance = std::clamp(system.tolerance, least_tolerance_, kLargestTolerance);
  // Half of the bytes to read, where what is asked allows that; whether A is definite is for double to say.
  const bool in_float = tolerance >= kFloatPcgTolerance;
  pcg_.prepare(system.A, pool_, in_float ? PcgStorage::Float : PcgStorage::Double);
  iterate(system.b, tolerance, x, report);
  if (report.indefinite && in_float) {
    pcg_.prepare(system.A, pool_);
    iterate(system.b, tolerance, x, report);
  }
  return report;
}

LinearSolveReport PcgSolver::solve_kept(const LinearSystem& system, std::span<double> x) {
  LinearSolveReport report;
  report.used = kName;
  iterate(system.b, system.tolerance, x, report);
  return report;
}

}  // namespace stark
