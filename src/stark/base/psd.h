// Positive semidefinite projection of small symmetric matrices, eight at a time, in the layout in which the
// element kernels emit their Hessians. Test: LDL^T without pivoting of the slightly shifted matrix (a PSD
// matrix always passes). Projection: Householder tridiagonalisation and implicit QR with Wilkinson's shift
// (Golub and Van Loan, Matrix Computations, section 8.3), eigenvalues clamped at zero: the nearest PSD matrix
// in the Frobenius norm (Higham 1988). Phase: between evaluation and assembly.
#pragma once

#include <cstdint>

#include <stark/base/math.h>

namespace stark {

inline constexpr int kPsdLanes = 8;
/// 24 points with three coordinates each: an actuator on three joints, with two frames of four points each.
inline constexpr int kPsdMaxSize = 72;
/// Six points, of a plate, of which the translations may be left out.
inline constexpr int kPsdMaxReduced = 18;

/// Lanes that are not positive semidefinite, as a bit mask (bit l: lane l). `upper` is [n(n+1)/2][8]: the
/// upper triangles, row by row, of eight symmetric n x n matrices, n in 1..kPsdMaxSize. Eigenvalues above
/// -1e-12 times the sum of the absolute diagonal count as non-negative; a lane with a NaN is reported. Any
/// alignment.
uint32_t psd_test(const double* upper, int n);

/// Replaces the lanes in `mask` by the nearest positive semidefinite matrix; the other lanes keep their bits,
/// and a lane's result does not depend on its neighbours. With `translation_invariant` (n = 6, 9, ..., 18:
/// points with three coordinates each, every row of 3x3 blocks sums to zero) the eigenproblem is solved on
/// the n - 3 dimensions orthogonal to the translations, which gives the same matrix for less. A lane with a
/// NaN or infinity is left as is.
void psd_project(double* upper, int n, uint32_t mask, bool translation_invariant = false);

/// The nearest positive semidefinite matrix to the symmetric part of `a`.
Mat3 psd_project(const Mat3& a);

}  // namespace stark
