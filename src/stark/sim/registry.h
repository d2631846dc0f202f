// All potentials of the library by name (sim/registry.inc).
#pragma once

#include <vector>

#include <stark/mechanics/potential.h>

namespace stark {

namespace models {
#define STARK_POTENTIAL(name) PotentialDefinition name();
#include <stark/sim/registry.inc>
#undef STARK_POTENTIAL
}  // namespace models

std::vector<PotentialDefinition> registered_potentials();

}  // namespace stark
