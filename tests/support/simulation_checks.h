// What physics tests ask of a simulation: totals of momentum, and whether a body has passed through a sheet.
#pragma once

#include <cmath>
#include <span>
#include <vector>

#include <stark/collision/intersection.h>
#include <stark/mechanics/free_rotation.h>
#include <stark/sim/simulation.h>

namespace stark::test {

/// Linear momentum of all free masses [kg m/s].
inline Vec3 linear_momentum(const Simulation& sim) {
  Vec3 p;
  const auto& masses = sim.model().point_masses();
  for (size_t i = 0; i < masses.size(); ++i)
    if (sim.model().map().layout().point_block[i] != kNoBlock) p += sim.state().point_velocity[i] * masses[i];
  const auto& rigid = sim.model().rigid_masses();
  for (size_t b = 0; b < rigid.size(); ++b) p += sim.state().body_velocity[b] * rigid[b].mass;
  return p;
}

/// Angular momentum of rigid body `b` about its centre of mass [kg m^2/s].
inline Vec3 spin(const Simulation& sim, int b) {
  return angular_momentum(sim.state().body_rotation[b], sim.model().rigid_masses()[b].moments,
                          sim.state().body_angular_velocity[b]);
}

/// Solid angle of a triangle seen from p, positive on the side of its normal [van Oosterom and Strackee
/// 1983].
inline double solid_angle(const Vec3& p, const Vec3& v0, const Vec3& v1, const Vec3& v2) {
  const Vec3 a = v0 - p, b = v1 - p, c = v2 - p;
  const double la = norm(a), lb = norm(b), lc = norm(c);
  return -2.0 *
         std::atan2(dot(a, cross(b, c)), la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb);
}

/// Solid angle of a sheet seen from p. It changes continuously as p and the sheet move, and by -4 pi as p
/// passes through the sheet against its normal: positive before, negative after, whatever the deformation.
inline double solid_angle(const Vec3& p, std::span<const Vec3> x, std::span<const Index3> triangles) {
  double sum = 0.0;
  for (const Index3& t : triangles) sum += solid_angle(p, x[t[0]], x[t[1]], x[t[2]]);
  return sum;
}

/// Edges through triangles at the present positions, by the exact test.
inline size_t intersection_count(const Simulation& sim) {
  ThreadPool pool(1);
  const int32_t groups = sim.scene().body_count();
  return find_intersections(sim.surface_mesh(), sim.site_positions(), PairFilter(groups), pool).size();
}

}  // namespace stark::test
