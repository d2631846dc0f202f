// Actuators of a model: one group of the constraint set for each definition on the same kinds of coordinates.
#include <algorithm>

#include <stark/sim/model/model_builder.h>

namespace stark {

namespace {

/// What actuators must share to be elements of one batch. Addresses tell apart and decide no order.
struct CoordinateKey {
  const JointDefinition* joint;
  int coordinate;
  FrameKind a, b;
  auto operator<=>(const CoordinateKey&) const = default;
};
struct Key {
  const ActuatorDefinition* definition;
  std::vector<CoordinateKey> on;
  auto operator<=>(const Key&) const = default;
};

}  // namespace

int Model::Builder::coordinate_index(const CoordinateName& coordinate) const {
  const std::vector<JointOutputs::Coordinate> known =
      joint_coordinates(*scene.joint(coordinate.joint).definition);
  const auto found = std::ranges::find(known, coordinate.name, &JointOutputs::Coordinate::name);
  return static_cast<int>(found - known.begin());
}

void Model::Builder::add_actuators(std::vector<ConstraintGroup>& groups) {
  const auto first_number = static_cast<int32_t>(scene.joints().size());
  std::map<Key, size_t> index;
  std::vector<std::vector<int32_t>> members;
  std::vector<std::shared_ptr<const Actuator>> laws;
  for (int32_t k = 0; k < static_cast<int32_t>(scene.actuators().size()); ++k) {
    const ActuatorDescription& actuator = scene.actuators()[k];
    Key key{actuator.definition.get(), {}};
    std::vector<JointCoordinate> on;
    for (const CoordinateName& coordinate : actuator.on) {
      const JointDescription& joint = scene.joint(coordinate.joint);
      on.push_back(
          {joint.definition.get(), coordinate_index(coordinate), kind_of(joint.a), kind_of(joint.b)});
      key.on.push_back({on.back().joint, on.back().index, on.back().a, on.back().b});
    }
    const auto [entry, is_new] = index.try_emplace(key, members.size());
    if (is_new) {
      members.emplace_back();
      laws.push_back(std::make_shared<const Actuator>(*actuator.definition, on, backend()));
    }
    members[entry->second].push_back(k);
    model.actuators_.push_back({.law = laws[entry->second], .coordinates = {}, .is_angle = {}});
    // A stop feels the two sides of its joint; a gear the far sides of both joints.
    const int32_t first = actuator.on.front().joint.index, last = actuator.on.back().joint.index;
    model.joint_sides_.push_back(model.joint_sides_[2 * first + (first == last ? 0 : 1)]);
    model.joint_sides_.push_back(model.joint_sides_[2 * last + 1]);
  }
  for (size_t g = 0; g < laws.size(); ++g) {
    groups.push_back(make_actuator_group(laws[g], members[g]));
    for (const int32_t k : members[g]) groups.back().joints.push_back(first_number + k);
  }
}

ConstraintGroup Model::Builder::make_actuator_group(const std::shared_ptr<const Actuator>& actuator,
                                                    const std::vector<int32_t>& members) const {
  std::vector<int32_t> stencils;
  for (const int32_t k : members)
    for (int c = 0, p = 0; c < actuator->coordinate_count(); ++c)
      for (int i = 0; i < actuator->point_counts()[c]; ++i, ++p)
        stencils.push_back(joint_sites[scene.actuators()[k].on[c].joint.index][actuator->points()[p]]);
  ConstraintGroup group{actuator, PotentialBatch(actuator->potential()), {}};
  group.batch.resize(stencils);
  for (size_t e = 0; e < members.size(); ++e)
    for (int c = 0; c < actuator->coordinate_count(); ++c) {
      const JointDescription& joint = scene.joint(scene.actuators()[members[e]].on[c].joint);
      set_joint_fields(group.batch, static_cast<int64_t>(e), joint, actuator_joint_prefix(c));
    }
  return group;
}

void Model::Builder::locate_actuators() {
  int64_t value = 0, memory = 0, effort = 0;
  for (size_t k = 0; k < model.actuators_.size(); ++k) {
    ModelActuator& actuator = model.actuators_[k];
    actuator.value = value;
    actuator.memory = memory;
    actuator.effort = effort;
    value += static_cast<int64_t>(actuator.law->parameters().size());
    memory += static_cast<int64_t>(actuator.law->memories().size());
    effort += actuator.law->coordinate_count();
    for (const CoordinateName& coordinate : scene.actuators()[k].on) {
      const ConstraintSet::Place& place = energies.constraints.place(coordinate.joint.index);
      const int index = coordinate_index(coordinate);
      actuator.coordinates.push_back(place.coordinate + index);
      actuator.is_angle.push_back(
          energies.constraints.groups()[place.group].joint->coordinates()[index].unit == "rad");
    }
  }
  model.initial_state_.actuator_memory.assign(memory, 0.0);
  model.initial_state_.actuator_effort.assign(effort, 0.0);
}

void Model::Builder::set_initial_actuators() {
  State& state = model.initial_state_;
  for (size_t k = 0; k < model.actuators_.size(); ++k) {
    const ActuatorDescription& actuator = scene.actuators()[k];
    for (const ActuatorParameter& parameter : model.actuators_[k].law->parameters())
      state.actuator_value.push_back(actuator.values.at(parameter.name));
    state.actuator_enabled.push_back(actuator.enabled ? 1.0 : 0.0);
  }
}

}  // namespace stark
