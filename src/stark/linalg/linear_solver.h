// The linear solve of a Newton step: A x = b with A symmetric, on blocks of 3x3. Chooses between the
// supernodal Cholesky factorisation (in double, or in single precision with refinement) and preconditioned
// conjugate gradients. The automatic choice compares modelled costs, from counts of flops, bytes and
// iterations, never from clocks, so that a run repeats bit for bit. Phase: linear solve of a Newton step.
#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include <stark/base/math.h>
#include <stark/base/thread_pool.h>
#include <stark/linalg/block_matrix.h>

namespace stark {

enum class LinearSolverKind : uint8_t {
  Automatic,
  Cholesky,
  CholeskyFloat,  // factor in single precision, conjugate gradients in double to 1e-6 or what is asked;
                  // falls back to Cholesky
  Pcg
};

struct LinearSolverSettings {
  LinearSolverKind kind = LinearSolverKind::Automatic;
  double pcg_tolerance =
      1e-4;  // least relative residual of conjugate gradients, whatever the forcing tolerance
  int pcg_max_iterations = 10000;
};

struct LinearSolveReport {
  bool ok = false;            // x solves the system to the tolerance of the solver used
  bool indefinite = false;    // A is not positive definite
  int32_t failed_block = -1;  // where that was seen, -1 if unknown
  int iterations = 0;         // of conjugate gradients, including refinement
  int factorizations = 0;
  LinearSolverKind used = LinearSolverKind::Automatic;
  double relative_residual = 0.0;  // |b - A x| / |b|; for Pcg in the norm of the inverse preconditioner
};

class LinearSolver {
 public:
  LinearSolver(LinearSolverSettings settings, ThreadPool& pool);
  ~LinearSolver();
  LinearSolver(LinearSolver&&) noexcept;

  /// Solves A x = b. `forcing_tolerance` is the relative residual asked of conjugate gradients; factors in
  /// double precision ignore it. `positions` [block_count] may be empty. Symbolic work is redone only when
  /// the pattern of A changes. Where A may be indefinite, a pivot that is not positive in single precision is
  /// taken at its word, and double precision is not asked.
  LinearSolveReport solve(const BlockMatrix& A, std::span<const double> b, std::span<double> x,
                          double forcing_tolerance, std::span<const Vec3> positions = {},
                          bool may_be_indefinite = false);

  /// Solves A x = b once more with the factor or the preconditioner of the last solve(), which A was given to
  /// and succeeded; to the relative residual `tolerance`, no smaller than what was asked then, where that
  /// takes iterations.
  LinearSolveReport solve_again(const BlockMatrix& A, std::span<const double> b, std::span<double> x,
                                double tolerance);

  /// Bases the automatic choice on the pattern without contact, once for a simulation: modelled costs of a
  /// direct solve and of an iteration say whether steps start with conjugate gradients and when those give
  /// up.
  void prepare(const BlockPattern& pattern, std::span<const Vec3> positions = {});

  /// Marks the start of a time step and forgets what earlier steps taught: within a step the solver may go
  /// from conjugate gradients to Cholesky, and keeps its ordering; a step depends on its own systems only.
  void begin_step();

  const LinearSolverSettings& settings() const;
  LinearSolverKind current_kind() const;  // what the next solve will use
  double factor_flops() const;            // of the last analysis, 0 before
  int64_t factor_nonzeros() const;
  int64_t ordering_count() const;
  int64_t analysis_count() const;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace stark
