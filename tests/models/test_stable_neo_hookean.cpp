// Stable Neo-Hookean solids: linear elasticity at small strain, the closed-form stress at large ones,
// inverted elements.
#include <doctest/doctest.h>

#include <support/model_checks.h>
#include <support/random_points.h>

using namespace stark;
using namespace stark::test;

namespace {

const std::vector<Vec3> kTet{{0.1, 0, 0}, {1.2, 0.1, 0}, {0.4, 0.9, 0.1}, {0.5, 0.3, 0.8}};
double volume() { return dot(kTet[1] - kTet[0], cross(kTet[2] - kTet[0], kTet[3] - kTet[0])) / 6.0; }

FilledSample tet(double E, double nu) {
  return element(kTet, kTet, {{"youngs_modulus", E}, {"poissons_ratio", nu}});
}

}  // namespace

TEST_CASE("the Hessian at rest is that of linear elasticity") {
  const Potential potential = compiled(tet4(models::stable_neo_hookean()));
  RandomPoints random(1);
  for (const double nu : {0.0, 0.3, 0.49}) {
    const double E = 2e4, mu = E / (2 * (1 + nu)), lambda = E * nu / ((1 + nu) * (1 - 2 * nu));
    const std::vector<double> K = hessian(potential, tet(E, nu), kTet);
    for (int trial = 0; trial < 10; ++trial) {
      const Mat3 G = Mat3::from_columns(random.point(), random.point(), random.point());
      const Mat3 strain = (G + transpose(G)) * 0.5;
      const std::vector<Vec3> u = mapped(G, kTet);
      const double density = 2 * mu * squared_frobenius(strain) + lambda * trace(strain) * trace(strain);
      CHECK(form(K, u, u) == doctest::Approx(volume() * density).epsilon(1e-9));
    }
  }
}

TEST_CASE("small uniaxial strain and shear give Hooke's stresses") {
  const Potential potential = compiled(tet4(models::stable_neo_hookean()));
  const double E = 2e4, nu = 0.3, mu = E / (2 * (1 + nu)), lambda = E * nu / ((1 + nu) * (1 - 2 * nu)),
               e = 1e-6;
  const auto power = [&](const Mat3& F, const Mat3& rate) {  // stress times rate of strain, integrated
    return work(gradient(potential, tet(E, nu), mapped(F, kTet)), mapped(rate, kTet));
  };
  Mat3 stretch = Mat3::identity(), shear = Mat3::identity(), xx, xy, yy;
  stretch(0, 0) += e;
  shear(0, 1) += e;
  xx(0, 0) = xy(0, 1) = yy(1, 1) = 1.0;
  // Relative deviations of the order of the strain.
  CHECK(power(stretch, xx) == doctest::Approx(volume() * (lambda + 2 * mu) * e).epsilon(1e-5));
  CHECK(power(stretch, yy) == doctest::Approx(volume() * lambda * e).epsilon(1e-5));
  CHECK(power(shear, xy) == doctest::Approx(volume() * mu * e).epsilon(1e-5));
  // Uniaxial stress: lateral contraction nu e, axial stress E e, no lateral stress.
  const Mat3 uniaxial = Mat3::diagonal({1 + e, 1 - nu * e, 1 - nu * e});
  CHECK(power(uniaxial, xx) == doctest::Approx(volume() * E * e).epsilon(1e-5));
  CHECK(std::fabs(power(uniaxial, yy)) < 1e-5 * volume() * E * e);
}

TEST_CASE("large stretches and shears have the stress of the paper's eq. 18") {
  const Potential potential = compiled(tet4(models::stable_neo_hookean()));
  const double E = 2e4, nu = 0.4;
  const double mu = 4.0 / 3.0 * E / (2 * (1 + nu)),
               lambda = E * nu / ((1 + nu) * (1 - 2 * nu)) + 5.0 / 6.0 * E / (2 * (1 + nu));
  const double alpha = 1 + mu / lambda - mu / (4 * lambda);
  RandomPoints random(2);
  for (int trial = 0; trial < 20; ++trial) {
    const Mat3 F =
        Mat3::identity() + Mat3::from_columns(random.point(), random.point(), random.point()) * 0.7;
    const Mat3 dJ = Mat3::from_columns(cross(F.column(1), F.column(2)), cross(F.column(2), F.column(0)),
                                       cross(F.column(0), F.column(1)));
    const Mat3 P = F * (mu * (1 - 1 / (squared_frobenius(F) + 1))) + dJ * (lambda * (determinant(F) - alpha));
    const Mat3 rate = Mat3::from_columns(random.point(), random.point(), random.point());
    double density = 0.0;
    for (int k = 0; k < 9; ++k) density += P.m[k] * rate.m[k];
    CHECK(work(gradient(potential, tet(E, nu), mapped(F, kTet)), mapped(rate, kTet)) ==
          doctest::Approx(volume() * density).epsilon(1e-9));
  }
}

TEST_CASE("flat and inverted elements are finite and pushed back") {
  const Potential potential = compiled(tet4(models::stable_neo_hookean()));
  for (const double a : {0.1, 0.0, -0.5, -1.0}) {
    const std::vector<Vec3> x = mapped(Mat3::diagonal({a, 1, 1}), kTet);
    const FilledSample sample = tet(1e4, 0.3);
    CHECK(std::isfinite(energy(potential, sample, x)));
    CHECK(work(gradient(potential, sample, x), mapped(Mat3::diagonal({1, 0, 0}), kTet)) <
          0.0);  // opening lowers energy
    CHECK(energy(potential, sample, x) >
          energy(potential, sample, mapped(Mat3::diagonal({a + 0.1, 1, 1}), kTet)));
  }
}
