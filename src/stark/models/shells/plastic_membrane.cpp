// Membrane that yields in plane stress, at finite strain: multiplicative split F = Fe Fp, elasticity in
// logarithmic strains (Hencky), von Mises' criterion for Kirchhoff stresses. With the inverse plastic metric
// G = (Fp^T Fp)^-1 the principal elastic strains are e_i = log(l_i)/2, l_i the eigenvalues of C G; half their
// sum and half their difference are the axes of the elastic energy and of the criterion. [Simo, Taylor
// 1986, "A return mapping algorithm for plane stress elastoplasticity"; Simo 1992; models/yielding.h; theory
// eq. 11a, 11b]
#include <cmath>

#include <stark/models/elastic_constants.h>
#include <stark/models/yielding.h>

namespace stark::models {

namespace {

/// Below this square of the argument the logarithms are series, which need no root.
constexpr double kSeries = 0.04;

/// atanh(r)/r of y = r^2 < 1, to rounding.
Scalar atanh_over(const Scalar& y) {
  const Scalar r = sqrt(max(y, kSeries));
  Scalar series = 1.0 / 17.0;
  for (int k = 7; k >= 0; --k) series = series * y + 1.0 / (2.0 * k + 1.0);
  return select(y > kSeries, log((1.0 + r) / (1.0 - r)) / (2.0 * r), series);
}

/// sinh(x)/x.
Scalar sinh_over(const Scalar& x) {
  const Scalar bounded = max(x, 1e-3);
  return select(x > 1e-3, (exp(bounded) - exp(-bounded)) / (2.0 * bounded), 1.0 + square(x) / 6.0);
}

}  // namespace

ShellLaw plastic_membrane() {
  ShellLaw law = define_shell_law(
      "plastic_membrane", "membrane that yields in plane stress",
      [](PotentialBuilder& b, const ShellDeformation& deformation) {
        const auto [E, nu] = elastic_constants(b);
        const Scalar yield =
            b.parameter("yield_stress", "Pa", "von Mises stress at which it yields", positive_or_infinity());
        const Scalar hardening = b.parameter(
            "hardening_modulus", "Pa", "growth of the yield stress with the plastic strain", non_negative());
        const auto G = b.internal("plastic_metric", {1.0, 0.0, 1.0}, "1", "11, 12, 22 of (Fp^T Fp)^-1");
        const Scalar p = b.internal("plastic_work", {0.0}, "J/m^3", "plastic work as without hardening")[0];
        const Mat32 F = deformation.F();
        const Mat2 C = transpose(F) * F;
        const Mat2 M = C * Mat2{G[0], G[1], G[1], G[2]};
        const Scalar half = 0.5 * trace(M), unlike = 0.5 * (M(0, 0) - M(1, 1));
        const Scalar y = (square(unlike) + M(0, 1) * M(1, 0)) / square(half);  // ((l1 - l2)/(l1 + l2))^2
        const Scalar sum = 0.5 * log(determinant(M));                          // e1 + e2
        const Scalar s = atanh_over(y);                                        // (e1 - e2)/y^(1/2)
        const Yielding yields =
            yielding({{0.5 * square(sum), E / (1.0 - nu), yield * std::sqrt(2.0)},
                      {0.5 * y * square(s), E / (1.0 + nu), yield * std::sqrt(2.0 / 3.0)}},
                     hardening / square(yield), p);
        // C G' has the eigenvectors of C G.
        const Scalar x = yields.kept[1] * s * sqrt(max(y, 0.0));
        const Scalar across = sinh_over(x) * yields.kept[1] * s / half;
        const Mat2 one = Mat2::identity();
        const Mat2 after = inverse(C) * ((0.5 * (exp(x) + exp(-x)) - across * half) * one + across * M);
        const Scalar size = exp(yields.kept[0] * sum), flows = yields.work > 0.0;
        b.update("plastic_metric", {select(flows, size * after(0, 0), G[0]),
                                    select(flows, 0.5 * size * (after(0, 1) + after(1, 0)), G[1]),
                                    select(flows, size * after(1, 1), G[2])});
        b.update("plastic_work", {p + yields.work});
        return yields.energy;
      });
  law.sample = [](std::mt19937_64&) {  // far beyond yielding: there a difference meets no kink
    return std::map<std::string, std::vector<double>>{
        {"poissons_ratio", {0.3}}, {"yield_stress", {2e-3}}, {"hardening_modulus", {0.2}}};
  };
  return law;
}

}  // namespace stark::models
