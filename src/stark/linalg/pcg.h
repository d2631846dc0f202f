// Conjugate gradients with block-Jacobi preconditioner, to which a coarse space may be added, on a block
// matrix (Hestenes and Stiefel 1952; Saad, Iterative Methods for Sparse Linear Systems, section 9.2). The
// upper triangle is expanded once per matrix so that a product reads every block once, row by row, and rows
// can be shared among threads. Dot products are summed over fixed blocks. Phase: linear solve of a Newton
// step.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <stark/base/aligned.h>
#include <stark/base/thread_pool.h>
#include <stark/linalg/block_matrix.h>
#include <stark/linalg/coarse_space.h>

namespace stark {

/// Precision in which the off-diagonal blocks are kept. Vectors and diagonal blocks are always double.
enum class PcgStorage : uint8_t { Double, Float };

struct PcgReport {
  bool converged = false;
  bool indefinite = false;    // p^T A p <= 0 was met, or a diagonal block is not positive definite
  int32_t failed_block = -1;  // the first block row whose diagonal block is not positive definite
  int iterations = 0;
  double relative_residual = 1.0;  // |b - A x| / |b| in the norm of the inverse preconditioner, as recurred
};

class Pcg {
 public:
  /// Copies `matrix` into the expanded form. Structure is redone only if the pattern changed. False if a
  /// diagonal block is not positive definite.
  bool prepare(const BlockMatrix& matrix, ThreadPool& pool, PcgStorage storage = PcgStorage::Double);

  /// Solves A x = b from x = 0 until the residual, in the norm of the inverse preconditioner, falls below
  /// `tolerance` times that of b, and what k iterations like the last, the k-th, would lower the quadratic
  /// model x^T A x / 2 - b^T x by is below tolerance^2 of what all have [Nash and Sofer 1990]: residuals say
  /// little of soft modes. On indefiniteness x holds the last iterate, which is still a descent
  /// direction (b^T x > 0) unless it is the first iteration, where x is the preconditioned b. `coarse`, if
  /// given, has a factor of A and corrects the preconditioner.
  PcgReport solve(std::span<const double> b, std::span<double> x, double tolerance, int max_iterations,
                  ThreadPool& pool, CoarseSpace* coarse = nullptr);

  /// y = A x with the expanded form.
  void multiply(const double* x, double* y, ThreadPool& pool) const;

 private:
  void expand_structure(const BlockPattern& pattern);

  uint64_t pattern_hash_ = 0;
  int32_t block_count_ = 0;
  PcgStorage storage_ = PcgStorage::Double;
  std::vector<int64_t> row_start_;  // [block_count + 1] of the off-diagonal blocks
  std::vector<int32_t> column_;
  std::vector<int64_t> source_;   // 2 * slot + transposed
  AlignedVector<double> blocks_;  // [entry][9], column by column
  AlignedVector<float> blocks_float_;
  AlignedVector<double> diagonal_;  // [block][9]
  AlignedVector<double> inverse_;   // [block][9]
  int32_t failed_block_ = -1;
  AlignedVector<double> r_, z_, p_, q_;
  std::vector<double> partial_;
};

}  // namespace stark
