// How the fronts of the multifrontal Cholesky factorisation lie in memory. All matrices are cut into strips
// of kStrip rows, stored column by column: a strip of a 12 x 4 (double) or 24 x 4 (float) tile is then three
// vectors per column, both operands of the inner product kernel are read in sequence, and no packing is
// needed (Goto and van de Geijn 2008 for the blocking). Phase: numerical factorisation.
//
// A front of n pivots (padded to n4, a multiple of kTile, with unit diagonal) and m update rows has
//   pivot block    lower block triangle of strips: strip s holds the columns 0 .. min((s + 1) kStrip, n4) -
//   1, border         strips of the update rows with n4 columns each, update matrix  lower block triangle of
//   strips with whole strips of columns.
// The factor keeps the reciprocal of its diagonal and zeros above it.
#pragma once

#include <cstdint>

#include <stark/base/simd.h>

namespace stark::front {

template <typename Real>
inline constexpr int kStrip = 3 * simd::kWidth<Real>;
inline constexpr int kTile = 4;          // columns of a register tile; divides kStrip
inline constexpr int kColumnBlock = 96;  // columns whose operand stays in the second-level cache
inline constexpr int kDepthBlock = 128;  // inner dimension for which two strips stay in the first-level cache

template <typename Real>
constexpr int strips_of(int rows) {
  return (rows + kStrip<Real> - 1) / kStrip<Real>;
}
/// Scalars before strip s of a lower block triangle.
template <typename Real>
constexpr int64_t triangle_offset(int64_t s) {
  return kStrip<Real> * kStrip<Real> * (s * (s + 1) / 2);
}

}  // namespace stark::front
