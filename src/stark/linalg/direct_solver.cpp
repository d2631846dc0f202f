#include <stark/linalg/direct_solver.h>

#include <algorithm>
#include <cmath>

namespace stark {

namespace {

constexpr double kRefinementTolerance = 1e-10;  // relative residual asked of factors in double
// The same of factors in single precision, in fewer solves: what a step of Newton's method is worth.
constexpr double kFloatTolerance = 1e-4;
constexpr int kFloatRefinements = 30;
constexpr int kDoubleRefinements = 3;
constexpr double kAcceptableResidual = 1e-6;  // a direct solve worse than this is a failure

double dot(std::span<const double> a, std::span<const double> b) {
  double sum = 0.0;
  for (size_t k = 0; k < a.size(); ++k) sum += a[k] * b[k];
  return sum;
}

double norm(std::span<const double> a) {
  double sum = 0.0;
  for (double value : a) sum += value * value;
  return std::sqrt(sum);
}

/// |b - A x| / |b|; `rest` becomes b - A x.
double relative_residual(const LinearSystem& system, std::span<const double> x, ThreadPool& pool,
                         std::vector<double>& rest) {
  rest.resize(system.b.size());
  system.A.multiply(x.data(), rest.data(), pool);
  for (size_t k = 0; k < rest.size(); ++k) rest[k] = system.b[k] - rest[k];
  const double scale = norm(system.b), value = norm(rest);
  return value == 0.0 ? 0.0 : value / scale;
}

}  // namespace

template <typename Real>
void Factor<Real>::update(const BlockPattern& pattern, ThreadPool& pool) {
  const uint64_t hash = pattern.hash();
  const bool first = is_first_of_step_;
  const bool own_ordering = !first || cholesky_.ordered_pattern() == hash;
  is_first_of_step_ = false;
  if (is_analyzed_ && hash_ == hash && own_ordering) {
    if (first) cholesky_.keep_analysis();
    return;
  }
  cholesky_.analyze(pattern, pool);
  hash_ = hash;
  is_analyzed_ = true;
}

template <typename Real>
void Factor<Real>::begin_step() {
  is_first_of_step_ = true;
  cholesky_.begin_sequence();
}

template class Factor<double>;
template class Factor<float>;

double CholeskySolver::residual(const LinearSystem& system, std::span<const double> x) {
  return relative_residual(system, x, pool_, rest_);
}

LinearSolveReport CholeskySolver::solve_system(const LinearSystem& system, std::span<double> x) {
  LinearSolveReport report;
  report.used = kName;
  factor_.update(system.A.pattern, pool_);
  report.factorizations = 1;
  const FactorStatus status = factor_.cholesky().factor(system.A, pool_);
  if (!status.positive_definite) {
    report.indefinite = true;
    report.failed_block = status.failed_block;
    return report;
  }
  factor_.cholesky().solve(system.b.data(), x.data(), pool_);
  report.relative_residual = residual(system, x);
  for (int k = 0; k < kDoubleRefinements && report.relative_residual > kRefinementTolerance; ++k) {
    correction_.resize(x.size());
    best_.assign(x.begin(), x.end());
    factor_.cholesky().solve(rest_.data(), correction_.data(), pool_);
    for (size_t i = 0; i < x.size(); ++i) x[i] += correction_[i];
    const double improved = residual(system, x);
    if (!(improved < report.relative_residual)) {
      std::ranges::copy(best_, x.begin());
      break;
    }
    report.relative_residual = improved;
  }
  report.ok = report.relative_residual < kAcceptableResidual;
  return report;
}

LinearSolveReport CholeskySolver::solve_kept(const LinearSystem& system, std::span<double> x) {
  factor_.cholesky().solve(system.b.data(), x.data(), pool_);
  LinearSolveReport report;
  report.used = kName;
  report.ok = true;
  return report;
}

// Conjugate gradients in double, preconditioned by the factor in single precision. False if it gives up.
bool CholeskyFloatSolver::refine(const LinearSystem& system, double tolerance, std::span<double> x,
                                 LinearSolveReport& report) {
  const size_t size = system.b.size();
  const double b_norm = norm(system.b);
  r_.assign(system.b.begin(), system.b.end());
  z_.resize(size);
  p_.assign(size, 0.0);
  q_.resize(size);
  std::ranges::fill(x, 0.0);
  double rz = 0.0;
  for (int k = 0; k < kFloatRefinements; ++k) {
    if (norm(r_) <= tolerance * b_norm) break;
    factor_.cholesky().solve(r_.data(), z_.data(), pool_);
    const double rz_next = dot(r_, z_);
    if (!(rz_next > 0.0)) return false;
    const double beta = k == 0 ? 0.0 : rz_next / rz;
    rz = rz_next;
    for (size_t i = 0; i < size; ++i) p_[i] = z_[i] + beta * p_[i];
    system.A.multiply(p_.data(), q_.data(), pool_);
    const double pq = dot(p_, q_);
    if (!(pq > 0.0)) return false;
    const double alpha = rz / pq;
    for (size_t i = 0; i < size; ++i) x[i] += alpha * p_[i], r_[i] -= alpha * q_[i];
    ++report.iterations;
  }
  return true;
}

// Not ok if single precision does not do, and double precision may decide.
LinearSolveReport CholeskyFloatSolver::solve_float(const LinearSystem& system, std::span<double> x) {
  LinearSolveReport report;
  report.used = kName;
  factor_.update(system.A.pattern, pool_);
  report.factorizations = 1;
  const FactorStatus status = factor_.cholesky().factor(system.A, pool_);
  report.indefinite = !status.positive_definite;
  report.failed_block = status.failed_block;
  const double tolerance = std::clamp(system.tolerance, kRefinementTolerance, kFloatTolerance);
  if (report.indefinite || !refine(system, 0.5 * tolerance, x, report)) return report;
  report.relative_residual = relative_residual(system, x, pool_, q_);
  report.ok = report.relative_residual <= tolerance;
  return report;
}

LinearSolveReport CholeskyFloatSolver::solve_system(const LinearSystem& system, std::span<double> x) {
  const LinearSolveReport in_float = solve_float(system, x);
  used_double_ = !in_float.ok && !(in_float.indefinite && system.may_be_indefinite);
  if (!used_double_) return in_float;
  LinearSolveReport report = in_double_.solve(system, x);
  report.iterations += in_float.iterations;
  report.factorizations += in_float.factorizations;
  return report;
}

LinearSolveReport CholeskyFloatSolver::solve_kept(const LinearSystem& system, std::span<double> x) {
  if (used_double_) return in_double_.solve_again(system, x);
  LinearSolveReport report;
  report.used = kName;
  report.ok = refine(system, system.tolerance, x, report);
  return report;
}

void CholeskyFloatSolver::begin_step() {
  factor_.begin_step();
  in_double_.begin_step();
}

}  // namespace stark
