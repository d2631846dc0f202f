// Kinematics shared by the plates: the fold angles of the hinges around a triangle, numbered as in
// mechanics/plate_element.h, and quadratic forms of them.
#pragma once

#include <string>
#include <vector>

#include <stark/mechanics/plate_element.h>
#include <stark/models/shells/hinge.h>

namespace stark::models {

template <typename Point>
Scalar plate_angle(int k, const Point& point) {
  const auto [a, b, c, o] = plate_hinge(k);
  return fold_angle(hinge(point(a), point(b), point(c), point(o)));
}

/// Fold angles less those at rest [rad].
inline std::vector<Scalar> plate_bend(PotentialBuilder& b, int hinges) {
  std::vector<Scalar> bend;
  for (int k = 0; k < hinges; ++k)
    bend.push_back(plate_angle(k, [&](int i) { return b.x(i); }) -
                   b.data("rest_angle" + std::to_string(k), "rad", "fold angle at rest"));
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
