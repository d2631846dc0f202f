// All potentials, constitutive laws, joints and actuators of the library by name (sim/scene/registry.inc).
#pragma once

#include <memory>
#include <vector>

#include <stark/mechanics/actuator.h>
#include <stark/mechanics/constitutive_law.h>
#include <stark/mechanics/joint.h>
#include <stark/mechanics/potential.h>
#include <stark/mechanics/rod_law.h>

namespace stark {

namespace models {
#define STARK_POTENTIAL(name) PotentialDefinition name();
#define STARK_SOLID_LAW(name) SolidLaw name();
#define STARK_SHELL_LAW(name) ShellLaw name();
#define STARK_ROD_LAW(name) RodLaw name();
#define STARK_JOINT(name) JointDefinition name();
#define STARK_ACTUATOR(name) ActuatorDefinition name();
#include <stark/sim/scene/registry.inc>
}  // namespace models

/// The potentials, and the laws on their linear elements: tetrahedra, triangles and segments.
std::vector<PotentialDefinition> registered_potentials();
/// Throws InvalidArgument for unknown names, with the nearest one as a hint.
PotentialDefinition find_potential(const std::string& name);
std::vector<SolidLaw> registered_solid_laws();
std::vector<ShellLaw> registered_shell_laws();
std::vector<RodLaw> registered_rod_laws();
/// Shared by all joints that are made of them.
const std::vector<std::shared_ptr<const JointDefinition>>& registered_joints();
/// Throws InvalidArgument for unknown names, with the nearest one as a hint.
std::shared_ptr<const JointDefinition> find_joint(const std::string& name);
/// The same for actuators.
const std::vector<std::shared_ptr<const ActuatorDefinition>>& registered_actuators();
std::shared_ptr<const ActuatorDefinition> find_actuator(const std::string& name);

}  // namespace stark
