// Strain above a limit: with the eigenvalues a_i of A = E - limit, E = (F^T F - 1)/2 the Green strain, the
// sum
//     S = sum_i max(0, a_i)^3
// in invariants of A. Eigenvalues themselves are not smooth where they meet; S is twice continuously
// differentiable everywhere, and here every case is written so that its formula is, too:
//   all positive     a polynomial of the invariants (Newton's identities);
//   none positive    0;
//   signs differ     the eigenvalue whose sign the others do not have is a simple root of the characteristic
//                    polynomial, and the others are not needed one by one.
// Simple roots are as far from the others as they are from zero, so nothing is singular unless two
// eigenvalues of different signs vanish together, where S and its derivatives vanish, too: matrices that are
// zero within kNothing count as zero, at strains that differ from the limit by 1e-20.
#pragma once

#include <stark/mechanics/define.h>

namespace stark::models {

/// Squares of strains below which there is nothing.
inline constexpr double kNothing = 1e-40;

/// S of a symmetric 2x2 matrix.
inline Scalar positive_cubes(const Scalar& trace, const Scalar& determinant) {
  const Scalar both = trace * (square(trace) - 3.0 * determinant);
  const Scalar larger = 0.5 * (trace + sqrt(square(trace) - 4.0 * determinant));
  return select(determinant < -kNothing, larger * square(larger), select(trace > 0.0, both, 0.0));
}

/// The positive root of x^3 - J1 x^2 + J2 x - J3, whose roots are real, one of them positive and two not.
/// Laguerre's method decreases to it from any upper bound; from the bounds here three steps reach rounding,
/// whatever the roots: after two, 2e-7 of the root at worst.
inline Scalar positive_root(const Scalar& J1, const Scalar& J2, const Scalar& J3) {
  // Of three real roots with mean J1/3 the largest is at most two standard deviations above it. Where the
  // others outweigh the positive one, without x^3 the root of what is left is above and near.
  const Scalar spread = (J1 + 2.0 * sqrt(square(J1) - 3.0 * J2)) / 3.0;
  const Scalar radical = sqrt(square(J2) - 4.0 * J1 * J3);
  const Scalar quadratic = select(J2 > 0.0, 2.0 * J3 / (J2 + radical), (J2 - radical) / (2.0 * J1));
  Scalar x = select(J1 < 0.0, min(spread, quadratic), spread);
  for (int k = 0; k < 3; ++k) {
    const Scalar f = ((x - J1) * x + J2) * x - J3;
    const Scalar slope = (3.0 * x - 2.0 * J1) * x + J2;
    const Scalar curvature = 6.0 * x - 2.0 * J1;
    x = x - 3.0 * f / (slope + sqrt(4.0 * square(slope) - 6.0 * f * curvature));
  }
  return x;
}

/// S of a symmetric 3x3 matrix with the principal invariants I1 = tr A, I2 = (I1^2 - tr A^2)/2, I3 = det A.
inline Scalar positive_cubes(const Scalar& I1, const Scalar& I2, const Scalar& I3) {
  const Scalar all = I1 * (square(I1) - 3.0 * I2) + 3.0 * I3;
  const Scalar two = I3 < 0.0;  // of A, and so one of -A
  const Scalar root = positive_root(select(two, -I1, I1), I2, abs(I3));
  const Scalar sum = I1 + root, product = I2 + root * sum;  // of the two positive ones
  const Scalar some = select(two, sum * (square(sum) - 3.0 * product), root * square(root));
  const Scalar none = (I1 <= 0.0 && I2 >= -kNothing && I3 <= kNothing) || square(I1) - 2.0 * I2 <= kNothing;
  return select(none, 0.0, select(I1 > 0.0 && I2 >= 0.0 && I3 >= 0.0, all, some));
}

/// Density of the limit [J/m^3] of strains with the sum S: k/3 S (1 + hardening S/(S + limit^3)).
inline Scalar strain_limit_density(PotentialBuilder& b, const Scalar& limit, const Scalar& S) {
  const Scalar k = b.parameter("strain_limit_stiffness", "Pa", "stiffness of the penalty", non_negative());
  const Scalar hardening =
      b.parameter("strain_limit_hardening", "1", "growth of the stiffness far above the limit, as a factor",
                  non_negative());
  return k / 3.0 * S * (1.0 + hardening * S / (S + limit * square(limit)));
}

inline Scalar strain_limit_parameter(PotentialBuilder& b) {
  return b.parameter("strain_limit", "1", "Green strain beyond which the penalty acts", positive());
}

}  // namespace stark::models
