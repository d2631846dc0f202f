// One numbering for equal expressions, in whatever order their parts were built. Rounding depends on it: sums
// and products are fused and their operands ordered by number, and C++ leaves the order open in which the
// operands of an expression are built. Phase: model building.
#pragma once

#include <stark/symbolic/expr.h>

#include <cstdint>
#include <functional>

namespace stark::symbolic {

/// What tells an input from the others, in place of its number within its kind.
using InputLabel = std::function<uint64_t(InputKind kind, int index)>;

/// Copy of an expression in `target`, an empty graph: its nodes come in an order that depends on the
/// structure of the expression and the labels only. Inputs keep their numbers; marked cuts are marked in the
/// copy.
Scalar canonical_copy(Graph& target, const Scalar& output, const InputLabel& label);

}  // namespace stark::symbolic
