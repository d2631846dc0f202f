// Times of steps: on correctly rounded marks, whatever was cut or taken again before.
#include <doctest/doctest.h>

#include <cmath>
#include <limits>

#include <stark/sim/simulation.h>

using namespace stark;

namespace {

constexpr double kNoLimit = 1e300;
constexpr double kInf = std::numeric_limits<double>::infinity();

State at_zero(double step) {
  State state;
  state.time_step = step;
  set_mark_step(state, step);
  return state;
}

PlannedStep advance(State& state, double limit = kNoLimit, double turning = kInf) {
  const PlannedStep planned = plan_step(state, limit, turning);
  CHECK(end_of_step(state, planned.length) == planned.end);
  advance_time(state, planned.length, planned.is_cut);
  CHECK(state.time == planned.end);
  return planned;
}

/// As Simulation does after a step was taken with h instead.
void advance_halved(State& state, double h) {
  advance_time(state, h, false);
  state.time_step = h;
}

void advance_and_grow(State& state, double step) {
  if (!advance(state).is_cut) state.time_step = std::fmin(step, 2.0 * state.time_step);
}

}  // namespace

TEST_CASE("a million steps end on products rounded once") {
  for (const double step : {0.005, 1.0 / 60.0, 1e-3, 1.0 / 24.0, 0.0123456789, 1e-6}) {
    CAPTURE(step);
    State state = at_zero(step);
    bool exact = true, whole = true;
    for (int64_t k = 1; k <= 1000000; ++k) {
      const PlannedStep planned = plan_step(state, kNoLimit, kInf);
      advance_time(state, planned.length, planned.is_cut);
      whole = whole && planned.length == step;
      exact = exact && state.time == static_cast<double>(k) * step;
    }
    CHECK(whole);
    CHECK(exact);
  }
  CHECK(441 * 0.005 == 2.205);
}

TEST_CASE("what is left of a run is a whole step up to rounding") {
  State state = at_zero(0.005);
  for (int k = 1; k <= 441; ++k) {
    const PlannedStep planned = advance(state, 2.205 - state.time);
    REQUIRE(planned.length == 0.005);
    REQUIRE_FALSE(planned.is_cut);
  }
  CHECK(state.time == 2.205);
  CHECK(plan_step(state, 0.005 * (1.0 - 1e-10), kInf).length == 0.005);
  CHECK(plan_step(state, 0.005 * (1.0 - 1e-8), kInf).is_cut);
}

TEST_CASE("days of steps meet their ends in whole steps") {
  State state = at_zero(1e-3);
  state.mark_count = 200000000;
  state.time = 200000.0;
  CHECK_FALSE(plan_step(state, 200000.001 - state.time, kInf).is_cut);  // off by 1.4e-8 of a step
}

TEST_CASE("a step that is cut short begins new marks where it ends") {
  State state = at_zero(0.005);
  for (int k = 0; k < 3; ++k) advance(state);
  const PlannedStep planned = advance(state, 0.0172 - state.time);
  CHECK(planned.is_cut);
  CHECK(state.time == 0.0172);
  for (int k = 1; k <= 1000; ++k) {
    REQUIRE(advance(state).length == 0.005);
    REQUIRE(state.time == std::fma(static_cast<double>(k), 0.005, 0.0172));
  }
}

TEST_CASE("parts of a step that failed end on its mark") {
  const double step = 0.01;
  for (const int halvings : {1, 2, 3, 7, 13}) {
    CAPTURE(halvings);
    State state = at_zero(step);
    for (int k = 0; k < 7; ++k) advance(state);
    advance_halved(state, std::ldexp(step, -halvings));
    CHECK(state.mark_count == 7);
    for (int k = 0; state.mark_count < 8; ++k) {
      REQUIRE(k <= halvings);
      advance_and_grow(state, step);
    }
    CHECK(state.time == 8 * step);
    CHECK(state.time_step == step);
    for (int k = 9; k < 1000; ++k) {
      REQUIRE(advance(state).length == step);
      REQUIRE(state.time == k * step);
    }
  }
}

TEST_CASE("parts that fail again do not miss the mark") {
  const double step = 0.01;
  State state = at_zero(step);
  advance_halved(state, 0.0025);  // at 2.5 ms
  advance_and_grow(state, step);  // at 5 ms, the next one would be as long as what is left
  CHECK(state.time_step == 0.005);
  advance_halved(state, 0.00125);  // at 6.25 ms
  int parts = 0;
  for (; state.mark_count == 0; ++parts) advance_and_grow(state, step);
  CHECK(parts == 2);  // of 1.25 and 2.5 ms
  CHECK(state.time == step);
}

TEST_CASE("slow growth is not held back by marks") {
  const double step = 0.01;
  State state = at_zero(step);
  advance_halved(state, 0.005);
  for (int n = 0; n < 8; ++n) {
    CHECK_FALSE(advance(state).is_cut);
    state.time_step = std::fmin(step, 1.5 * state.time_step);
  }
  CHECK(state.time_step == step);
  CHECK(state.time == step * static_cast<double>(state.mark_count));
}

TEST_CASE("turning bodies and short limits begin new marks") {
  State state = at_zero(0.01);
  CHECK(advance(state, kNoLimit, 0.007).length == 0.007);
  CHECK(state.time == 0.007);
  CHECK(advance(state).length == 0.01);
  CHECK(state.time == 0.017);
  // A limit that takes more than one part is met in equal ones.
  advance_halved(state, 0.0025);
  const PlannedStep planned = advance(state, 0.004);
  CHECK(planned.length == 0.002);
  CHECK_FALSE(planned.is_cut);
  CHECK(advance(state, 0.002).is_cut);
}

TEST_CASE("marks follow the step of the settings, and times that were set") {
  State state = at_zero(0.01);
  for (int k = 0; k < 3; ++k) advance(state);
  const State before = state;
  set_mark_step(state, 0.01);
  CHECK(state == before);
  set_mark_step(state, 0.004);
  state.time_step = 0.004;
  advance(state);
  CHECK(state.time == 0.03 + 0.004);
  state.time = 7.5;
  set_mark_step(state, 0.004);
  advance(state);
  CHECK(state.time == 7.504);
}

TEST_CASE("a step that the rounding of the time swallows is refused") {
  State state = at_zero(0.01);
  CHECK(plan_step(state, 1e-30, kNoLimit).length == 1e-30);
  state.time = state.mark_origin = 1.0;
  CHECK_THROWS_WITH_AS(plan_step(state, 1e-17, kNoLimit),
                       doctest::Contains("its length of 1e-17 s is lost in the rounding of the time, 1 s"),
                       InvalidArgument);
  CHECK(plan_step(state, 1e-12, kNoLimit).end > 1.0);
}
