// An actuator of a scene: a definition (mechanics/actuator.h) on a coordinate of a joint, with its values.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include <stark/mechanics/actuator.h>
#include <stark/sim/scene/ids.h>

namespace stark {

/// A coordinate of a joint by name; empty: the only one that the joint has.
struct CoordinateName {
  JointId joint{};
  std::string name{};
};

struct ActuatorDescription {
  std::string name{};  ///< unique among the actuators of the scene; empty: the definition's, numbered
  std::shared_ptr<const ActuatorDefinition> definition{};
  std::vector<CoordinateName> on{};        ///< as many as the definition acts on: one, or two for a gear
  std::map<std::string, double> values{};  ///< those that have no default, and others
  bool enabled = true;
};

/// Throws InvalidArgument where values are not in the order that the definition asks for.
void check_order(const std::string& owner, const ActuatorDefinition& definition,
                 const std::map<std::string, double>& values);

}  // namespace stark
