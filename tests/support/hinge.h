// Two triangles that share an edge, folded by a given angle.
#pragma once

#include <support/model_checks.h>

namespace stark::test {

/// Hinge of two rigid triangles with the shared edge on x; the second one is turned about it by `theta`
/// [rad], positive as the fold angle of the models.
inline std::vector<Vec3> folded(double theta) {
  const Vec3 wing{0.6, -0.8, 0};
  // Turning about x by theta lowers the wing at y < 0 for positive angles.
  return {
      {0, 0, 0}, {1.1, 0, 0}, {0.4, 0.9, 0}, {wing.x, wing.y * std::cos(theta), wing.y * std::sin(theta)}};
}

/// 3 |e|^2 / (A_a + A_b).
inline double hinge_factor() { return 3.0 * 1.1 * 1.1 / (0.5 * 1.1 * 0.9 + 0.5 * 1.1 * 0.8); }

inline FilledSample hinge_element(double rest, double previous, const Values& values) {
  return element(folded(rest), folded(previous), values);
}

}  // namespace stark::test
