// Coulomb's law of a pair of surfaces.
#pragma once

namespace stark {

/// Coulomb's coefficients, for sticking and for sliding contact. A single number is both.
struct FrictionCoefficient {
  double sticking = 0.0, sliding = 0.0;
  FrictionCoefficient() = default;
  FrictionCoefficient(double both) : sticking(both), sliding(both) {}
  FrictionCoefficient(double static_value, double kinetic) : sticking(static_value), sliding(kinetic) {}
};

}  // namespace stark
