// Sparse symmetric matrix of 3x3 blocks, the Hessian of every Newton step. A node of a deformable owns one
// block row, a rigid body two. Only the upper block triangle is stored; slots are stable until the pattern
// changes, so that elements are assembled straight into them. Phase: assembly and linear solve.
#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include <stark/base/aligned.h>
#include <stark/base/thread_pool.h>

namespace stark {

/// Upper triangle (block column >= block row, diagonal always present) of a symmetric matrix of 3x3 blocks.
struct BlockPattern {
  int32_t block_count = 0;         // block rows
  std::vector<int64_t> row_start;  // [block_count + 1]
  std::vector<int32_t> column;     // sorted within a row; the first entry of row i is i

  /// Pairs in any order, with duplicates, as (i, j) or (j, i); the diagonal is added. Linear in the number of
  /// pairs.
  static BlockPattern from_pairs(int32_t block_count, std::vector<std::pair<int32_t, int32_t>> pairs);

  /// Union of this pattern and `pairs` (any order, duplicates allowed). out_slot_of_base[k] is the slot in
  /// the union of slot k of this pattern. Linear in both.
  BlockPattern merged_with(std::span<const std::pair<int32_t, int32_t>> pairs,
                           std::vector<int64_t>& out_slot_of_base) const;

  /// Slot of block (i, j), i <= j, or -1 if it is not in the pattern. Binary search in row i.
  int64_t slot(int32_t i, int32_t j) const;

  int64_t slot_count() const { return static_cast<int64_t>(column.size()); }

  /// Hash of the structure; equal patterns have equal hashes.
  uint64_t hash() const;

  bool operator==(const BlockPattern&) const = default;
};

/// A symmetric matrix on a BlockPattern: values[9 * slot + 3 * r + c] is entry (r, c) of the block. A
/// diagonal block is stored whole, both triangles.
struct BlockMatrix {
  BlockPattern pattern;
  AlignedVector<double> values;  // [slot][9], row-major

  /// Sizes `values` to the pattern and fills it with zeros.
  void set_zero();
  void set_zero(ThreadPool& pool);

  /// y = A x; x and y have 3 * block_count entries and do not overlap.
  void multiply(const double* x, double* y, ThreadPool& pool) const;
};

}  // namespace stark
