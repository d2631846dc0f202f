// Choice of the linear solver, refinement, and the cost model behind LinearSolverKind::Automatic.
#include <stark/linalg/linear_solver.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <stark/base/error.h>
#include <stark/linalg/cholesky.h>
#include <stark/linalg/pcg.h>

namespace stark {

namespace {

// Rates of the cost model, in the round numbers of one core of 2020-2025. Only their ratio matters; a choice
// must not depend on the machine, or runs would not repeat elsewhere.
constexpr double kFlopsPerSecond = 30e9;
constexpr double kBytesPerSecond = 12e9;
// No conjugate gradients where direct costs less than this many: cloth never pays, soft solids do from there
// on.
constexpr double kProbeMinIterations = 150;
// Above, single precision with refinement is faster than double.
constexpr double kFloatFlops = 2e7;
constexpr int kLeastIterationCap = 50;

constexpr double kRefinementTolerance = 1e-10;  // relative residual asked of factors in double
// The same of factors in single precision, in fewer solves: far below what a step of Newton's method is
// worth.
constexpr double kFloatTolerance = 1e-6;
constexpr double kFloatPcgTolerance = 1e-5;  // from there on matrices may be rounded to single precision
constexpr int kFloatRefinements = 30;
constexpr int kDoubleRefinements = 3;
constexpr double kAcceptableResidual = 1e-6;  // a direct solve worse than this is a failure

double dot(const std::vector<double>& a, std::span<const double> b) {
  double sum = 0.0;
  for (size_t k = 0; k < a.size(); ++k) sum += a[k] * b[k];
  return sum;
}

double norm(std::span<const double> a) {
  double sum = 0.0;
  for (double value : a) sum += value * value;
  return std::sqrt(sum);
}

// A factor with the pattern it was analysed for.
template <typename Real>
struct Factor {
  Cholesky<Real> cholesky;
  uint64_t hash = 0;
  bool analyzed = false;

  bool first_of_step = false;

  void update(const BlockPattern& pattern, uint64_t pattern_hash, std::span<const Vec3> positions) {
    const bool first = first_of_step;
    const bool own_ordering = !first || cholesky.ordered_pattern() == pattern_hash;
    first_of_step = false;
    if (analyzed && hash == pattern_hash && own_ordering) {
      if (first) cholesky.keep_analysis();
      return;
    }
    cholesky.analyze(pattern, positions);
    hash = pattern_hash;
    analyzed = true;
  }

  // The ordering of a step follows from the patterns of that step alone.
  void begin_step() {
    first_of_step = true;
    cholesky.begin_sequence();
  }
};

}  // namespace

struct LinearSolver::Implementation {
  Implementation(const LinearSolverSettings& the_settings, ThreadPool& the_pool)
      : settings(the_settings), pool(the_pool) {
    current = settings.kind == LinearSolverKind::Automatic ? LinearSolverKind::Cholesky : settings.kind;
  }

  LinearSolverSettings settings;
  ThreadPool& pool;
  LinearSolverKind current;
  LinearSolverKind last_used = LinearSolverKind::Automatic;  ///< Automatic: nothing to solve with again
  Factor<double> factor;
  Factor<float> factor_float;
  Pcg pcg;
  std::vector<double> r, z, p, q;

  // Automatic choice: conjugate gradients start a step if they could win, with this many iterations at most.
  // Both follow from prepare(), never from earlier steps, so that a resumed run continues bit for bit.
  bool starts_with_pcg = false;
  LinearSolverKind direct_kind = LinearSolverKind::Cholesky;
  int iteration_cap = kLeastIterationCap;

