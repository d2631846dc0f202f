// Time integrators as coefficients: how the velocity and the inertia of a step follow from positions (step
// phase 2). All of them are minimisations of the same potential (theory eq. 1), with
//     x_bar = x^n + c (x^n - x^{n-1}),   v = (x - x_bar) / s,   x_hat = x_bar + s v_bar,
// v_bar being extrapolated from the last velocities as x_bar is from positions. Damping, friction and user
// energies measure displacements from x_bar over the time s, so that they see exactly the velocity v.
#pragma once

#include <vector>

#include <stark/base/math.h>

namespace stark {

struct TimeStencil {
  double scale = 0.0;    ///< s [s]
  double history = 0.0;  ///< c, zero when the step before has no say

  /// now + c (now - before); `now` in every bit when the history has no say.
  template <typename T>
  T reference(const T& now, const T& before) const {
    return history == 0.0 ? now : now + (now - before) * history;
  }
};

/// s = h, c = 0: order 1, strongly damping, no memory.
TimeStencil implicit_euler(double h);

/// Backward differences of order 2 with variable steps: w = h / h_before, s = h (1 + w)/(1 + 2 w) and
/// c = w^2/(1 + 2 w); 2h/3 and 1/3 for equal steps. [Hairer, Norsett, Wanner 1993, sec. III.5]
TimeStencil bdf2(double h, double h_before);

/// Steps that grow faster than this start again with implicit Euler: zero-stability of BDF2 ends at 2.41.
inline constexpr double kLargestBdf2Ratio = 2.0;

}  // namespace stark
