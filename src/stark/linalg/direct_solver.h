// Supernodal Cholesky as a linear solver: factors in double with refinement, and factors in single precision
// that precondition conjugate gradients in double. Phase: linear solve of a Newton step.
#pragma once

#include <vector>

#include <stark/linalg/cholesky.h>
#include <stark/linalg/linear_solver.h>

namespace stark {

/// A Cholesky factor with the pattern that it was analysed for. Symbolic work is redone only when the pattern
/// changes; the ordering of a step follows from the patterns of that step alone.
template <typename Real>
class Factor {
 public:
  void update(const BlockPattern& pattern, ThreadPool& pool);
  void begin_step();

  Cholesky<Real>& cholesky() { return cholesky_; }
  const Cholesky<Real>& cholesky() const { return cholesky_; }

 private:
  Cholesky<Real> cholesky_;
  uint64_t hash_ = 0;
  bool is_analyzed_ = false;
  bool is_first_of_step_ = false;
};

/// "cholesky": factors in double; ignores the tolerance.
class CholeskySolver final : public LinearSolver {
 public:
  static constexpr std::string_view kName = "cholesky";
  CholeskySolver(const LinearSettings&, ThreadPool& pool) : pool_(pool) {}

  void begin_step() override { factor_.begin_step(); }
  void analyze(const BlockPattern& pattern) { factor_.update(pattern, pool_); }
  const Cholesky<double>& cholesky() const { return factor_.cholesky(); }

 protected:
  LinearSolveReport solve_system(const LinearSystem& system, std::span<double> x) override;
  LinearSolveReport solve_kept(const LinearSystem& system, std::span<double> x) override;

 private:
  double residual(const LinearSystem& system, std::span<const double> x);

  ThreadPool& pool_;
  Factor<double> factor_;
  std::vector<double> rest_, correction_, best_;
};

/// "cholesky_float": factors in single precision and conjugate gradients in double, to the tolerance but at
/// least 1e-6; where that does not do, as "cholesky". Where the matrix may be indefinite, a pivot that is not
/// positive in single precision is taken at its word.
class CholeskyFloatSolver final : public LinearSolver {
 public:
  static constexpr std::string_view kName = "cholesky_float";
  CholeskyFloatSolver(const LinearSettings& settings, ThreadPool& pool)
      : pool_(pool), in_double_(settings, pool) {}

  void begin_step() override;
  CholeskySolver& in_double() { return in_double_; }
  const CholeskySolver& in_double() const { return in_double_; }

 protected:
  LinearSolveReport solve_system(const LinearSystem& system, std::span<double> x) override;
  LinearSolveReport solve_kept(const LinearSystem& system, std::span<double> x) override;

 private:
  LinearSolveReport solve_float(const LinearSystem& system, std::span<double> x);
  bool refine(const LinearSystem& system, double tolerance, std::span<double> x, LinearSolveReport& report);

  ThreadPool& pool_;
  Factor<float> factor_;
  CholeskySolver in_double_;
  bool used_double_ = false;
  std::vector<double> r_, z_, p_, q_;
};

}  // namespace stark
