// What judges of a failed step say (diagnosis.h), and those about energies of users.
#pragma once

#include <string>
#include <vector>

#include <stark/sim/step/diagnosis.h>

namespace stark {

struct Verdict {
  FailureCause cause = FailureCause::None;  ///< none: not it
  std::string finding, remedy;
  std::vector<std::string> bodies{};
};

/// "a, b and c".
std::string listed(const std::vector<std::string>& names);

/// Of energies that grow without bound, have a kink or jump.
Verdict judge_users_energies(const StepEvidence& e);

/// Names the users' energies that act on what is out of balance and how to look into them; empty without any.
std::string acting_text(const StepEvidence& e);

}  // namespace stark
