#include <stark/linalg/pcg_solver.h>

#include <algorithm>
#include <numeric>

#include <stark/linalg/screening_length.h>

namespace stark {

namespace {

constexpr double kFloatPcgTolerance = 1e-5;  // from there on matrices may be rounded to single precision
constexpr double kLargestTolerance = 0.5;
// Sweeps are for systems of which all is in the cache, as threads gain little on them. Beyond a few nodes,
// the coarse space gains more. Measured: half of the iterations at 3 nodes, equal times at 8 to 12.
constexpr int32_t kSweptBlocks = 8192;
constexpr double kSweptLength = 7.0;

}  // namespace

void PcgSolver::prepare(const BlockPattern& pattern, std::span<const uint8_t> /*in_solid*/) {
  coarse_.prepare(pattern);
  has_positions_ = false;
}

void PcgSolver::begin_step() {
  has_positions_ = false;
  is_swept_.reset();
}

bool PcgSolver::is_swept(const BlockMatrix& matrix) {
  if (!is_swept_)
    is_swept_ = matrix.pattern.block_count <= kSweptBlocks && find_screening_length(matrix) <= kSweptLength;
  return *is_swept_;
}

// Whether the coarse matrix is positive definite, true where there is none.
bool PcgSolver::use_coarse_space(const LinearSystem& system) {
  is_corrected_ = false;
  if (matrix_ != &jacobi_ || !coarse_.is_useful() || system.positions.empty()) return true;
  if (!has_positions_) {
    coarse_.set_positions(system.positions);
    has_positions_ = true;
  }
  is_corrected_ = coarse_.factor(system.A, pool_);
  return is_corrected_;
}

void PcgSolver::iterate(std::span<const double> b, double tolerance, std::span<double> x,
                        LinearSolveReport& report) {
  const PcgReport result = pcg_.solve(*matrix_, b, x, tolerance, max_iterations_, pool_);
  report.iterations += result.iterations;
  report.indefinite = result.indefinite;
  report.failed_block = result.failed_block;
  report.relative_residual = result.relative_residual;
  report.ok = result.converged;
}

// Whether the curvature of the last direction is negative in double.
bool PcgSolver::is_curved_down(const BlockMatrix& matrix) {
  std::vector<double> p(3 * static_cast<size_t>(matrix.pattern.block_count)), q(p.size());
  pcg_.get_direction(*matrix_, p, pool_);
  matrix.multiply(p.data(), q.data(), pool_);
  return std::inner_product(p.begin(), p.end(), q.begin(), 0.0) <= 0.0;
}

LinearSolveReport PcgSolver::solve_system(const LinearSystem& system, std::span<double> x) {
  LinearSolveReport report;
  report.used = kName;
  const double tolerance = std::clamp(system.tolerance, least_tolerance_, kLargestTolerance);
  matrix_ = is_swept(system.A) ? static_cast<PreconditionedMatrix*>(&gauss_seidel_) : &jacobi_;
  // Half of the bytes to read, where what is asked allows that; whether A is definite is for double to say.
  const bool in_float = tolerance >= kFloatPcgTolerance;
  if (!use_coarse_space(system) && system.may_be_indefinite) {
    report.indefinite = true;
    return report;
  }
  jacobi_.set_coarse_space(is_corrected_ ? &coarse_ : nullptr);
  matrix_->prepare(system.A, in_float ? PcgStorage::Float : PcgStorage::Double, pool_);
  iterate(system.b, tolerance, x, report);
  if (report.indefinite && in_float && report.failed_block < 0 && !is_curved_down(system.A)) {
    matrix_->prepare(system.A, PcgStorage::Double, pool_);
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
