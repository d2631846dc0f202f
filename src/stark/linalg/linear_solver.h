// The seam of the linear solve of a Newton step: A x = b with A symmetric, on blocks of 3x3. Solvers
// implement LinearSolver and have a row in the registry, whose names are the values of the setting
// linear.solver; a program may add its own. A solver must give the same bits for the same systems of a step,
// whatever the threads, the clock and earlier steps. Phase: linear solve of a Newton step.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <stark/base/math.h>
#include <stark/base/settings.h>
#include <stark/base/thread_pool.h>
#include <stark/linalg/block_matrix.h>

namespace stark {

struct LinearSettings {
#define STARK_SETTING(type, name, value, unit, rule, meaning) type name = value;
#include <stark/linalg/linear_settings.inc>
#undef STARK_SETTING
  static const FieldTable& fields();
};

/// What is asked of a solver: A x = b.
struct LinearSystem {
  const BlockMatrix& A;
  std::span<const double> b;          ///< [3 block_count]
  double tolerance = 1e-4;            ///< relative residual that is good enough; direct solvers may ignore it
  std::span<const Vec3> positions{};  ///< [block_count] of the unknowns [m], for orderings; may be empty
  bool may_be_indefinite = false;     ///< then an early "not positive definite" beats certainty
};

struct LinearSolveReport {
  bool ok = false;            ///< x solves the system to the tolerance of the solver used
  bool indefinite = false;    ///< A is not positive definite
  int32_t failed_block = -1;  ///< where that was seen, -1 if unknown
  int iterations = 0;         ///< of conjugate gradients, including refinement
  int factorizations = 0;
  std::string_view used{};         ///< name of the solver that gave x
  double relative_residual = 0.0;  ///< |b - A x| / |b|; of pcg in the norm of the inverse preconditioner
};

class LinearSolver {
 public:
  virtual ~LinearSolver() = default;

  /// Solves A x = b, also where b is zero or empty.
  LinearSolveReport solve(const LinearSystem& system, std::span<double> x);

  /// Solves A x = b once more with what the last solve() of A left, a factor or a preconditioner; to the
  /// relative residual of `system`, no smaller than what was asked then, where that takes iterations. Not ok
  /// if the last solve() was not, or if the solver keeps nothing.
  LinearSolveReport solve_again(const LinearSystem& system, std::span<double> x);

  /// Told once for a simulation: the pattern without contact, and which blocks are nodes of solids,
  /// [block_count], may be empty.
  virtual void prepare(const BlockPattern&, std::span<const uint8_t> /*in_solid*/) {}

  /// Marks the start of a time step: what earlier steps taught must be forgotten, so that a resumed run
  /// continues bit for bit.
  virtual void begin_step() {}

 protected:
  virtual LinearSolveReport solve_system(const LinearSystem& system, std::span<double> x) = 0;
  virtual LinearSolveReport solve_kept(const LinearSystem&, std::span<double> /*x*/) { return {}; }

 private:
  bool has_solved_ = false;  ///< solve_kept() has something to go on
};

using MakeLinearSolver = std::function<std::unique_ptr<LinearSolver>(const LinearSettings&, ThreadPool&)>;

/// Adds a solver; `name` is then a value of linear.solver. Throws InvalidArgument for names that are empty or
/// taken. Safe while other threads make simulations.
void register_linear_solver(std::string name, MakeLinearSolver make);

/// Names of all solvers, those of Stark first.
std::vector<std::string> linear_solver_names();

/// The solver that the settings name. Throws InvalidSetting for an unknown one.
std::unique_ptr<LinearSolver> make_linear_solver(const LinearSettings& settings, ThreadPool& pool);

}  // namespace stark
