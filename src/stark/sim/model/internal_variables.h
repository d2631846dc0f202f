// What materials remember: internal variables of all energies in the state, one batch after the other. An
// attempt at a step reads them, an accepted one updates them (step phases 1 and 6). [theory eq. 10b]
#pragma once

#include <span>
#include <string>
#include <vector>

#include <stark/base/math.h>
#include <stark/sim/model/energies.h>

namespace stark {

/// What the elements of a body remember of one thing.
struct InternalVariable {
  std::string name, unit, doc;
  int width = 1;               ///< numbers of a value
  int points = 1;              ///< quadrature points of an element
  std::vector<double> values;  ///< [element][point][width]
};

/// What each element of a batch remembers in a state of which `values` are those of the batch.
std::vector<InternalVariable> internal_variables(const Potential& potential, int points,
                                                 std::span<const double> values);

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

/// What a step starts from: positions [m] and velocities [m/s] of the sites, its time [s], and the time step
/// that stored energies are measured with [s].
struct FlowStart {
  std::span<const Vec3> x, v;
  double time = 0.0, full_step = 0.0;
};

/// Whether internal variables of any energy flow at a rate.
bool has_flow(const Energies& energies);
/// Lets those that do flow for half of a step of length h at the strains that it starts from; the other half
/// is that of the energy at its end. Changes what the batches have as previous positions and as times.
/// [theory eq. 26d]
void flow_for_half(Energies& energies, const FlowStart& start, double h);

}  // namespace stark
