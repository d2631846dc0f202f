// A block matrix with the preconditioner symmetric Gauss-Seidel, M = K D^-1 K^T, where D are the diagonal
// blocks and K is the lower triangle with them, A = K + K^T - D. In the variables K^T x an iteration reads
// every block once, as a product with A does [Eisenstat 1981; theory eq. 23d]. Sweeps go from row to row on
// one thread: it is for systems that are too small to share. Phase: linear solve of a Newton step.
#pragma once

#include <cstdint>
#include <vector>

#include <stark/linalg/pcg.h>

namespace stark {

class GaussSeidelMatrix final : public PreconditionedMatrix {
 public:
  bool prepare(const BlockMatrix& matrix, PcgStorage storage, ThreadPool& pool) override;
  int32_t block_count() const override { return block_count_; }
  int32_t failed_block() const override { return failed_block_; }
  int64_t size() const override {
    return 4 * static_cast<int64_t>(block_count_);
  }  // three and a zero a block
  double start(const double* b, double* r, double* z, ThreadPool& pool) override;
  double multiply(const double* z, double beta, double* p, double* q, ThreadPool& pool) override;
  double update(double alpha, const double* p, const double* q, double* y, double* r, double* z,
                ThreadPool& pool) override;
  void finish(const double* y, double* x, ThreadPool& pool) override;

 private:
  void expand_structure(const BlockPattern& pattern);
  void copy_blocks(const BlockMatrix& matrix);
  template <typename Sweep>
  auto with_blocks(Sweep&& sweep);

  uint64_t pattern_hash_ = 0;
  int32_t block_count_ = 0, failed_block_ = -1;
  PcgStorage storage_ = PcgStorage::Double;
  std::vector<int64_t> row_start_, above_;  // of the blocks of a row: below the diagonal, above it
  std::vector<int32_t> column_;             // those next to the diagonal last: they are known last
  std::vector<int64_t> source_;             // 2 * slot + transposed
  AlignedVector<double> blocks_;            // [entry][9], column by column
  AlignedVector<float> blocks_float_;
  AlignedVector<double> diagonal_, inverse_;  // [block][9], and one number to read on
  AlignedVector<double> solved_, product_;    // K^-T p, and what is above times that
};

}  // namespace stark
