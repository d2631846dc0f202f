#include <stark/sim/registry.h>

namespace stark {

std::vector<PotentialDefinition> registered_potentials() {
  return {
#define STARK_POTENTIAL(name) models::name(),
#define STARK_SOLID_LAW(name) tet4(models::name()),
#define STARK_SHELL_LAW(name) triangle3(models::name()),
#include <stark/sim/registry.inc>
#undef STARK_POTENTIAL
#undef STARK_SOLID_LAW
#undef STARK_SHELL_LAW
  };
}

#define STARK_POTENTIAL(name)
#define STARK_SOLID_LAW(name) models::name(),
#define STARK_SHELL_LAW(name)
std::vector<SolidLaw> registered_solid_laws() {
  return {
#include <stark/sim/registry.inc>
  };
}
#undef STARK_SOLID_LAW
#undef STARK_SHELL_LAW

#define STARK_SOLID_LAW(name)
#define STARK_SHELL_LAW(name) models::name(),
std::vector<ShellLaw> registered_shell_laws() {
  return {
#include <stark/sim/registry.inc>
  };
}
#undef STARK_POTENTIAL
#undef STARK_SOLID_LAW
#undef STARK_SHELL_LAW

}  // namespace stark
