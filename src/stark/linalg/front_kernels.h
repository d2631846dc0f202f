// Dense kernels on the fronts of the multifrontal Cholesky factorisation, in the layout of front_layout.h.
// Where the processor has 512-bit vectors, pairs of strips go through front_kernels_wide.h, with the same
// bits. Phase: numerical factorisation.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include <stark/base/simd.h>
#include <stark/linalg/front_kernels_wide.h>
#include <stark/linalg/front_layout.h>

namespace stark::front {

template <typename Real>
struct Tile {
  simd::V<Real> c[kTile][3];

  void clear() {
    for (auto& column : c)
      for (auto& v : column) v = simd::splat(Real(0));
  }
  void load(const Real* p) {
    for (int j = 0; j < kTile; ++j)
      for (int r = 0; r < 3; ++r) c[j][r] = simd::load(p + j * kStrip<Real> + r * simd::kWidth<Real>);
  }
  void store(Real* p) const {
    for (int j = 0; j < kTile; ++j)
      for (int r = 0; r < 3; ++r) simd::store(p + j * kStrip<Real> + r * simd::kWidth<Real>, c[j][r]);
  }
};

/// t -= a b^T over `depth` columns of a strip `a` and of the four rows `b` of another strip.
template <typename Real>
[[gnu::always_inline]] inline void subtract_product(Tile<Real>& t, const Real* a, const Real* b, int depth) {
  using V = simd::V<Real>;
  constexpr int kW = simd::kWidth<Real>;
  V c00 = t.c[0][0], c01 = t.c[0][1], c02 = t.c[0][2], c10 = t.c[1][0], c11 = t.c[1][1], c12 = t.c[1][2];
  V c20 = t.c[2][0], c21 = t.c[2][1], c22 = t.c[2][2], c30 = t.c[3][0], c31 = t.c[3][1], c32 = t.c[3][2];
  for (int k = 0; k < depth; ++k, a += kStrip<Real>, b += kStrip<Real>) {
    const V a0 = simd::load(a), a1 = simd::load(a + kW), a2 = simd::load(a + 2 * kW);
    V s = simd::splat(b[0]);
    c00 = simd::fnma(a0, s, c00), c01 = simd::fnma(a1, s, c01), c02 = simd::fnma(a2, s, c02);
    s = simd::splat(b[1]);
    c10 = simd::fnma(a0, s, c10), c11 = simd::fnma(a1, s, c11), c12 = simd::fnma(a2, s, c12);
    s = simd::splat(b[2]);
    c20 = simd::fnma(a0, s, c20), c21 = simd::fnma(a1, s, c21), c22 = simd::fnma(a2, s, c22);
    s = simd::splat(b[3]);
    c30 = simd::fnma(a0, s, c30), c31 = simd::fnma(a1, s, c31), c32 = simd::fnma(a2, s, c32);
  }
  t.c[0][0] = c00, t.c[0][1] = c01, t.c[0][2] = c02, t.c[1][0] = c10, t.c[1][1] = c11, t.c[1][2] = c12;
  t.c[2][0] = c20, t.c[2][1] = c21, t.c[2][2] = c22, t.c[3][0] = c30, t.c[3][1] = c31, t.c[3][2] = c32;
}

/// Solves X L^T = T in place for the 4 x 4 lower triangle L at `l` (column stride kStrip, reciprocal
/// diagonal).
template <typename Real>
[[gnu::always_inline]] inline void solve_tile(Tile<Real>& t, const Real* l) {
  for (int j = 0; j < kTile; ++j) {
    for (int i = 0; i < j; ++i) {
      const auto factor = simd::splat(l[i * kStrip<Real> + j]);
      for (int r = 0; r < 3; ++r) t.c[j][r] = simd::fnma(t.c[i][r], factor, t.c[j][r]);
    }
    const auto inverse = simd::splat(l[j * kStrip<Real> + j]);
    for (int r = 0; r < 3; ++r) t.c[j][r] *= inverse;
  }
}

/// Rows of the pivot block that hold the columns 4q ..: strip and first row.
template <typename Real>
inline const Real* tile_rows(const Real* pivot, int column) {
  return pivot + triangle_offset<Real>(column / kStrip<Real>) + column % kStrip<Real>;
}

/// Eliminates columns [begin, end) of strips [first, last): subtracts the products with earlier columns and
/// solves with the finished diagonal block of these columns. strip(s) is the address of strip s. `wide` needs
/// cpu_features().avx512.
template <typename Real, typename StripAt>
void solve_strips(const Real* pivot, int begin, int end, int first, int last, bool wide, StripAt&& strip) {
  constexpr int kS = kStrip<Real>;
  Tile<Real> t;
  for (int k = 0; k < begin; k += kDepthBlock) {
    const int depth = std::min(kDepthBlock, begin - k);
    for (int s = first; s < last;) {
      Real* const row = strip(s);
      const bool pair = wide && s + 1 < last;
      Real* const next = pair ? strip(s + 1) : nullptr;
      for (int q = begin; q < end; q += kTile) {
        const Real* const rows = tile_rows(pivot, q) + k * kS;
        if (pair) {
          subtract_product_wide(StripPair<Real>{row + q * kS, next + q * kS}, {row + k * kS, next + k * kS},
                                rows, depth, false);
        } else {
          t.load(row + q * kS);
          subtract_product(t, row + k * kS, rows, depth);
          t.store(row + q * kS);
        }
      }
      s += pair ? 2 : 1;
    }
  }
  for (int s = first; s < last;) {
    Real* const row = strip(s);
    const bool pair = wide && s + 1 < last;
    Real* const next = pair ? strip(s + 1) : nullptr;
    for (int q = begin; q < end; q += kTile) {
      const Real* const rows = tile_rows(pivot, q);
      if (pair) {
        eliminate_tile_wide(StripPair<Real>{row + q * kS, next + q * kS},
                            {row + begin * kS, next + begin * kS}, rows + begin * kS, q - begin,
                            rows + q * kS);
      } else {
        t.load(row + q * kS);
        subtract_product(t, row + begin * kS, rows + begin * kS, q - begin);
        solve_tile(t, rows + q * kS);
        t.store(row + q * kS);
      }
    }
    s += pair ? 2 : 1;
  }
}

/// Cholesky factor of the 4 x 4 lower triangle at `l`, with the reciprocal diagonal and zeros above. Returns
/// the first column whose pivot is not positive, or -1.
template <typename Real>
inline int factor_tile(Real* l) {
  constexpr int kS = kStrip<Real>;
  for (int j = 0; j < kTile; ++j) {
    Real* const column = l + j * kS;
    for (int i = 0; i < j; ++i) {
      const Real factor = l[i * kS + j];
      for (int r = j; r < kTile; ++r) column[r] -= l[i * kS + r] * factor;
    }
    if (!(column[j] > Real(0))) return j;
    const Real inverse = Real(1) / std::sqrt(column[j]);
    if (!(inverse > Real(0))) return j;
    column[j] = inverse;
    for (int r = j + 1; r < kTile; ++r) column[r] *= inverse;
    for (int r = 0; r < j; ++r) column[r] = Real(0);
  }
  return -1;
}

/// Factorises the diagonal block of columns [begin, end), begin a multiple of kStrip, after the products with
/// columns before `begin` have been subtracted. Returns the column of the first pivot that is not positive,
/// or -1.
template <typename Real>
int factor_diagonal(Real* pivot, int begin, int end) {
  constexpr int kS = kStrip<Real>;
  const int last = strips_of<Real>(end);
  Tile<Real> t;
  for (int q = begin; q < end; q += kTile) {
    const int s = q / kS, offset = q % kS;
    Real* const strip = pivot + triangle_offset<Real>(s);
    Real* const column = strip + q * kS;
    t.load(column);
    subtract_product(t, strip + begin * kS, strip + begin * kS + offset, q - begin);
    t.store(column);
    const int failed = factor_tile(column + offset);
    if (failed >= 0) return q + failed;
    Real triangle[kTile][kTile];
    for (int j = 0; j < kTile; ++j)
      for (int i = 0; i < kTile; ++i) triangle[j][i] = column[j * kS + offset + i];
    solve_tile(t, column + offset);
    t.store(column);
    for (int j = 0; j < kTile; ++j) {
      for (int i = 0; i < offset; ++i) column[j * kS + i] = Real(0);
      for (int i = 0; i < kTile; ++i) column[j * kS + offset + i] = triangle[j][i];
    }
    for (int below = s + 1; below < last; ++below) {
      Real* const other = pivot + triangle_offset<Real>(below);
      t.load(other + q * kS);
      subtract_product(t, other + begin * kS, strip + begin * kS + offset, q - begin);
      solve_tile(t, column + offset);
      t.store(other + q * kS);
    }
  }
  return -1;
}

/// Subtracts the products with columns before `begin` from strips [first, last) of the diagonal block of
/// columns [begin, end).
template <typename Real>
void update_diagonal(Real* pivot, int begin, int end, int first, int last) {
  constexpr int kS = kStrip<Real>;
  Tile<Real> t;
  for (int k = 0; k < begin; k += kDepthBlock) {
    const int depth = std::min(kDepthBlock, begin - k);
    for (int s = first; s < last; ++s) {
      Real* const row = pivot + triangle_offset<Real>(s);
      for (int q = begin; q < std::min(end, (s + 1) * kS); q += kTile) {
        t.load(row + q * kS);
        subtract_product(t, row + k * kS, tile_rows(pivot, q) + k * kS, depth);
        t.store(row + q * kS);
      }
    }
  }
}

/// Block of kStrip columns of a strip of the update matrix: minus the product of strip `a` of the border with
/// strip `b`, over `depth` columns, added to what is there unless `clear`.
template <typename Real>
void update_block(Real* c, const Real* a, const Real* b, int depth, bool clear) {
  constexpr int kS = kStrip<Real>;
  Tile<Real> t;
  for (int q = 0; q < kS; q += kTile) {
    if (clear) {
      t.clear();
    } else {
      t.load(c + q * kS);
    }
    subtract_product(t, a, b + q, depth);
    t.store(c + q * kS);
  }
}

/// Strips [first, last) of the update matrix become minus the product of the border with its transpose.
/// `wide` needs cpu_features().avx512.
template <typename Real>
void form_update(Real* update, const Real* border, int columns, int first, int last, bool wide) {
  constexpr int kS = kStrip<Real>;
  constexpr int kBlock = kColumnBlock / kS;  // strips
  for (int block = 0; block < last; block += kBlock)
    for (int k = 0; k < columns; k += kDepthBlock) {
      const int depth = std::min(kDepthBlock, columns - k);
      const auto column_of = [&](int s) { return border + (static_cast<int64_t>(s) * columns + k) * kS; };
      const auto block_of = [&](int s, int j) {
        return update + triangle_offset<Real>(s) + static_cast<int64_t>(j) * kS * kS;
      };
      for (int s = std::max(first, block); s < last;) {
        const bool pair = wide && s + 1 < last;
        const int end = std::min(block + kBlock, s + 1);  // of the block columns that both strips have
        for (int j = block; j < end; ++j) {
          if (!pair) {
            update_block(block_of(s, j), column_of(s), column_of(j), depth, k == 0);
            continue;
          }
          Real *const upper = block_of(s, j), *const lower = block_of(s + 1, j);
          for (int q = 0; q < kS; q += kTile)
            subtract_product_wide(StripPair<Real>{upper + q * kS, lower + q * kS},
                                  {column_of(s), column_of(s + 1)}, column_of(j) + q, depth, k == 0);
        }
        if (pair && s + 1 < block + kBlock)
          update_block(block_of(s + 1, s + 1), column_of(s + 1), column_of(s + 1), depth, k == 0);
        s += pair ? 2 : 1;
      }
    }
}

/// out[kStrip] += strip x over `count` columns.
template <typename Real>
inline void multiply_strip(const Real* strip, const Real* x, int count, Real* out) {
  constexpr int kS = kStrip<Real>, kW = simd::kWidth<Real>;
  using V = simd::V<Real>;
  V even[3], odd[3];
  for (int r = 0; r < 3; ++r) even[r] = simd::load(out + r * kW), odd[r] = simd::splat(Real(0));
  for (int k = 0; k + 1 < count; k += 2) {
    const V x0 = simd::splat(x[k]), x1 = simd::splat(x[k + 1]);
    for (int r = 0; r < 3; ++r) {
      even[r] = simd::fma(simd::load(strip + k * kS + r * kW), x0, even[r]);
      odd[r] = simd::fma(simd::load(strip + (k + 1) * kS + r * kW), x1, odd[r]);
    }
  }
  for (int r = 0; r < 3; ++r) simd::store(out + r * kW, even[r] + odd[r]);  // count is a multiple of kTile
}

/// sums[c] += (column c of the strip) . x for `count` <= kStrip columns; one vector of partial sums per
/// column.
template <typename Real>
inline void multiply_strip_transposed(const Real* strip, const Real* x, int count, simd::V<Real>* sums) {
  constexpr int kS = kStrip<Real>, kW = simd::kWidth<Real>;
  const auto x0 = simd::load(x), x1 = simd::load(x + kW), x2 = simd::load(x + 2 * kW);
  for (int c = 0; c < count; ++c) {
    const Real* const column = strip + c * kS;
    auto sum = simd::fma(simd::load(column), x0, sums[c]);
    sum = simd::fma(simd::load(column + kW), x1, sum);
    sums[c] = simd::fma(simd::load(column + 2 * kW), x2, sum);
  }
}

/// Solves L x = x with the pivot block of n4 columns; x has whole strips.
template <typename Real>
void solve_lower(const Real* pivot, int n4, Real* x) {
  constexpr int kS = kStrip<Real>;
  for (int s = 0; s < strips_of<Real>(n4); ++s) {
    const Real* const strip = pivot + triangle_offset<Real>(s);
    Real product[kS] = {};
    multiply_strip(strip, x, s * kS, product);
    Real* const own = x + s * kS;
    for (int i = 0; i < kS; ++i) own[i] -= product[i];
    for (int k = 0; k < std::min(kS, n4 - s * kS); ++k) {
      const Real* const column = strip + (s * kS + k) * kS;
      own[k] *= column[k];
      for (int i = k + 1; i < kS; ++i) own[i] -= column[i] * own[k];
    }
  }
}

/// Columns of strip s of the pivots.
template <typename Real>
constexpr int columns_of_strip(int s, int n4) {
  return std::min(kStrip<Real>, n4 - s * kStrip<Real>);
}

/// sums += the columns of strip s of the pivots in the border B of `border_strips` strips, times y.
template <typename Real>
inline void multiply_border_transposed(const Real* border, int n4, int border_strips, int s, const Real* y,
                                       simd::V<Real>* sums) {
  constexpr int kS = kStrip<Real>;
  for (int below = 0; below < border_strips; ++below)
    multiply_strip_transposed(border + (static_cast<int64_t>(below) * n4 + s * kS) * kS, y + below * kS,
                              columns_of_strip<Real>(s, n4), sums);
}

/// x -= B^T y in strips [first, last) of the pivots, B being the border of `border_strips` strips.
template <typename Real>
void subtract_border(const Real* border, int n4, int border_strips, int first, int last, Real* x,
                     const Real* y) {
  constexpr int kS = kStrip<Real>;
  for (int s = first; s < last; ++s) {
    simd::V<Real> sums[kS] = {};
    multiply_border_transposed(border, n4, border_strips, s, y, sums);
    for (int k = 0; k < columns_of_strip<Real>(s, n4); ++k) x[s * kS + k] -= simd::sum(sums[k]);
  }
}

/// Solves L^T x = x - B^T y with the pivot block and the border B of `border_strips` strips.
template <typename Real>
void solve_upper(const Real* pivot, const Real* border, int n4, int border_strips, Real* x, const Real* y) {
  constexpr int kS = kStrip<Real>;
  const int strips = strips_of<Real>(n4);
  for (int s = strips - 1; s >= 0; --s) {
    const int begin = s * kS, count = columns_of_strip<Real>(s, n4);
    simd::V<Real> sums[kS];
    for (int c = 0; c < count; ++c) sums[c] = simd::splat(Real(0));
    for (int below = s + 1; below < strips; ++below)
      multiply_strip_transposed(pivot + triangle_offset<Real>(below) + begin * kS, x + below * kS, count,
                                sums);
    multiply_border_transposed(border, n4, border_strips, s, y, sums);
    const Real* const diagonal = pivot + triangle_offset<Real>(s) + begin * kS;
    for (int k = count - 1; k >= 0; --k) {
      Real value = x[begin + k] - simd::sum(sums[k]);
      for (int i = k + 1; i < count; ++i) value -= diagonal[k * kS + i] * x[begin + i];
      x[begin + k] = value * diagonal[k * kS + k];
    }
  }
}

}  // namespace stark::front
