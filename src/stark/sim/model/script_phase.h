// What a scripted body or frame does, as State::script_remaining says it.
#pragma once

#include <cstdint>

namespace stark {

enum class ScriptPhase : uint8_t {
  Velocity,  ///< moves at its velocity
  Moving,    ///< is on its way to a pose, which it reaches after script_remaining
  Resting    ///< rests at the last pose it was given
};

/// Values of script_remaining that are no time.
inline constexpr double kMovesAtVelocity = 0.0, kRestsAtPose = -1.0;

constexpr ScriptPhase script_phase(double remaining) {
  if (remaining == kMovesAtVelocity) return ScriptPhase::Velocity;
  return remaining > 0.0 ? ScriptPhase::Moving : ScriptPhase::Resting;
}

}  // namespace stark
