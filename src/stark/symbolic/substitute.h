// Rewriting expressions of one graph in another one, with other expressions for their inputs.
// Phase: model building.
#pragma once

#include <stark/symbolic/expr.h>

#include <functional>
#include <span>
#include <vector>

namespace stark::symbolic {

/// What stands for input number `index` of a kind in the copies: an expression of the target graph or a
/// literal.
using InputSubstitution = std::function<Scalar(InputKind kind, int index)>;

/// The expressions with other inputs, one for each of `outputs`, which are of one graph or literals. Asks for
/// the inputs that occur, once each. Cuts that were marked in the source (Graph::mark_stage) are marked in
/// the copies.
std::vector<Scalar> substitute(std::span<const Scalar> outputs, const InputSubstitution& input);

/// What stands for total(operand) in the copies.
using TotalSubstitution = std::function<Scalar(NodeId operand)>;

/// The same with something else for totals, whose operands are not copied.
Scalar substitute(const Scalar& output, const InputSubstitution& input, const TotalSubstitution& total);

/// The operands of all totals that an expression has, each once, in the order of their numbers; those within
/// others are not looked for.
std::vector<Scalar> totals_in(const Scalar& output);

/// The same of one expression whose nodes are copied in a given order, operands before users.
Scalar substitute(const Scalar& output, std::span<const NodeId> order, const InputSubstitution& input);

}  // namespace stark::symbolic
