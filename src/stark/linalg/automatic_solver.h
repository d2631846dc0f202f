// The choice between the solvers, by modelled costs from counts of flops, bytes and iterations, never from
// clocks, so that a run repeats bit for bit. Phase: linear solve of a Newton step.
#pragma once

#include <stark/linalg/direct_solver.h>
#include <stark/linalg/pcg_solver.h>

namespace stark {

/// "automatic": steps start with conjugate gradients where those could win, and go on with a factorisation,
/// in single precision where it is large, once they need too many iterations.
class AutomaticSolver final : public LinearSolver {
 public:
  AutomaticSolver(const LinearSettings& settings, ThreadPool& pool);

  void prepare(const BlockPattern& pattern, std::span<const uint8_t> in_solid) override;
  void begin_step() override;
  const Cholesky<double>& cholesky() const { return direct_.in_double().cholesky(); }

 protected:
  LinearSolveReport solve_system(const LinearSystem& system, std::span<double> x) override;
  LinearSolveReport solve_kept(const LinearSystem& system, std::span<double> x) override;

 private:
  void choose(const BlockMatrix& matrix);

  PcgSolver pcg_;
  CholeskyFloatSolver direct_;
  int max_iterations_;
  // What steps start with and when they change; all follow from prepare(), never from earlier steps, so that
  // a resumed run continues bit for bit.
  bool starts_with_pcg_ = false;
  bool may_sweep_ = false;        ///< starts with pcg where sweeps precondition it
  double break_even_ = 0.0;       ///< iterations of conjugate gradients that cost as much as a factorisation
  double most_on_average_ = 0.0;  ///< iterations a solve of a step, before a factorisation is tried
  int solves_ = 0, iterations_ = 0;  ///< of conjugate gradients in this step
  LinearSolver* start_direct_;
  LinearSolver* current_ = nullptr;  ///< what the next solve will use; none before the first of a step
  LinearSolver* last_used_;          ///< what has the factor or preconditioner of the last solve
};

}  // namespace stark
