// Kernels of energies whose bits do not depend on the order in which the formula was written down. Phase:
// model building.
#pragma once

#include <cstdint>

#include <stark/mechanics/potential.h>
#include <stark/symbolic/canonical.h>

namespace stark {

/// How many numbers a kernel takes of each kind, those that do not occur among them.
struct InputCounts {
  int unknowns = 0, elements = 0, uniforms = 0;
};

InputCounts input_counts(const PotentialBuilder& builder);

/// What tells the inputs of a builder from one another. Uniform inputs beyond its fields go by their numbers.
symbolic::InputLabel labels_of(const PotentialBuilder& builder);

/// Adds inputs to a graph until it has so many.
void add_inputs(const InputCounts& counts, symbolic::Graph& graph);

symbolic::Kernel compile_canonical(const symbolic::Scalar& energy, const symbolic::InputLabel& labels,
                                   const InputCounts& counts, symbolic::Backend backend);

}  // namespace stark
