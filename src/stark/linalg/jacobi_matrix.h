// A block matrix with the preconditioner block-Jacobi, to which a coarse space may be added. A product reads
// every block once, row by row, and rows are shared among threads. Dot products are summed over fixed blocks.
// Phase: linear solve of a Newton step.
#pragma once

#include <cstdint>
#include <vector>

#include <stark/linalg/coarse_space.h>
#include <stark/linalg/expanded_matrix.h>
#include <stark/linalg/pcg.h>

namespace stark {

class JacobiMatrix final : public PreconditionedMatrix {
 public:
  bool prepare(const BlockMatrix& matrix, PcgStorage storage, ThreadPool& pool) override {
    return rows_.prepare(matrix, storage, pool);
  }
  /// Corrects the preconditioner, nullptr: no longer. It has a factor of the matrix.
  void set_coarse_space(CoarseSpace* coarse) { coarse_ = coarse; }

  int32_t block_count() const override { return rows_.block_count(); }
  int32_t failed_block() const override { return rows_.failed_block(); }
  int64_t size() const override { return 3 * static_cast<int64_t>(block_count()); }
  double start(const double* b, double* r, double* z, ThreadPool& pool) override;
  double multiply(const double* z, double beta, double* p, double* q, ThreadPool& pool) override;
  double update(double alpha, const double* p, const double* q, double* y, double* r, double* z,
                ThreadPool& pool) override;
  void finish(const double* y, double* x, ThreadPool& pool) override;

  /// y = A x with the expanded form.
  void apply(const double* x, double* y, ThreadPool& pool) const;

 private:
  double precondition(int64_t begin, int64_t end, const double* r, double* z) const;
  double corrected(const double* r, double* z, ThreadPool& pool);

  ExpandedMatrix rows_{ExpandedMatrix::Above::Ascending};
  std::vector<double> partial_;
  CoarseSpace* coarse_ = nullptr;
};

}  // namespace stark
