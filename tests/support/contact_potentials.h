// The potentials of contact, compiled once for all tests of the layer.
#pragma once

#include <stark/contact/pipeline.h>

namespace stark::models {

PotentialDefinition barrier_point_point();
PotentialDefinition barrier_point_edge();
PotentialDefinition barrier_point_triangle();
PotentialDefinition barrier_edge_edge();
PotentialDefinition barrier_mollified_point_point();
PotentialDefinition barrier_mollified_point_edge();
PotentialDefinition barrier_mollified_edge_edge();
PotentialDefinition friction_2();
PotentialDefinition friction_3();
PotentialDefinition friction_4();
PotentialDefinition friction_5();
PotentialDefinition friction_6();
PotentialDefinition anisotropic_friction_2();
PotentialDefinition anisotropic_friction_3();
PotentialDefinition anisotropic_friction_4();
PotentialDefinition anisotropic_friction_5();
PotentialDefinition anisotropic_friction_6();

}  // namespace stark::models

namespace stark::test {

inline const ContactPotentials& contact_potentials() {
  static const ContactPotentials potentials = compile_contact_potentials(symbolic::Backend::Automatic, true);
  return potentials;
}

/// b(d) = -(d - d_hat)^2 ln(d / d_hat) below d_hat, written out independently of the potentials [m^2].
inline double barrier(double d, double d_hat) {
  return d < d_hat ? -(d - d_hat) * (d - d_hat) * std::log(d / d_hat) : 0.0;
}
inline double barrier_slope(double d, double d_hat) {
  return d < d_hat ? -2.0 * (d - d_hat) * std::log(d / d_hat) - (d - d_hat) * (d - d_hat) / d : 0.0;
}

}  // namespace stark::test
