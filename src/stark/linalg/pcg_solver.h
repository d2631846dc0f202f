// Conjugate gradients with block-Jacobi preconditioner as a linear solver. Phase: linear solve of a Newton
// step.
#pragma once

#include <stark/linalg/linear_solver.h>
#include <stark/linalg/pcg.h>

namespace stark {

/// "pcg": to the tolerance that is asked, no less than LinearSettings::pcg_tolerance.
class PcgSolver final : public LinearSolver {
 public:
  static constexpr std::string_view kName = "pcg";
  PcgSolver(const LinearSettings& settings, ThreadPool& pool)
      : pool_(pool), least_tolerance_(settings.pcg_tolerance), max_iterations_(settings.pcg_max_iterations) {}

  void set_max_iterations(int count) { max_iterations_ = count; }

 protected:
  LinearSolveReport solve_system(const LinearSystem& system, std::span<double> x) override;
  LinearSolveReport solve_kept(const LinearSystem& system, std::span<double> x) override;

 private:
  void iterate(std::span<const double> b, double tolerance, std::span<double> x, LinearSolveReport& report);

  ThreadPool& pool_;
  double least_tolerance_;
  int max_iterations_;
  Pcg pcg_;
};

}  // namespace stark
