#include <stark/sim/model/state_history.h>

namespace stark {

void begin_history(State& state) {
  state.previous_time_step = 0.0;
  state.previous_point_position = state.point_position;
  for (std::vector<Vec3>* field : {&state.point_increment, &state.point_contact_increment, &state.point_lag})
    field->assign(state.point_position.size(), Vec3{});
  state.previous_body_position = state.body_position;
  state.previous_body_rotation = state.body_rotation;
  state.previous_body_angular_velocity = state.body_angular_velocity;
  for (std::vector<Vec3>* field :
       {&state.body_increment, &state.body_contact_increment, &state.body_lag, &state.body_spin_increment,
        &state.body_spin_contact_increment, &state.body_spin_lag})
    field->assign(state.body_position.size(), Vec3{});
  state.previous_joint_rate = state.joint_rate;
  state.joint_carried.assign(state.joint_force.size(), 0.0);
}

void drop_history(State& state) {
  state.previous_time_step = 0.0;
  for (std::vector<Vec3>* field :
       {&state.previous_point_position, &state.point_increment, &state.point_contact_increment,
        &state.point_lag, &state.previous_body_position, &state.previous_body_angular_velocity,
        &state.body_increment, &state.body_contact_increment, &state.body_lag, &state.body_spin_increment,
        &state.body_spin_contact_increment, &state.body_spin_lag})
    field->clear();
  state.previous_body_rotation.clear();
  state.previous_joint_rate.clear();
  state.joint_carried.clear();
}

State with_history(State state, bool keeps) {
  const bool has_any = !state.previous_point_position.empty() || !state.previous_body_position.empty();
  if (keeps && !has_any) begin_history(state);
  if (!keeps && has_any) drop_history(state);
  return state;
}

}  // namespace stark
