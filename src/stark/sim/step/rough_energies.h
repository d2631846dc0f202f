// Kinks and jumps of users' energies near where a step failed, and which energies act there. Phase: after the
// last attempt at a step.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include <stark/sim/step/step_evidence.h>

namespace stark {

/// Users' energies that act on what is out of balance by these forces, by name.
std::vector<std::string> energies_acting(const FailedStep& step, std::span<const double> gradient);

/// The one of them whose forces or energy jump most within the last Newton step, forth and back, or the
/// motion of the step; none where no jump is of the size of what is out of balance.
std::optional<RoughEnergy> find_rough_energy(const FailedStep& step, std::span<const double> gradient);

}  // namespace stark
