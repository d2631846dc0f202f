// A block matrix with the preconditioner block-Jacobi, to which a coarse space may be added. The upper
// triangle is expanded once per matrix so that a product reads every block once, row by row, and rows can be
// shared among threads. Dot products are summed over fixed blocks. Phase: linear solve of a Newton step.
#pragma once

#include <cstdint>
#include <vector>

#include <stark/linalg/coarse_space.h>
#include <stark/linalg/pcg.h>

namespace stark {

class JacobiMatrix final : public PreconditionedMatrix {
 public:
  bool prepare(const BlockMatrix& matrix, PcgStorage storage, ThreadPool& pool) override;
  /// Corrects the preconditioner, nullptr: no longer. It has a factor of the matrix.
  void set_coarse_space(CoarseSpace* coarse) { coarse_ = coarse; }

  int32_t block_count() const override { return block_count_; }
  int32_t failed_block() const override { return failed_block_; }
  int64_t size() const override { return 3 * static_cast<int64_t>(block_count_); }
  double start(const double* b, double* r, double* z, ThreadPool& pool) override;
  double multiply(const double* z, double beta, double* p, double* q, ThreadPool& pool) override;
  double update(double alpha, const double* p, const double* q, double* y, double* r, double* z,
                ThreadPool& pool) override;
  void finish(const double* y, double* x, ThreadPool& pool) override;

  /// y = A x with the expanded form.
  void apply(const double* x, double* y, ThreadPool& pool) const;

 private:
  void expand_structure(const BlockPattern& pattern);
  double precondition(int64_t begin, int64_t end, const double* r, double* z) const;
  double corrected(const double* r, double* z, ThreadPool& pool);

  uint64_t pattern_hash_ = 0;
  int32_t block_count_ = 0, failed_block_ = -1;
  PcgStorage storage_ = PcgStorage::Double;
  std::vector<int64_t> row_start_;  // [block_count + 1] of the off-diagonal blocks
  std::vector<int32_t> column_;
  std::vector<int64_t> source_;   // 2 * slot + transposed
  AlignedVector<double> blocks_;  // [entry][9], column by column
  AlignedVector<float> blocks_float_;
  AlignedVector<double> diagonal_;  // [block][9]
  AlignedVector<double> inverse_;   // [block][9]
  std::vector<double> partial_;
  CoarseSpace* coarse_ = nullptr;
};

}  // namespace stark
