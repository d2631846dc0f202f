// Scene: checks of actuators.
#include <algorithm>

#include <stark/base/error.h>
#include <stark/sim/scene/scene.h>
#include <stark/sim/scene/validation.h>

namespace stark {

namespace {

/// Unit of the coordinate; completes its name.
std::string resolve(const std::string& owner, const JointDescription& joint, CoordinateName& coordinate) {
  const std::vector<JointOutputs::Coordinate> known = joint_coordinates(*joint.definition);
  std::vector<std::string> names;
  for (const JointOutputs::Coordinate& candidate : known) {
    if (candidate.name == coordinate.name) return candidate.unit;
    names.push_back(candidate.name);
  }
  const std::string which = owner + ": joint '" + joint.name + "' (" + joint.definition->name + ")";
  if (known.empty())
    throw InvalidArgument(which +
                          " has no coordinate to act on; use a joint with one, such as hinge or slider");
  if (!coordinate.name.empty())
    throw InvalidArgument(which + " has no coordinate '" + coordinate.name + "'" +
                          nearest_name_hint(coordinate.name, names));
  if (known.size() == 1) {
    coordinate.name = known[0].name;
    return known[0].unit;
  }
  std::string list;
  for (const std::string& name : names) list += (list.empty() ? "'" : ", '") + name + "'";
  throw InvalidArgument(which + " has the coordinates " + list + ": must name the one to act on");
}

void check_values(const std::string& owner, const std::vector<ActuatorParameter>& parameters,
                  std::map<std::string, double>& values) {
  std::vector<std::string> names;
  for (const ActuatorParameter& parameter : parameters) {
    names.push_back(parameter.name);
    const auto given = values.find(parameter.name);
    if (given == values.end()) {
      if (!parameter.fallback)
        throw InvalidArgument(owner + ": '" + parameter.name + "' [" + parameter.unit +
                              "] is missing: " + parameter.doc);
      values[parameter.name] = *parameter.fallback;
    } else {
      check_number(owner, parameter.name, given->second, parameter.unit, parameter.rule,
                   "it is the " + parameter.doc);
    }
  }
  for (const auto& [name, value] : values)
    if (std::find(names.begin(), names.end(), name) == names.end())
      throw InvalidArgument(owner + ": unknown value '" + name + "'" + nearest_name_hint(name, names) +
                            ": must be an input of the formula; remove it");
}

}  // namespace

void check_order(const std::string& owner, const ActuatorDefinition& definition,
                 const std::map<std::string, double>& values) {
  for (const auto& [low, high] : definition.ordered)
    if (values.at(low) > values.at(high))
      throw InvalidArgument(owner + ": " + low + " = " + quantity_text(values.at(low), "") + " and " + high +
                            " = " + quantity_text(values.at(high), "") + ": " + low + " must not be above " +
                            high + "; to move both, set first the one that widens the range");
}

ActuatorId Scene::add_actuator(ActuatorDescription actuator) {
  if (!actuator.definition || !actuator.definition->formula)
    throw InvalidArgument(
        "actuator '" + actuator.name +
        "': has no definition; take one with find_actuator or make one with define_actuator");
  if (actuator.name.empty()) {
    actuator.name = actuator_names_.next(actuator.definition->name);
  } else if (actuator_names_.contains(actuator.name)) {
    throw InvalidArgument(
        "actuator '" + actuator.name +
        "': the name is taken: names of actuators must be unique in a scene; choose another "
        "or leave it out");
  }
  const std::string owner = "actuator '" + actuator.name + "'";
  const auto expected = static_cast<size_t>(actuator.definition->coordinate_count);
  if (actuator.on.size() != expected)
    throw InvalidArgument(owner + ": on " + std::to_string(actuator.on.size()) + " coordinates: must be on " +
                          std::to_string(expected));
  std::vector<std::string> units;
  for (CoordinateName& coordinate : actuator.on)
    units.push_back(resolve(owner, joint(coordinate.joint), coordinate));
  check_values(owner, actuator_parameters(*actuator.definition, units), actuator.values);
  check_order(owner, *actuator.definition, actuator.values);
  actuator_names_.add(actuator.name);
  actuators_.push_back(std::move(actuator));
  return {static_cast<int32_t>(actuators_.size()) - 1};
}

void Scene::set_actuator_value(ActuatorId id, const std::string& name, double value) {
  ActuatorDescription changed = actuator(id);
  std::vector<std::string> units;
  const std::string owner = "actuator '" + changed.name + "'";
  for (CoordinateName& coordinate : changed.on)
    units.push_back(resolve(owner, joint(coordinate.joint), coordinate));
  changed.values[name] = value;
  check_values(owner, actuator_parameters(*changed.definition, units), changed.values);
  check_order(owner, *changed.definition, changed.values);
  actuators_[id.index] = std::move(changed);
}

void Scene::set_actuator_enabled(ActuatorId id, bool enabled) {
  actuator(id);
  actuators_[id.index].enabled = enabled;
}

const ActuatorDescription& Scene::actuator(ActuatorId actuator) const {
  if (actuator.index < 0 || actuator.index >= static_cast<int32_t>(actuators_.size()))
    throw InvalidArgument("actuator id " + std::to_string(actuator.index) + ": must be in [0, " +
                          std::to_string(actuators_.size()) +
                          ") for this scene; use the ids that add_actuator returned");
  return actuators_[actuator.index];
}

}  // namespace stark
