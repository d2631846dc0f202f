// Derivatives of an expression with respect to any values it is made of, as expressions of the same graph.
// Phase: model building.
#pragma once

#include <stark/symbolic/expr.h>

#include <span>
#include <vector>

namespace stark::symbolic {

/// d output / d target for every target; new nodes of the graph. A target is a variable: what lies behind it
/// is not looked at, and other targets count as constants. A computed target must occur in the graph of the
/// output as it is: simplification may have dissolved it, as 2 x in (2 x) (2 x) = 4 (x x). Targets may
/// repeat. Reverse sweep, cost of a small multiple of the expression.
std::vector<NodeId> partial_derivatives(Graph& graph, NodeId output, std::span<const NodeId> targets);

/// Second derivatives, upper triangle row by row (i <= j), by edge pushing.
std::vector<NodeId> second_partial_derivatives(Graph& graph, NodeId output, std::span<const NodeId> targets);

/// d outputs / d inputs, row by row. The inputs are leaves. Reverse or forward mode, whichever counts fewer
/// operations.
std::vector<NodeId> jacobian(Graph& graph, std::span<const NodeId> outputs, std::span<const NodeId> inputs);

}  // namespace stark::symbolic
