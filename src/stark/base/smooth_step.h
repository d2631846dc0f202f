// The cubic from 0 to 1 with level ends.
#pragma once

#include <algorithm>

namespace stark {

/// 3 t^2 - 2 t^3 on [0, 1], 0 below and 1 above.
inline double smooth_step(double t) {
  t = std::clamp(t, 0.0, 1.0);
  return t * t * (3.0 - 2.0 * t);
}

}  // namespace stark
