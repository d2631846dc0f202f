// Histories of states: begun anew, left out, kept.
#include <doctest/doctest.h>
#include <stark/sim/model/state_history.h>

using namespace stark;

namespace {

State state_of_two_points_and_a_body() {
  State state;
  state.point_position = {{1.0, 2.0, 3.0}, {4.0, 5.0, 6.0}};
  state.point_velocity = {{0.1, 0.0, 0.0}, {0.0, 0.2, 0.0}};
  state.body_position = {{7.0, 8.0, 9.0}};
  state.body_velocity = {{0.3, 0.0, 0.0}};
  state.body_rotation = {Mat3::identity()};
  state.body_angular_velocity = {{0.0, 0.0, 2.0}};
  state.joint_rate = {0.5};
  return state;
}

}  // namespace

TEST_CASE("a history that begins has no step before and as many entries as there are points and bodies") {
  State state = state_of_two_points_and_a_body();
  state.previous_time_step = 0.01;
  begin_history(state);
  CHECK(state.previous_time_step == 0.0);
  CHECK(state.previous_point_position.size() == 2);
  CHECK(state.point_lag.size() == 2);
  CHECK(state.previous_body_rotation.size() == 1);
  CHECK(state.body_spin_lag.size() == 1);
  CHECK(state.previous_joint_rate == state.joint_rate);
}

TEST_CASE("what begins and is left out again leaves the state as it was, bit for bit") {
  const State before = state_of_two_points_and_a_body();
  State state = before;
  begin_history(state);
  CHECK(first_difference(state, before) == "previous_point_position");
  drop_history(state);
  CHECK(state == before);
}

TEST_CASE("a history that is kept stays as it is") {
  State state = with_history(state_of_two_points_and_a_body(), true);
  state.previous_time_step = 0.02;
  state.previous_point_position[0] = {-1.0, 0.0, 0.0};
  CHECK(with_history(state, true) == state);
  CHECK(with_history(state, false) == state_of_two_points_and_a_body());
}
