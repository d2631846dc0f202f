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

/// Size of an element, or length of an edge, over that at rest below which it is pressed flat.
inline constexpr double kFlat = 1e-3;

std::string element_text(const StrainedElement& element);

/// Of stiffnesses that differ too much: those of two bodies, or of two parts of one.
Verdict judge_contrast(const StepEvidence& e);

/// Of energies that grow without bound, have a kink or jump.
Verdict judge_users_energies(const StepEvidence& e);

/// Names the users' energies that act on what is out of balance and how to look into them; empty without any.
std::string acting_text(const StepEvidence& e);

}  // namespace stark
