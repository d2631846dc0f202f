// Lowering of expressions to straight-line code: functions are expanded, products and sums fused.
// Phase: kernel building.
#pragma once

#include <stark/symbolic/expr.h>
#include <stark/symbolic/program.h>

#include <span>
#include <vector>

namespace stark::symbolic {

/// Copies the expressions that `outputs` need from one graph to another, with all inputs first. Quotients of
/// differentiated values become products with a reciprocal, which their derivatives share.
std::vector<NodeId> import_expressions(const Graph& source, std::span<const NodeId> outputs, Graph& target);

/// The same, where leaves stand for nodes of the target: `image` has one entry per node of the source, -1
/// where the node is copied. Every input that `outputs` need must have one.
std::vector<NodeId> import_expressions(const Graph& source, std::span<const NodeId> outputs, Graph& target,
                                       std::vector<NodeId> image);

/// Code for the outputs of all groups, in order. Groups are lowered one after the other, and later ones do
/// not change how earlier ones are rounded: the energy is the same in every kernel of a potential.
Program lower(const Graph& graph, std::span<const std::vector<NodeId>> groups);

}  // namespace stark::symbolic
