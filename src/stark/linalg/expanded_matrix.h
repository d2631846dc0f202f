// A block matrix with both triangles, row by row, as the preconditioners of conjugate gradients read it: the
// upper triangle is expanded once per matrix, so that a row is one run of memory. Phase: linear solve of a
// Newton step.
#pragma once

#include <cstdint>
#include <vector>

#include <stark/base/aligned.h>
#include <stark/base/thread_pool.h>
#include <stark/linalg/block_matrix.h>

namespace stark {

/// Precision in which the off-diagonal blocks are kept. Vectors and diagonal blocks are always double.
enum class PcgStorage : uint8_t { Double, Float };

class ExpandedMatrix {
 public:
  /// Order of the blocks above the diagonal in a row; those below it come first, and ascend.
  enum class Above : uint8_t { Ascending, Descending };
  explicit ExpandedMatrix(Above order) : order_(order) {}

  /// Copies `matrix`, and inverts its diagonal blocks. Structure is redone only if the pattern changed. False
  /// if a diagonal block is not positive definite.
  bool prepare(const BlockMatrix& matrix, PcgStorage storage, ThreadPool& pool);

  int32_t block_count() const { return block_count_; }
  int32_t failed_block() const { return failed_block_; }  ///< the first not positive definite, -1 if all are

  /// Off-diagonal blocks of row i: [row_begin(i), above(i)) are below the diagonal, the rest above it.
  int64_t row_begin(int64_t i) const { return row_start_[i]; }
  int64_t above(int64_t i) const { return above_[i]; }
  int64_t row_end(int64_t i) const { return row_start_[i + 1]; }
  const int32_t* column() const { return column_.data(); }
  /// Calls use(blocks) with the off-diagonal blocks [9 * entry], column by column, in their precision.
  template <typename Use>
  auto with_blocks(Use&& use) const {
    return storage_ == PcgStorage::Double ? use(blocks_.data()) : use(blocks_float_.data());
  }

  /// [block][9], row by row; a number more can be read.
  double* diagonal() { return diagonal_.data(); }
  const double* diagonal() const { return diagonal_.data(); }
  const double* inverse() const { return inverse_.data(); }

 private:
  void expand_structure(const BlockPattern& pattern);
  void copy_rows(const BlockMatrix& matrix, int64_t begin, int64_t end);

  Above order_;
  uint64_t pattern_hash_ = 0;
  int32_t block_count_ = 0, failed_block_ = -1;
  PcgStorage storage_ = PcgStorage::Double;
  std::vector<int64_t> row_start_, above_;
  std::vector<int32_t> column_;
  std::vector<int64_t> source_;  // 2 * slot + transposed
  AlignedVector<double> blocks_;
  AlignedVector<float> blocks_float_;
  AlignedVector<double> diagonal_, inverse_;
};

}  // namespace stark
