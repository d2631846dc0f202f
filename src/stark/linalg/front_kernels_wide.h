// The two inner kernels of front_kernels.h on two strips at once, with 512-bit vectors: three of them hold a
// column of both. Strips keep their layout, and every entry goes through the same operations in the same
// order as with 256-bit vectors, so the bits are the same. Phase: numerical factorisation.
#pragma once

#include <stark/linalg/front_layout.h>

namespace stark::front {

/// A tile of kTile columns, or a column operand, in each of two strips.
template <typename Real>
struct StripPair {
  Real *upper, *lower;
};

/// t -= a b^T over `depth` columns of two strips `a` and four rows `b` of a strip, starting from zero if
/// `clear`. Needs cpu_features().avx512.
void subtract_product_wide(StripPair<double> t, StripPair<const double> a, const double* b, int depth,
                           bool clear);
void subtract_product_wide(StripPair<float> t, StripPair<const float> a, const float* b, int depth,
                           bool clear);

/// t -= a b^T, then X L^T = T solved in place for the 4 x 4 lower triangle L at `l`.
void eliminate_tile_wide(StripPair<double> t, StripPair<const double> a, const double* b, int depth,
                         const double* l);
void eliminate_tile_wide(StripPair<float> t, StripPair<const float> a, const float* b, int depth,
                         const float* l);

}  // namespace stark::front
