// Fixed corotated elasticity: psi = mu |F - R|^2 + lambda/2 (J - 1)^2 with the rotation R of the polar
// decomposition F = R S. [Stomakhin, Howes, Schroeder, Teran 2012, "Energetically Consistent Invertible
// Elasticity"] Finite for flat and inverted elements.
//
// |F - R|^2 = I1 - 2 s + 3 needs only s = tr S, the sum of the singular values with the smallest one signed
// like J. It is the largest root of
//     f(s) = s^4 - 2 I1 s^2 - 8 J s + I1^2 - 4 I2,   I1 = tr C,  I2 = (I1^2 - tr C^2)/2,
// whose other roots lie 2 (sigma_i + sigma_j) below it [cf. Smith, de Goes, Kim 2019, "Analytic Eigensystems
// for Isotropic Distortion Energies"]: a simple root, smooth in the invariants, wherever R is unique. The
// four roots are real, so Laguerre's method from (I1 + 3)/2 >= sqrt(3 I1) >= s decreases to it monotonically
// and cubically; derivatives of the iteration converge along with it.
#include <stark/models/elastic_constants.h>

namespace stark::models {

namespace {

// Rounding for singular values from 0.01 to 20, inverted or not, with sigma_2 + sigma_3 above a thousandth.
constexpr int kIterations = 7;

Scalar stretch_trace(const Scalar& I1, const Scalar& I2, const Scalar& J) {
  const Scalar constant = I1 * I1 - 4.0 * I2, linear = 8.0 * J;
  Scalar s = 0.5 * (I1 + 3.0);
  for (int k = 0; k < kIterations; ++k) {
    const Scalar squared = s * s;
    const Scalar f = ((squared - 2.0 * I1) * s - linear) * s + constant;
    const Scalar slope = 4.0 * (squared - I1) * s - linear;
    const Scalar curvature = 12.0 * squared - 4.0 * I1;
    s = s - 4.0 * f / (slope + sqrt(9.0 * slope * slope - 12.0 * f * curvature));
  }
  return s;
}

}  // namespace

SolidLaw corotated() {
  SolidLaw law = define_solid_law("corotated", "fixed corotated elasticity",
                                  [](PotentialBuilder& b, const SolidDeformation& deformation) {
                                    const auto [mu, lambda] = lame_constants(b);
                                    const Mat3 F = deformation.F();
                                    const Mat3 C = transpose(F) * F;
                                    const Scalar I1 = trace(C), J = determinant(F);
                                    const Scalar I2 = C(0, 0) * C(1, 1) - square(C(0, 1)) +
                                                      C(1, 1) * C(2, 2) - square(C(1, 2)) +
                                                      C(2, 2) * C(0, 0) - square(C(2, 0));
                                    for (const Scalar& invariant : {I1, I2, J})
                                      b.graph()->mark_stage(invariant);
                                    const Scalar s = stretch_trace(I1, I2, J);
                                    return mu * (I1 - 2.0 * s + 3.0) + 0.5 * lambda * square(J - 1.0);
                                  });
  law.sample = sample_poissons_ratio;
  return law;
}

}  // namespace stark::models
