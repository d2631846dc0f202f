#include <stark/sim/step/time_marks.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include <stark/base/error.h>
#include <stark/base/settings.h>

namespace stark {

namespace {

double mark(const State& state, int64_t count) {
  return std::fma(static_cast<double>(count), state.mark_step, state.mark_origin);
}

double last_mark(const State& state) { return mark(state, state.mark_count); }
double next_mark(const State& state) { return mark(state, state.mark_count + 1); }

/// Difference of times [s] that is rounding: also that of the times themselves.
double rounding(const State& state, double step) {
  return std::max(kTimeSliver * step, 4.0 * std::numeric_limits<double>::epsilon() * state.time);
}

/// [s] Between marks, what is left of the step whose parts are under way.
double way_to_next_mark(const State& state) {
  return state.time == last_mark(state) ? state.mark_step : next_mark(state) - state.time;
}

PlannedStep plan(const State& state, double limit, double turning) {
  double way = way_to_next_mark(state);
  const bool is_limited = limit < way - rounding(state, way);
  if (is_limited) way = limit;
  const double longest = state.time_step;
  if (turning < (1.0 - kTimeSliver) * std::min(longest, way))
    return {turning, end_of_step(state, turning), true};
  const double parts = std::max(1.0, std::ceil((way - rounding(state, way)) / longest));
  const bool is_cut = is_limited && parts == 1.0;
  double length = way / parts;
  // Equal bits for steps of equal length: the way between two times is rounded.
  if (!is_cut && std::fabs(length - longest) <= rounding(state, longest)) length = longest;
  return {length, end_of_step(state, length), is_cut};
}

}  // namespace

PlannedStep plan_step(const State& state, double limit, double turning) {
  const PlannedStep planned = plan(state, limit, turning);
  if (!(planned.end > state.time))
    throw InvalidArgument("step: its length of " + quantity_text(planned.length, "s") +
                          " is lost in the rounding of the time, " + quantity_text(state.time, "s") +
                          ": must be longer; check max_time_step, and the time of a state that was loaded");
  return planned;
}

double end_of_step(const State& state, double h) {
  const double next = next_mark(state);
  return std::fabs(way_to_next_mark(state) - h) <= rounding(state, h) ? next : state.time + h;
}

void advance_time(State& state, double h, bool is_cut) {
  state.time = end_of_step(state, h);
  if (state.time == next_mark(state)) {
    ++state.mark_count;
  } else if (is_cut) {
    state.mark_origin = state.time;
    state.mark_count = 0;
  }
}

void set_mark_step(State& state, double step) {
  const bool has_marks = last_mark(state) <= state.time && state.time < next_mark(state);
  if (state.mark_step == step && has_marks) return;
  state.mark_step = step;
  state.mark_origin = state.time;
  state.mark_count = 0;
}

}  // namespace stark
