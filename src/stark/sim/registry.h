// All potentials and constitutive laws of the library by name (sim/registry.inc).
#pragma once

#include <vector>

#include <stark/mechanics/constitutive_law.h>
#include <stark/mechanics/potential.h>

namespace stark {

namespace models {
#define STARK_POTENTIAL(name) PotentialDefinition name();
#define STARK_SOLID_LAW(name) SolidLaw name();
#define STARK_SHELL_LAW(name) ShellLaw name();
#include <stark/sim/registry.inc>
#undef STARK_POTENTIAL
#undef STARK_SOLID_LAW
#undef STARK_SHELL_LAW
}  // namespace models

/// The potentials, and the laws on their linear elements: tetrahedra and triangles.
std::vector<PotentialDefinition> registered_potentials();
std::vector<SolidLaw> registered_solid_laws();
std::vector<ShellLaw> registered_shell_laws();

}  // namespace stark
