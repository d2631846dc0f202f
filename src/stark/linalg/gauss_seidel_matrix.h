// A block matrix with the preconditioner symmetric Gauss-Seidel, M = K D^-1 K^T, where D are the diagonal
// blocks and K is the lower triangle with them, A = K + K^T - D. In the variables K^T x an iteration reads
// every block once, as a product with A does [Eisenstat 1981; theory eq. 23d]. Sweeps go from row to row on
// one thread: it is for systems that are too small to share. Phase: linear solve of a Newton step.
#pragma once

#include <cstdint>

#include <stark/linalg/expanded_matrix.h>
#include <stark/linalg/pcg.h>

namespace stark {

class GaussSeidelMatrix final : public PreconditionedMatrix {
 public:
  bool prepare(const BlockMatrix& matrix, PcgStorage storage, ThreadPool& pool) override;
  int32_t block_count() const override { return rows_.block_count(); }
  int32_t failed_block() const override { return rows_.failed_block(); }
  int64_t size() const override { return 4 * static_cast<int64_t>(block_count()); }  // three and a zero each
  double start(const double* b, double* r, double* z, ThreadPool& pool) override;
  double multiply(const double* z, double beta, double* p, double* q, ThreadPool& pool) override;
  double update(double alpha, const double* p, const double* q, double* y, double* r, double* z,
                ThreadPool& pool) override;
  void finish(const double* y, double* x, ThreadPool& pool) override;

 private:
  // Blocks next to the diagonal come last in each part of a row: their vectors are known last.
  ExpandedMatrix rows_{ExpandedMatrix::Above::Descending};
  AlignedVector<double> solved_, product_;  // K^-T p, and what is above times that
};

}  // namespace stark
