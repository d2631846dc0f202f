// Numbers of a scene that look as if they were given in other units than SI: densities, moduli, sizes,
// distances, friction, gravity, time steps. Nothing here is forbidden; who makes a simulation is warned of
// it, and a failed step is explained with it.
#pragma once

#include <string>
#include <vector>

#include <stark/sim/scene/scene.h>

namespace stark {

/// One sentence for each suspicion, with the object, the value, what is ordinary and the unit that is meant.
/// Fixed and scripted bodies may have any size.
std::vector<std::string> check_units(const Scene& scene, const Settings& settings);

}  // namespace stark
