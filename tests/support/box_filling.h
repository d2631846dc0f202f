// Fillings of cells by boxes.
#pragma once

#include <stark/geometry/solid_mesh.h>

namespace stark::test {

/// Filling by the box [low, high] in a cell, of its own volume or by the given part.
inline CellFilling box_filling(const Vec3& low, const Vec3& high, double part = 0.0) {
  const auto mean_power = [&](int axis, int n) {
    const double a = low[axis], b = high[axis];
    return n == 0 ? 1.0 : n == 1 ? 0.5 * (a + b) : (a * a + a * b + b * b) / 3.0;
  };
  const Vec3 size = high - low;
  if (part == 0.0) part = size.x * size.y * size.z;
  CellFilling filling;
  for (int k = 0; k < 3; ++k)
    for (int j = 0; j < 3; ++j)
      for (int i = 0; i < 3; ++i)
        filling.moments[i + 3 * j + 9 * k] = part * mean_power(0, i) * mean_power(1, j) * mean_power(2, k);
  return filling;
}

}  // namespace stark::test
