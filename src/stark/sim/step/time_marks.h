// The times that steps end at (step phases 0 and 6). Full steps end on marks,
//     t_k = t_origin + k step,   rounded once,
// so that times do not drift, however many steps there are. What fails is halved, and its parts end on the
// next mark; a step that the caller or a turning body cuts short begins new marks where it ends.
#pragma once

#include <stark/mechanics/state.h>

namespace stark {

/// Share of a step below which a difference of times is rounding, not a step to take.
inline constexpr double kTimeSliver = 1e-9;

struct PlannedStep {
  double length = 0.0;  ///< [s]
  double end = 0.0;     ///< simulated time [s]
  bool is_cut = false;  ///< at the limit that was given: ends off the marks
};

/// The coming step: up to the next mark, in equal parts of at most state.time_step where it is shorter, or up
/// to `limit` [s] from now; `turning` [s] is how long scripted bodies may turn in it. Throws InvalidArgument
/// where the time would not advance.
PlannedStep plan_step(const State& state, double limit, double turning);

/// Simulated time [s] at the end of a step of length h: the next mark, where h leads there up to rounding.
double end_of_step(const State& state, double h);

/// Sets the time to the end of a step of length h; after one that is cut short, marks count from there.
void advance_time(State& state, double h, bool is_cut);

/// Marks are `step` [s] apart; they count from now on unless they are already so, and the time is between
/// two.
void set_mark_step(State& state, double step);

}  // namespace stark
