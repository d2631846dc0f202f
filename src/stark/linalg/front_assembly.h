// Assembly of the fronts of the multifrontal method: blocks of A, and the update matrices of the children
// ("extend-add"; Duff and Reid 1983). Phase: numerical factorisation.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include <stark/linalg/block_matrix.h>
#include <stark/linalg/elimination.h>
#include <stark/linalg/front_kernels.h>

namespace stark::front {

/// Sizes and addresses of one front.
template <typename Real>
struct Front {
  int columns, padded_columns, rows;  // scalars
  int pivot_strips, border_strips;
  Real* pivot;
  Real* border;
  Real* update;

  Real* pivot_strip(int s) const { return pivot + triangle_offset<Real>(s); }
  Real* border_strip(int s) const { return border + static_cast<int64_t>(s) * kStrip<Real> * padded_columns; }
  /// Pivots and border.
  std::span<Real> panel() const { return {pivot, border_strip(border_strips)}; }
};

/// Where the rows of a child go in the front of its parent, as runs that are consecutive in both.
struct Assembly {
  std::vector<int64_t> panel_base, update_base;  // address of a block row, column zero
  std::vector<int32_t> run_end;                  // first block row after the run that the row is in
};

/// target[c][0 .. 3 blocks) += source[c][..] for the three columns of a block column.
template <typename Real>
inline void add_run(Real* target, const Real* source, int blocks) {
  constexpr int kS = kStrip<Real>;
  const auto add = [&](int count) {
    for (int c = 0; c < 3; ++c)
      for (int r = 0; r < count; ++r) target[c * kS + r] += source[c * kS + r];
  };
  switch (blocks) {  // constant lengths are unrolled and vectorised
    case 1:
      return add(3);
    case 2:
      return add(6);
    case 3:
      return add(9);
    case 4:
      return add(12);
    default:
      return add(3 * blocks);
  }
}

/// Unit padding and the blocks of A, in a front of zeros.
template <typename Real>
void load_matrix(const Front<Real>& f, const BlockMatrix& matrix, std::span<const FrontEntry> entries) {
  constexpr int kS = kStrip<Real>;
  for (int p = f.columns; p < f.padded_columns; ++p) f.pivot_strip(p / kS)[p * kS + p % kS] = Real(1);
  for (const FrontEntry& entry : entries) {
    const double* block = matrix.values.data() + 9 * static_cast<int64_t>(entry.slot);
    const int row = 3 * entry.row < f.columns ? 3 * entry.row : 3 * entry.row - f.columns;
    Real* target = (3 * entry.row < f.columns ? f.pivot_strip(row / kS) : f.border_strip(row / kS)) +
                   row % kS + 3 * entry.column * kS;
    const int across = entry.transposed ? 3 : 1, down = 4 - across;
    for (int c = 0; c < 3; ++c)
      for (int r = 0; r < 3; ++r) target[c * kS + r] = static_cast<Real>(block[down * r + across * c]);
  }
}

/// Finds the runs of a child whose row i goes to row relative[i] of the front.
template <typename Real>
void prepare_assembly(const Front<Real>& f, std::span<const int32_t> relative, Assembly& assembly) {
  constexpr int kS = kStrip<Real>, kStripBlocks = kS / 3;
  const auto rows = static_cast<int32_t>(relative.size());
  assembly.panel_base.resize(rows);
  assembly.update_base.resize(rows);
  assembly.run_end.resize(rows);
  for (int32_t i = 0; i < rows; ++i) {
    const int row = 3 * relative[i];
    if (row < f.columns) {
      assembly.panel_base[i] = triangle_offset<Real>(row / kS) + row % kS;
      assembly.update_base[i] = -1;
    } else {
      const int strip = (row - f.columns) / kS, offset = (row - f.columns) % kS;
      assembly.panel_base[i] = f.border_strip(strip) - f.pivot + offset;
      assembly.update_base[i] = triangle_offset<Real>(strip) + offset;
    }
  }
  // A run ends with a strip of the child, with a gap in the parent's rows, or with a strip there.
  for (int32_t i = rows - 1; i >= 0; --i) {
    const bool joins = i + 1 < rows && (i + 1) % kStripBlocks != 0 &&
                       assembly.panel_base[i + 1] == assembly.panel_base[i] + 3 &&
                       relative[i + 1] == relative[i] + 1;
    assembly.run_end[i] = joins ? assembly.run_end[i + 1] : i + 1;
  }
}

/// Adds the block columns [begin, end) of a child's update matrix; they lie all in the panel or all in the
/// update matrix.
template <typename Real>
void assemble(const Front<Real>& f, const Real* source, std::span<const int32_t> relative,
              const Assembly& assembly, int32_t begin, int32_t end) {
  constexpr int kS = kStrip<Real>;
  const auto rows = static_cast<int32_t>(relative.size());
  for (int32_t j = begin; j < end; ++j) {
    const int column = 3 * relative[j];
    const bool in_panel = column < f.columns;
    Real* const target =
        in_panel ? f.pivot + column * kS : f.update + static_cast<int64_t>(column - f.columns) * kS;
    const int64_t* base = in_panel ? assembly.panel_base.data() : assembly.update_base.data();
    for (int32_t i = j; i < rows; i = assembly.run_end[i]) {
      const int row = 3 * i;
      add_run(target + base[i], source + triangle_offset<Real>(row / kS) + row % kS + 3 * j * kS,
              assembly.run_end[i] - i);
    }
  }
}

/// Number of block columns of a child's update matrix that are pivots of the parent.
template <typename Real>
int32_t pivot_columns(const Front<Real>& f, std::span<const int32_t> relative) {
  return static_cast<int32_t>(std::lower_bound(relative.begin(), relative.end(), f.columns / 3) -
                              relative.begin());
}

}  // namespace stark::front
