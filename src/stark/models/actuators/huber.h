// What the formulas of several actuators share.
#pragma once

#include <stark/mechanics/define.h>

namespace stark::models {

/// Function whose slope is x up to |x| = cap and +-cap beyond: the energy of an effort that saturates.
inline Scalar huber(const Scalar& x, const Scalar& cap) {
  return select(abs(x) < cap, 0.5 * square(x), cap * (abs(x) - 0.5 * cap));
}

}  // namespace stark::models