  bool solve_direct(const BlockMatrix& A, uint64_t hash, std::span<const double> b, std::span<double> x,
                    std::span<const Vec3> positions, LinearSolveReport& report);
  bool solve_float(const BlockMatrix& A, uint64_t hash, std::span<const double> b, std::span<double> x,
                   double tolerance, std::span<const Vec3> positions, LinearSolveReport& report);
  bool refine_float(const BlockMatrix& A, std::span<const double> b, std::span<double> x, double tolerance,
                    LinearSolveReport& report);
  bool iterate_pcg(std::span<const double> b, std::span<double> x, double tolerance,
                   LinearSolveReport& report);
  LinearSolveReport solve(const BlockMatrix& A, std::span<const double> b, std::span<double> x,
                          double forcing_tolerance, std::span<const Vec3> positions, bool may_be_indefinite);
  double residual(const BlockMatrix& A, std::span<const double> b, std::span<const double> x);
};

double LinearSolver::Implementation::residual(const BlockMatrix& A, std::span<const double> b,
                                              std::span<const double> x) {
  r.resize(b.size());
  A.multiply(x.data(), r.data(), pool);
  for (size_t k = 0; k < r.size(); ++k) r[k] = b[k] - r[k];
  const double scale = norm(b), value = norm(r);
  return value == 0.0 ? 0.0 : value / scale;
}

bool LinearSolver::Implementation::solve_direct(const BlockMatrix& A, uint64_t hash,
                                                std::span<const double> b, std::span<double> x,
                                                std::span<const Vec3> positions, LinearSolveReport& report) {
  report.used = LinearSolverKind::Cholesky;
  factor.update(A.pattern, hash, positions);
  ++report.factorizations;
  const FactorStatus status = factor.cholesky.factor(A, pool);
  if (!status.positive_definite) {
    report.indefinite = true;
    report.failed_block = status.failed_block;
    return false;
  }
  factor.cholesky.solve(b.data(), x.data(), pool);
  report.relative_residual = residual(A, b, x);
  for (int k = 0; k < kDoubleRefinements && report.relative_residual > kRefinementTolerance; ++k) {
    z.resize(b.size());
    p.assign(x.begin(), x.end());
    factor.cholesky.solve(r.data(), z.data(), pool);
    for (size_t i = 0; i < z.size(); ++i) x[i] += z[i];
    const double improved = residual(A, b, x);
    if (!(improved < report.relative_residual)) {
      std::copy(p.begin(), p.end(), x.begin());
      break;
    }
    report.relative_residual = improved;
  }
  report.ok = report.relative_residual < kAcceptableResidual;
  report.indefinite = false;
  report.failed_block = -1;
  return report.ok;
}

// Conjugate gradients in double, preconditioned by the factor in single precision. False if it gives up.
bool LinearSolver::Implementation::refine_float(const BlockMatrix& A, std::span<const double> b,
                                                std::span<double> x, double tolerance,
                                                LinearSolveReport& report) {
  const size_t size = b.size();
  const double b_norm = norm(b);
  r.assign(b.begin(), b.end());
  z.resize(size);
  p.assign(size, 0.0);
  q.resize(size);
  std::fill(x.begin(), x.end(), 0.0);
  double rz = 0.0;
  for (int k = 0; k < kFloatRefinements; ++k) {
    if (norm(r) <= tolerance * b_norm) break;
    factor_float.cholesky.solve(r.data(), z.data(), pool);
    const double rz_next = dot(r, z);
    if (!(rz_next > 0.0)) return false;
    const double beta = k == 0 ? 0.0 : rz_next / rz;
    rz = rz_next;
    for (size_t i = 0; i < size; ++i) p[i] = z[i] + beta * p[i];
    A.multiply(p.data(), q.data(), pool);
    const double pq = dot(p, q);
    if (!(pq > 0.0)) return false;
    const double alpha = rz / pq;
    for (size_t i = 0; i < size; ++i) x[i] += alpha * p[i], r[i] -= alpha * q[i];
    ++report.iterations;
  }
  return true;
}

// False if single precision does not do, and double precision may decide.
bool LinearSolver::Implementation::solve_float(const BlockMatrix& A, uint64_t hash, std::span<const double> b,
                                               std::span<double> x, double tolerance,
                                               std::span<const Vec3> positions, LinearSolveReport& report) {
  report.used = LinearSolverKind::CholeskyFloat;
  factor_float.update(A.pattern, hash, positions);
  ++report.factorizations;
  const FactorStatus status = factor_float.cholesky.factor(A, pool);
  report.indefinite = !status.positive_definite;
  report.failed_block = status.failed_block;
  if (report.indefinite) return false;
  if (!refine_float(A, b, x, 0.5 * tolerance, report)) return false;
  report.relative_residual = residual(A, b, x);
  report.ok = report.relative_residual <= tolerance;
  return report.ok;
}

bool LinearSolver::Implementation::iterate_pcg(std::span<const double> b, std::span<double> x,
                                               double tolerance, LinearSolveReport& report) {
  const bool automatic = settings.kind == LinearSolverKind::Automatic;
  const int limit = automatic ? iteration_cap : settings.pcg_max_iterations;
  const PcgReport result = pcg.solve(b, x, tolerance, limit, pool);
  report.iterations += result.iterations;
  report.indefinite = result.indefinite;
  report.failed_block = result.failed_block;
  report.relative_residual = result.relative_residual;
  report.ok = result.converged;
  return result.converged;
}

LinearSolver::LinearSolver(LinearSolverSettings settings, ThreadPool& pool) {
  if (!(settings.pcg_tolerance > 0.0 && settings.pcg_tolerance < 1.0))
    throw InvalidSetting("linear solver: pcg_tolerance is " + std::to_string(settings.pcg_tolerance) +
                         ", a relative residual must lie between 0 and 1; try 1e-4");
  if (settings.pcg_max_iterations < 1)
    throw InvalidSetting("linear solver: pcg_max_iterations is " +
                         std::to_string(settings.pcg_max_iterations) + ", it must be at least 1; try 10000");
  implementation_ = std::make_unique<Implementation>(settings, pool);
}

LinearSolver::~LinearSolver() = default;
LinearSolver::LinearSolver(LinearSolver&&) noexcept = default;

LinearSolveReport LinearSolver::solve(const BlockMatrix& A, std::span<const double> b, std::span<double> x,
                                      double forcing_tolerance, std::span<const Vec3> positions,
                                      bool may_be_indefinite) {
  Implementation& s = *implementation_;
  const LinearSolveReport report = s.solve(A, b, x, forcing_tolerance, positions, may_be_indefinite);
  s.last_used = report.ok ? report.used : LinearSolverKind::Automatic;
  return report;
}

LinearSolveReport LinearSolver::Implementation::solve(const BlockMatrix& A, std::span<const double> b,
                                                      std::span<double> x, double forcing_tolerance,
                                                      std::span<const Vec3> positions,
                                                      bool may_be_indefinite) {
  const size_t size = 3 * static_cast<size_t>(A.pattern.block_count);
  STARK_CHECK(b.size() == size && x.size() == size && A.values.size() == 9 * A.pattern.column.size());
  LinearSolveReport report;
  report.used = current;
  if (size == 0) {
    report.ok = true;
    return report;
  }
  const uint64_t hash = A.pattern.hash();
  const bool automatic = settings.kind == LinearSolverKind::Automatic;
  if (current == LinearSolverKind::Pcg) {
    const double tolerance = std::clamp(forcing_tolerance, settings.pcg_tolerance, 0.5);
    report.used = LinearSolverKind::Pcg;
    // Half of the bytes to read, where what is asked allows that; whether A is definite is for double to say.
    const bool in_float = tolerance >= kFloatPcgTolerance;
    pcg.prepare(A, pool, in_float ? PcgStorage::Float : PcgStorage::Double);
    bool solved = iterate_pcg(b, x, tolerance, report);
    if (report.indefinite && in_float) {
      pcg.prepare(A, pool);
      solved = iterate_pcg(b, x, tolerance, report);
    }
    if (solved || report.indefinite || !automatic) return report;
    current = direct_kind;  // for the rest of the step
  }
  const bool try_float = current == LinearSolverKind::CholeskyFloat;
  const double float_tolerance = std::clamp(forcing_tolerance, kRefinementTolerance, kFloatTolerance);
  if (try_float && solve_float(A, hash, b, x, float_tolerance, positions, report)) return report;
  if (try_float && report.indefinite && may_be_indefinite) return report;
  const bool solved = solve_direct(A, hash, b, x, positions, report);
  // Too ill-conditioned for single precision: double for the rest of the step.
  if (try_float && solved && automatic) current = LinearSolverKind::Cholesky;
  return report;
}

LinearSolveReport LinearSolver::solve_again(const BlockMatrix& A, std::span<const double> b,
                                            std::span<double> x, double tolerance) {
  Implementation& s = *implementation_;
  LinearSolveReport report;
  report.used = s.last_used;
  switch (s.last_used) {
    case LinearSolverKind::Automatic:
      report.ok = b.empty();
      break;
    case LinearSolverKind::Cholesky:
      s.factor.cholesky.solve(b.data(), x.data(), s.pool);
      report.ok = true;
      break;
    case LinearSolverKind::CholeskyFloat:
      report.ok = s.refine_float(A, b, x, tolerance, report);
      break;
    case LinearSolverKind::Pcg:
      report.ok = s.iterate_pcg(b, x, tolerance, report);
      break;
  }
  return report;
}

void LinearSolver::prepare(const BlockPattern& pattern, std::span<const Vec3> positions) {
  Implementation& s = *implementation_;
  if (s.settings.kind != LinearSolverKind::Automatic || pattern.block_count == 0) return;
  s.factor.update(pattern, pattern.hash(), positions);
  const double n = pattern.block_count, off_diagonal = static_cast<double>(pattern.slot_count()) - n;
  // A factor is written, read by its parents, and read twice by the triangular solves; an iteration reads
  // every block and its index, and passes over about ten vectors.
  const double direct_cost =
      s.factor.cholesky.flops() / kFlopsPerSecond +
      4.0 * 8.0 * static_cast<double>(s.factor.cholesky.factor_nonzeros()) / kBytesPerSecond;
  const double iteration_cost = ((2.0 * off_diagonal + n) * 76.0 + 10.0 * 24.0 * n) / kBytesPerSecond;
  const double break_even = direct_cost / iteration_cost;
  s.direct_kind =
      s.factor.cholesky.flops() > kFloatFlops ? LinearSolverKind::CholeskyFloat : LinearSolverKind::Cholesky;
  s.starts_with_pcg = break_even > kProbeMinIterations;
  s.iteration_cap = static_cast<int>(std::clamp(break_even, static_cast<double>(kLeastIterationCap),
                                                static_cast<double>(s.settings.pcg_max_iterations)));
}

void LinearSolver::begin_step() {
  Implementation& s = *implementation_;
  if (s.settings.kind == LinearSolverKind::Automatic)
    s.current = s.starts_with_pcg ? LinearSolverKind::Pcg : s.direct_kind;
  s.factor.begin_step();
  s.factor_float.begin_step();
}

const LinearSolverSettings& LinearSolver::settings() const { return implementation_->settings; }
LinearSolverKind LinearSolver::current_kind() const { return implementation_->current; }
double LinearSolver::factor_flops() const {
  const Implementation& s = *implementation_;
  return s.factor.analyzed         ? s.factor.cholesky.flops()
         : s.factor_float.analyzed ? s.factor_float.cholesky.flops()
                                   : 0.0;
}
int64_t LinearSolver::factor_nonzeros() const {
  const Implementation& s = *implementation_;
  if (s.factor.analyzed) return s.factor.cholesky.factor_nonzeros();
  return s.factor_float.analyzed ? s.factor_float.cholesky.factor_nonzeros() : 0;
}
int64_t LinearSolver::ordering_count() const {
  return implementation_->factor.cholesky.ordering_count() +
         implementation_->factor_float.cholesky.ordering_count();
}
int64_t LinearSolver::analysis_count() const {
  return implementation_->factor.cholesky.analysis_count() +
         implementation_->factor_float.cholesky.analysis_count();
}

}  // namespace stark
