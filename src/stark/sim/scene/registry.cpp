#include <stark/sim/scene/registry.h>

#include <stark/base/error.h>
#include <stark/base/settings.h>

namespace stark {

std::vector<PotentialDefinition> registered_potentials() {
  return {
#define STARK_POTENTIAL(name) models::name(),
#define STARK_SOLID_LAW(name) tet4(models::name()),
#define STARK_SHELL_LAW(name) triangle3(models::name()),
#define STARK_ROD_LAW(name) rod_segment(models::name()),
#include <stark/sim/scene/registry.inc>
  };
}

std::vector<SolidLaw> registered_solid_laws() {
  return {
#define STARK_SOLID_LAW(name) models::name(),
#include <stark/sim/scene/registry.inc>
  };
}

std::vector<ShellLaw> registered_shell_laws() {
  return {
#define STARK_SHELL_LAW(name) models::name(),
#include <stark/sim/scene/registry.inc>
  };
}

std::vector<RodLaw> registered_rod_laws() {
  return {
#define STARK_ROD_LAW(name) models::name(),
#include <stark/sim/scene/registry.inc>
  };
}

const std::vector<std::shared_ptr<const JointDefinition>>& registered_joints() {
  static const std::vector<std::shared_ptr<const JointDefinition>> joints{
#define STARK_JOINT(name) std::make_shared<const JointDefinition>(models::name()),
#include <stark/sim/scene/registry.inc>
  };
  return joints;
}

const std::vector<std::shared_ptr<const ActuatorDefinition>>& registered_actuators() {
  static const std::vector<std::shared_ptr<const ActuatorDefinition>> actuators{
#define STARK_ACTUATOR(name) std::make_shared<const ActuatorDefinition>(models::name()),
#include <stark/sim/scene/registry.inc>
  };
  return actuators;
}

namespace {

template <typename Definition>
std::shared_ptr<const Definition> find_by_name(
    const std::vector<std::shared_ptr<const Definition>>& definitions, const std::string& name,
    const std::string& kind) {
  std::vector<std::string> names;
  for (const auto& definition : definitions) {
    if (definition->name == name) return definition;
    names.push_back(definition->name);
  }
  throw InvalidArgument("unknown " + kind + " '" + name + "'" + nearest_name_hint(name, names) +
                        ": must be one of the " + kind + "s in docs/reference.md");
}

}  // namespace

PotentialDefinition find_potential(const std::string& name) {
  std::vector<std::string> names;
  for (PotentialDefinition& definition : registered_potentials()) {
    if (definition.name == name) return definition;
    names.push_back(definition.name);
  }
  throw InvalidArgument("potential '" + name + "' is not registered" + nearest_name_hint(name, names));
}

std::shared_ptr<const JointDefinition> find_joint(const std::string& name) {
  return find_by_name(registered_joints(), name, "joint");
}

std::shared_ptr<const ActuatorDefinition> find_actuator(const std::string& name) {
  return find_by_name(registered_actuators(), name, "actuator");
}

}  // namespace stark
