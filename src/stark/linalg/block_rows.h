// Products of rows of 3x3 blocks with vectors, in 256-bit lanes, for conjugate gradients.
#pragma once

#include <cmath>
#include <cstdint>
#include <cstring>

#include <stark/base/simd.h>

namespace stark {

/// Inverse of a symmetric 3x3 block (its symmetric part is taken) through its Cholesky factor; false if the
/// block is not positive definite.
inline bool invert_spd(const double* a, double* inverse) {
  const double a10 = 0.5 * (a[1] + a[3]), a20 = 0.5 * (a[2] + a[6]), a21 = 0.5 * (a[5] + a[7]);
  if (!(a[0] > 0.0)) return false;
  const double i0 = 1.0 / std::sqrt(a[0]), l10 = a10 * i0, l20 = a20 * i0;
  const double d1 = a[4] - l10 * l10;
  if (!(d1 > 0.0)) return false;
  const double i1 = 1.0 / std::sqrt(d1), l21 = (a21 - l20 * l10) * i1;
  const double d2 = a[8] - l20 * l20 - l21 * l21;
  if (!(d2 > 0.0)) return false;
  const double i2 = 1.0 / std::sqrt(d2);
  const double m10 = -l10 * i0 * i1, m21 = -l21 * i1 * i2, m20 = -(l20 * i0 + l21 * m10) * i2;
  inverse[0] = i0 * i0 + m10 * m10 + m20 * m20;
  inverse[1] = inverse[3] = m10 * i1 + m20 * m21;
  inverse[2] = inverse[6] = m20 * i2;
  inverse[4] = i1 * i1 + m21 * m21;
  inverse[5] = inverse[7] = m21 * i2;
  inverse[8] = i2 * i2;
  return std::isfinite(inverse[0]) && std::isfinite(inverse[4]) && std::isfinite(inverse[8]);
}

inline simd::VDouble load_column(const double* p) { return simd::load(p); }
inline simd::VDouble load_column(const float* p) {
  typedef float Four __attribute__((vector_size(16)));
  Four four;
  std::memcpy(&four, p, sizeof(four));
  return __builtin_convertvector(four, simd::VDouble);
}

/// Sum over a row's blocks, stored column by column: three lanes are used, the fourth reads on into what
/// follows.
template <int kStride, typename Real>
simd::VDouble multiply_row(int64_t begin, int64_t end, const int32_t* column, const Real* blocks,
                           const double* x) {
  simd::VDouble sum[3] = {simd::splat(0.0), simd::splat(0.0), simd::splat(0.0)};
  for (int64_t k = begin; k < end; ++k) {
    const Real* a = blocks + 9 * k;
    const double* u = x + kStride * static_cast<int64_t>(column[k]);
    for (int c = 0; c < 3; ++c) sum[c] = simd::fma(load_column(a + 3 * c), simd::splat(u[c]), sum[c]);
  }
  return (sum[0] + sum[1]) + sum[2];
}

/// Four numbers in single precision.
typedef float Float4 __attribute__((vector_size(16)));

inline Float4 load4(const float* p) {
  Float4 v;
  std::memcpy(&v, p, sizeof(v));
  return v;
}
inline Float4 fma4(Float4 a, Float4 b, Float4 c) {
#if defined(__FMA__)
  return (Float4)_mm_fmadd_ps((__m128)a, (__m128)b, (__m128)c);
#else
  for (int l = 0; l < 4; ++l) c[l] = std::fma(a[l], b[l], c[l]);
  return c;
#endif
}

/// Sum over a row's blocks times differences of vectors, x of the column less `own` of the row. They are
/// products in single precision: what rounds are differences, small where x is smooth and what remains of the
/// sum is, too. A number past the end of x can be read.
inline simd::VDouble multiply_differences(int64_t begin, int64_t end, const int32_t* column,
                                          const float* blocks, const double* x, simd::VDouble own) {
  Float4 sum[3] = {};
  for (int64_t k = begin; k < end; ++k) {
    const float* a = blocks + 9 * k;
    const Float4 u =
        __builtin_convertvector(simd::load(x + 3 * static_cast<int64_t>(column[k])) - own, Float4);
    sum[0] = fma4(load4(a), __builtin_shufflevector(u, u, 0, 0, 0, 0), sum[0]);
    sum[1] = fma4(load4(a + 3), __builtin_shufflevector(u, u, 1, 1, 1, 1), sum[1]);
    sum[2] = fma4(load4(a + 6), __builtin_shufflevector(u, u, 2, 2, 2, 2), sum[2]);
  }
  return __builtin_convertvector((sum[0] + sum[1]) + sum[2], simd::VDouble);
}

/// sum += a, transposed or straight, row by row.
inline void add_block(const double* a, bool is_transposed, double* sum) {
  const int across = is_transposed ? 3 : 1, down = 4 - across;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) sum[3 * r + c] += a[down * r + across * c];
}

/// A transposed or straight copy of a block, row by row, as the columns that products take.
template <typename Real>
void copy_columns(const double* a, bool is_transposed, Real* columns) {
  const int across = is_transposed ? 3 : 1, down = 4 - across;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) columns[3 * c + r] = static_cast<Real>(a[down * r + across * c]);
}

}  // namespace stark
