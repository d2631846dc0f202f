// Conjugate gradients as a linear solver. Phase: linear solve of a Newton step.
#pragma once

#include <optional>

#include <stark/linalg/coarse_space.h>
#include <stark/linalg/gauss_seidel_matrix.h>
#include <stark/linalg/jacobi_matrix.h>
#include <stark/linalg/linear_solver.h>
#include <stark/linalg/pcg.h>

namespace stark {

/// "pcg": to the tolerance that is asked, no less than LinearSettings::pcg_tolerance. Systems of some
/// thousand blocks are preconditioned by symmetric Gauss-Seidel, larger ones by block-Jacobi and, for large
/// connected parts of the pattern without contact, a coarse space, with clusters from the positions in the
/// first solve of a step.
class PcgSolver final : public LinearSolver {
 public:
  static constexpr std::string_view kName = "pcg";
  PcgSolver(const LinearSettings& settings, ThreadPool& pool)
      : pool_(pool), least_tolerance_(settings.pcg_tolerance), max_iterations_(settings.pcg_max_iterations) {}

  void set_max_iterations(int count) { max_iterations_ = count; }
  bool has_coarse_space() const { return coarse_.is_useful(); }
  void prepare(const BlockPattern& pattern, std::span<const uint8_t> in_solid) override;
  void begin_step() override;

  /// Whether the systems of this step are preconditioned by sweeps, by the first of them.
  bool is_swept(const BlockMatrix& matrix);

 protected:
  LinearSolveReport solve_system(const LinearSystem& system, std::span<double> x) override;
  LinearSolveReport solve_kept(const LinearSystem& system, std::span<double> x) override;

 private:
  bool use_coarse_space(const LinearSystem& system);
  bool is_curved_down(const BlockMatrix& matrix);
  void iterate(std::span<const double> b, double tolerance, std::span<double> x, LinearSolveReport& report);

  ThreadPool& pool_;
  double least_tolerance_;
  int max_iterations_;
  Pcg pcg_;
  GaussSeidelMatrix gauss_seidel_;
  JacobiMatrix jacobi_;
  PreconditionedMatrix* matrix_ = &jacobi_;
  std::optional<bool> is_swept_;
  CoarseSpace coarse_;
  bool has_positions_ = false;  ///< of this step, in coarse_
  bool is_corrected_ = false;   ///< coarse_ has a factor of the last system
};

}  // namespace stark
