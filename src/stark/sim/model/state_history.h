// What a state keeps of a step ago for bdf2: begun where there is none, left out where no step asks for it.
#pragma once

#include <stark/mechanics/state.h>

namespace stark {

/// Gives a state the arrays that bdf2 keeps, as of one without a step before: the next one is of implicit
/// Euler.
void begin_history(State& state);

/// Takes these arrays out of a state.
void drop_history(State& state);

/// A state of any integrator as one of a simulation that `keeps` a history, or not: begun, left out, or as it
/// is.
State with_history(State state, bool keeps);

}  // namespace stark
