// One element of a model at given positions, for comparison with closed forms.
#pragma once

#include <cmath>
#include <map>
#include <string>
#include <vector>

#include <stark/mechanics/constitutive_law.h>
#include <stark/mechanics/potential.h>
#include <support/potential_sample.h>

namespace stark::models {

PotentialDefinition point_inertia();
PotentialDefinition gravity();
PotentialDefinition pressure();
SolidLaw stable_neo_hookean();
SolidLaw neo_hookean();
SolidLaw st_venant_kirchhoff();
SolidLaw corotated();
SolidLaw mooney_rivlin();
SolidLaw fiber_reinforced();
SolidLaw solid_damping();
ShellLaw membrane_st_venant_kirchhoff();
ShellLaw orthotropic_cloth();
SolidLaw strain_limit();
PotentialDefinition edge_strain_limit();
PotentialDefinition membrane_strain_limit();
PotentialDefinition membrane_neo_hookean();
PotentialDefinition membrane_damping();
PotentialDefinition flat_bending();
PotentialDefinition damped_flat_bending();
PotentialDefinition discrete_shell_bending();

}  // namespace stark::models

namespace stark::test {

using Values = std::map<std::string, double>;

inline Potential compiled(const PotentialDefinition& definition) {
  return {definition, symbolic::Backend::Automatic};
}

inline FilledSample element(const std::vector<Vec3>& X, const std::vector<Vec3>& x_prev,
                            const Values& values) {
  FilledSample sample{X, x_prev, x_prev, {}};
  for (const auto& [name, value] : values) sample.values[name] = {value};
  return sample;
}

/// Positions F X.
inline std::vector<Vec3> mapped(const Mat3& F, const std::vector<Vec3>& X) {
  std::vector<Vec3> x;
  for (const Vec3& p : X) x.push_back(F * p);
  return x;
}

/// a^T H b for displacement fields a, b given by point.
inline double form(const std::vector<double>& H, const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
  const size_t n = 3 * a.size();
  double sum = 0.0;
  for (size_t i = 0; i < n; ++i)
    for (size_t j = 0; j < n; ++j)
      sum += a[i / 3][static_cast<int>(i % 3)] * H[i * n + j] * b[j / 3][static_cast<int>(j % 3)];
  return sum;
}

/// g . a for a displacement field a.
inline double work(const std::vector<double>& g, const std::vector<Vec3>& a) {
  double sum = 0.0;
  for (size_t i = 0; i < g.size(); ++i) sum += g[i] * a[i / 3][static_cast<int>(i % 3)];
  return sum;
}

inline double largest(const std::vector<double>& values) {
  double result = 0.0;
  for (const double v : values) result = std::fmax(result, std::fabs(v));
  return result;
}

inline double squared_frobenius(const Mat3& A) {
  double sum = 0.0;
  for (const double v : A.m) sum += v * v;
  return sum;
}

}  // namespace stark::test
