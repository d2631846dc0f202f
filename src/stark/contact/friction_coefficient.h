// Coulomb's law of a pair of surfaces.
#pragma once

#include <cmath>
#include <cstdint>

namespace stark {

/// Coulomb's coefficients, for sticking and for sliding contact. A single number is both. Where friction
/// depends on the direction, these are the ones of the axis with the larger friction.
struct FrictionCoefficient {
  double sticking = 0.0, sliding = 0.0;
  double along = 1.0,
         across = 1.0;  ///< shares of them along and across the surface direction; one of them is 1
  int32_t frame = -1;   ///< group whose surface direction it is; -1: none
  FrictionCoefficient() = default;
  FrictionCoefficient(double both) : sticking(both), sliding(both) {}
  FrictionCoefficient(double static_value, double kinetic) : sticking(static_value), sliding(kinetic) {}

  bool is_anisotropic() const { return along != across; }
};

/// Of two surfaces with coefficients of their own: the geometric mean.
inline double combined_friction(double a, double b) { return a == b ? a : std::sqrt(a * b); }

/// Coefficients for sticking contact along and across the direction of a surface; sliding contact has the
/// part `kinetic` of both.
struct AnisotropicFriction {
  double along = 0.0, across = 0.0;
  double kinetic = 1.0;
};

}  // namespace stark
