// Kernels of energies whose bits do not depend on the order in which the formula was written down. Phase:
// model building.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include <stark/base/error.h>
#include <stark/mechanics/potential.h>
#include <stark/symbolic/canonical.h>

namespace stark {

/// Numbers of all fields.
template <typename Field>
int total_width(const std::vector<Field>& fields) {
  return fields.empty() ? 0 : fields.back().offset + fields.back().width;
}

/// Field that holds input number `index` of its kind.
template <typename Field>
const Field& field_at(const std::vector<Field>& fields, int index) {
  const auto next = std::ranges::upper_bound(fields, index, {}, &Field::offset);
  STARK_CHECK(next != fields.begin());
  return *std::prev(next);
}

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
