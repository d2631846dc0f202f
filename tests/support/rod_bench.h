// One segment of a rod in states of known strain, for tests of rod laws.
#pragma once

#include <array>
#include <map>
#include <string>
#include <vector>

#include <stark/base/rotation.h>
#include <stark/mechanics/rod_law.h>
#include <support/model_checks.h>

namespace stark::test {

/// The eight points of a segment: nodes and axes of its two frames.
inline std::vector<Vec3> segment_points(const Vec3& x0, const Vec3& x1, const Mat3& R0, const Mat3& R1) {
  std::vector<Vec3> points{x0, x1};
  for (const Mat3* R : {&R0, &R1})
    for (int k = 0; k < 3; ++k) points.push_back(R->column(k));
  return points;
}

inline constexpr double kSegmentLength = 0.2;  // [m]

/// A straight segment along z whose frames turn against each other by `turn` [rad], half to each side, with
/// the edge (shear 1, shear 2, stretch) in rest lengths.
inline std::vector<Vec3> strained_segment(const Vec3& turn, const Vec3& edge = {0, 0, 1}) {
  const Vec3 half = edge * (0.5 * kSegmentLength);
  return segment_points(Vec3{} - half, half, exp_rotation(turn * -0.5), exp_rotation(turn * 0.5));
}

/// A law on a straight segment.
class RodProbe {
 public:
  RodProbe(const RodLaw& law, std::map<std::string, std::vector<double>> values)
      : potential_(compiled(rod_segment(law))), values_(std::move(values)) {}

  double energy(const std::vector<Vec3>& x) const { return at(x, x); }
  double at(const std::vector<Vec3>& x, const std::vector<Vec3>& x_prev) const {
    const FilledSample sample{strained_segment({}), x_prev, x, values_};
    return test::energy(potential_, sample, x);
  }

 private:
  Potential potential_;
  std::map<std::string, std::vector<double>> values_;
};

}  // namespace stark::test
