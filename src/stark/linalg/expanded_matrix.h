// A block matrix with both triangles, row by row, as the preconditioners of conjugate gradients read it: the
// upper triangle is expanded once per matrix, so that a row is one run of memory. Phase: linear solve of a
// Newton step.
#pragma once

#include <cstdint>
#include <span>
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
  /// What diagonal() holds of matrices in single precision: the diagonal block, or the sum of all blocks of a
  /// row, for products with differences.
  enum class Diagonal : uint8_t { Block, RowSum };
  explicit ExpandedMatrix(Above order, Diagonal of_float = Diagonal::Block)
      : order_(order), of_float_(of_float) {}

  /// Copies `matrix`, and inverts its diagonal blocks. Row k here is row order[k] there; an empty order
  /// leaves them where they are. Structure is redone only if pattern or order changed. False if a diagonal
  /// block is not positive definite.
  bool prepare(const BlockMatrix& matrix, PcgStorage storage, ThreadPool& pool,
               std::span<const int32_t> order = {});

  int32_t block_count() const { return block_count_; }
  /// The first block of the matrix that is not positive definite, -1 if all are.
  int32_t failed_block() const { return failed_block_; }
  /// Row of the matrix that is row k here.
  int32_t source_row(int64_t k) const {
    return source_row_.empty() ? static_cast<int32_t>(k) : source_row_[k];
  }

  /// Off-diagonal blocks of row i: [row_begin(i), above(i)) are below the diagonal of the matrix, the rest
  /// above it.
  int64_t row_begin(int64_t i) const { return row_start_[i]; }
  int64_t above(int64_t i) const { return above_[i]; }
  int64_t row_end(int64_t i) const { return row_start_[i + 1]; }
  const int32_t* column() const { return column_.data(); }
  /// Calls use(blocks) with the off-diagonal blocks [9 * entry], column by column, in their precision.
  template <typename Use>
  auto with_blocks(Use&& use) const {
    return storage_ == PcgStorage::Double ? use(blocks_.data()) : use(blocks_float_.data());
  }

  PcgStorage storage() const { return storage_; }

  /// [block][9], row by row; a number more can be read.
  double* diagonal() { return diagonal_.data(); }
  const double* diagonal() const { return diagonal_.data(); }
  const double* inverse() const { return inverse_.data(); }

 private:
  void expand_structure(const BlockPattern& pattern, std::span<const int32_t> order);
  int32_t copy_rows(const BlockMatrix& matrix, int64_t begin, int64_t end);

  template <typename Real>
  void copy_blocks(const BlockMatrix& matrix, int64_t begin, int64_t end, Real* blocks);

  Above order_;
  Diagonal of_float_;
  uint64_t pattern_hash_ = 0;
  int32_t block_count_ = 0, failed_block_ = -1;
  PcgStorage storage_ = PcgStorage::Double;
  std::vector<int32_t> source_row_;  // empty: as they are
  std::vector<int64_t> row_start_, above_;
  std::vector<int32_t> column_;
  std::vector<uint32_t> source_;  // 2 * slot + transposed
  AlignedVector<double> blocks_;
  AlignedVector<float> blocks_float_;
  AlignedVector<double> diagonal_, inverse_;
};

}  // namespace stark
