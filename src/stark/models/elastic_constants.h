// Elastic constants in which laws are given, declared once for all of them.
#pragma once

#include <stark/mechanics/define.h>

namespace stark::models {

/// Young's modulus [Pa] and Poisson's ratio, in (-1, 0.5) of isotropic solids; negative ones are left out.
struct ElasticConstants {
  Scalar E, nu;
};

inline ElasticConstants elastic_constants(PotentialBuilder& b) {
  return {b.parameter("youngs_modulus", "Pa", "Young's modulus", positive()),
          b.parameter("poissons_ratio", "1", "Poisson's ratio", half_open_interval(0.0, 0.5))};
}

/// Lame's constants of linear elasticity [Pa].
struct LameConstants {
  Scalar mu, lambda;
};

inline LameConstants lame_constants(PotentialBuilder& b) {
  const auto [E, nu] = elastic_constants(b);
  return {E / (2.0 * (1.0 + nu)), E * nu / ((1.0 + nu) * (1.0 - 2.0 * nu))};
}

/// Lame's constants of plane stress [Pa].
inline LameConstants plane_stress_constants(PotentialBuilder& b) {
  const auto [E, nu] = elastic_constants(b);
  return {E / (2.0 * (1.0 + nu)), E * nu / (1.0 - nu * nu)};
}

/// Poisson's ratio in [0, 0.45), the other parameters as they come.
inline std::map<std::string, std::vector<double>> sample_poissons_ratio(std::mt19937_64& random) {
  return {{"poissons_ratio", {std::uniform_real_distribution<double>(0.0, 0.45)(random)}}};
}

}  // namespace stark::models
