// Continuous collision detection for linear motion by conservative advancement along separating planes: at
// time t the direction n between the closest points separates the primitives; each vertex pair keeps its gap
// along n linearly in time, so the first time at which a gap falls to the target is a safe step (a
// directional form of additive CCD, Li et al. 2021, "Codimensional incremental potential contact"). Where no
// plane lasts, an interval in which the Bernstein coefficients of the coplanarity cubic keep their sign is
// passed at once. Gaps and volumes are lowered by bounds of their rounding errors, so the result is
// conservative in floating point, whatever closest features were found. Phase: step-length bound. [theory
// eq. 21]
#pragma once

#include <array>

#include <stark/base/math.h>

namespace stark {

struct CcdSettings {
  double time_margin = 0.1;  // part of the time to the impact that is given back, so that a gap remains
  double tolerance =
      1e-4;  // an impact: the gap has come this near to the separation, relative to the initial gap
  int max_iterations = 64;     // the time reached so far counts as the impact: safe, only smaller
  int sharper_iterations = 0;  // after those, with bounds of the volume that take longer
  bool is_bound = true;  // false: a pair keeps a tenth of its gap where that is less than the separation
  double horizon = 1.0;  // impacts after this time are not looked for: the result is then 1
};

// Fraction t in [0, 1] such that the distance of the two primitives on [0, t] stays above the separation:
// min_separation, or half of the distance d0 at the start where d0 is less. 1: the whole motion is safe.
// Otherwise 1 - time_margin times the time at which the separation is reached; a head-on approach leaves that
// part of what is above it, and passing close by does not limit the step. Returns 0 when d0 is zero or below
// rounding, when the two approach and d0 is the separation up to rounding, and for positions that are not
// finite. x0 and x1 hold the vertices at the start and the end, point first, then edge
// or triangle; edge A, then edge B.
double point_point_ccd(const std::array<Vec3, 2>& x0, const std::array<Vec3, 2>& x1, double min_separation,
                       const CcdSettings& settings = {});
double point_edge_ccd(const std::array<Vec3, 3>& x0, const std::array<Vec3, 3>& x1, double min_separation,
                      const CcdSettings& settings = {});
double point_triangle_ccd(const std::array<Vec3, 4>& x0, const std::array<Vec3, 4>& x1, double min_separation,
                          const CcdSettings& settings = {});
double edge_edge_ccd(const std::array<Vec3, 4>& x0, const std::array<Vec3, 4>& x1, double min_separation,
                     const CcdSettings& settings = {});

}  // namespace stark
