// Sheets in stacks whose contact distance is far above their thickness. Internal to sim.
#pragma once

#include <string>
#include <vector>

#include <stark/sim/scene/scene.h>

namespace stark {

/// A warning, or none: three cloths or more over each other that nobody gave a contact distance, and whose
/// automatic one is more than twice their thickness. Such stacks are too thick, and slow when pressed
/// together: each sheet then touches others through those between.
std::vector<std::string> check_thin_sheets(const Scene& scene, const Settings& settings);

}  // namespace stark
