// What materials remember: internal variables of all energies in the state, one batch after the other. An
// attempt at a step reads them, an accepted one updates them (step phases 1 and 6). [theory eq. 10b]
#pragma once

#include <span>
#include <vector>

#include <stark/base/math.h>
#include <stark/sim/energies.h>

namespace stark {

/// Values that the batches have, in the order of State::internal_variable.
std::vector<double> internal_values(const Energies& energies);

/// Gives the batches the values of a state; nothing to do where there are none.
void set_internal(Energies& energies, std::span<const double> values);

/// Batches have the values of a state as long as this lives, and then again those that they had: between
/// steps those at the start of the last one, whose forces sensors read.
class InternalOfState {
 public:
  InternalOfState(Energies& energies, std::span<const double> values);
  ~InternalOfState() { set_internal(energies_, before_); }
  InternalOfState(const InternalOfState&) = delete;
  InternalOfState& operator=(const InternalOfState&) = delete;

 private:
  Energies& energies_;
  std::vector<double> before_;
};

/// Values after a step that ends at x; x by site [m].
std::vector<double> updated_internal(const Energies& energies, std::span<const Vec3> x);

/// Throws InvalidArgument for internal variables that depend on the time step: bdf2 measures rates over
/// another time, which they have no history for.
void refuse_rates_of_internal(const Energies& energies);

}  // namespace stark
