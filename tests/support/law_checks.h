// Constitutive laws against linear elasticity and closed forms: stress by the element kernels of the laws.
#pragma once

#include <doctest/doctest.h>

#include <support/model_checks.h>
#include <support/random_points.h>

namespace stark::test {

inline const std::vector<Vec3> kLawTet{{0.1, 0, 0}, {1.2, 0.1, 0}, {0.4, 0.9, 0.1}, {0.5, 0.3, 0.8}};
inline const std::vector<Vec3> kLawTriangle{{0.1, 0, 0}, {1.2, 0.1, 0}, {0.4, 0.9, 0}};

/// A law on one linear element of known size.
class LawProbe {
 public:
  LawProbe(const SolidLaw& law, std::map<std::string, std::vector<double>> values)
      : LawProbe(tet4(law), kLawTet,
                 dot(kLawTet[1] - kLawTet[0], cross(kLawTet[2] - kLawTet[0], kLawTet[3] - kLawTet[0])) / 6.0,
                 std::move(values)) {}
  LawProbe(const ShellLaw& law, std::map<std::string, std::vector<double>> values)
      : LawProbe(triangle3(law), kLawTriangle,
                 0.5 * norm(cross(kLawTriangle[1] - kLawTriangle[0], kLawTriangle[2] - kLawTriangle[0])),
                 std::move(values)) {}

  /// psi of F [J/m^3] (times thickness for shells).
  double density(const Mat3& F) const { return energy(potential_, sample_, mapped(F, sample_.X)) / size_; }
  /// Nominal stress in the direction `rate` of F: d psi [Pa].
  double stress(const Mat3& F, const Mat3& rate) const {
    return work(gradient(potential_, sample_, mapped(F, sample_.X)), mapped(rate, sample_.X)) / size_;
  }
  /// Second derivative of psi at rest along G [Pa].
  double stiffness(const Mat3& G) const {
    const std::vector<Vec3> u = mapped(G, sample_.X);
    return form(hessian(potential_, sample_, sample_.X), u, u) / size_;
  }

  /// Lateral stretch at which diag(a, b, b) has no lateral stress, by bisection.
  double lateral_stretch(double a) const {
    double low = 0.3, high = 3.0;
    for (int k = 0; k < 80; ++k) {
      const double b = 0.5 * (low + high);
      (stress(Mat3::diagonal({a, b, b}), Mat3::diagonal({0, 1, 1})) > 0.0 ? high : low) = b;
    }
    return 0.5 * (low + high);
  }
  /// Nominal stress of a bar at axial stretch a, free laterally [Pa].
  double uniaxial_stress(double a) const {
    const double b = lateral_stretch(a);
    return stress(Mat3::diagonal({a, b, b}), Mat3::diagonal({1, 0, 0}));
  }

 private:
  LawProbe(const PotentialDefinition& definition, const std::vector<Vec3>& X, double size,
           std::map<std::string, std::vector<double>> values)
      : potential_(compiled(definition)), sample_{X, X, X, std::move(values)}, size_(size) {}

  Potential potential_;
  FilledSample sample_;
  double size_;
};

/// Entry (i, j) alone.
inline Mat3 unit_entry(int i, int j) {
  Mat3 e;
  e(i, j) = 1.0;
  return e;
}

/// The second derivative at rest is that of linear elasticity with these constants [Pa].
inline void check_small_strain(const LawProbe& probe, double mu, double lambda) {
  RandomPoints random(1);
  for (int trial = 0; trial < 10; ++trial) {
    const Mat3 G = Mat3::from_columns(random.point(), random.point(), random.point());
    const Mat3 strain = (G + transpose(G)) * 0.5;
    CHECK(probe.stiffness(G) ==
          doctest::Approx(2 * mu * squared_frobenius(strain) + lambda * trace(strain) * trace(strain))
              .epsilon(1e-9));
  }
}

inline double shear_modulus(double E, double nu) { return E / (2 * (1 + nu)); }
inline double lame_lambda(double E, double nu) { return E * nu / ((1 + nu) * (1 - 2 * nu)); }

}  // namespace stark::test
