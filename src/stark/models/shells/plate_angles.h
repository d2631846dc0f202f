// Kinematics shared by the plates: the fold angles of the hinges around a triangle, numbered as in
// mechanics/plate_element.h, and quadratic forms of them.
#pragma once

#include <string>
#include <vector>

#include <stark/mechanics/plate_element.h>
#include <stark/mechanics/rest_state.h>
#include <stark/models/shells/hinge.h>

namespace stark::models {

/// Data by hinge: PlateElement::angle_of_curvature.
inline constexpr const char* kAngleOfCurvature = "angle_of_curvature";

template <typename Point>
Scalar plate_angle(int k, const Point& point) {
  const auto [a, b, c, o] = plate_hinge(k);
  return fold_angle(hinge(point(a), point(b), point(c), point(o)));
}

/// Fold angle of a hinge without load: of a tensor of natural curvature, which its triangle has. [theory eq.
/// 15g]
inline Scalar natural_angle(PotentialBuilder& b, int hinge) {
  const auto K = b.data_array(rest_state::kNaturalCurvature, 9, "1/m", "curvature without load, a tensor");
  const auto rates = b.data_array(kAngleOfCurvature + std::to_string(hinge), 6, "m", "of unit curvatures");
  const Scalar diagonal = rates[0] * K[0] + rates[1] * K[4] + rates[2] * K[8];
  return diagonal + rates[3] * K[5] + rates[4] * K[2] + rates[5] * K[1];
}

/// Fold angles less those at rest [rad]; curls: with a natural curvature.
inline std::vector<Scalar> plate_bend(PotentialBuilder& b, int hinges, bool curls) {
  std::vector<Scalar> bend;
  for (int k = 0; k < hinges; ++k) {
    bend.push_back(plate_angle(k, [&](int i) { return b.x(i); }) -
                   b.data("rest_angle" + std::to_string(k), "rad", "fold angle at rest"));
    if (curls) bend.back() = bend.back() - natural_angle(b, k);
  }
  return bend;
}

/// Half the quadratic form S of angles.
inline Scalar plate_form(PotentialBuilder& b, const std::vector<Scalar>& angles) {
  Scalar form = 0.0;
  const int count = static_cast<int>(angles.size());
  for (int i = 0; i < count; ++i)
    for (int j = i; j < count; ++j) {
      const Scalar S = b.data("form" + std::to_string(i) + std::to_string(j), "1", "bending form");
      form = form + (i == j ? 0.5 : 1.0) * S * angles[i] * angles[j];
    }
  return form;
}

/// A flat triangle with its neighbours, bent by moderate random angles; values of rest angles and form.
PotentialSample sample_plate(int hinges, std::mt19937_64& random);

}  // namespace stark::models
