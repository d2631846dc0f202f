#include <stark/sim/registry.h>

namespace stark {

std::vector<PotentialDefinition> registered_potentials() {
  return {
#define STARK_POTENTIAL(name) models::name(),
#include <stark/sim/registry.inc>
#undef STARK_POTENTIAL
  };
}

}  // namespace stark
