// First and second partial derivatives of one node with respect to its operands, as new nodes of the same
// graph. Phase: kernel building.
#pragma once

#include <stark/symbolic/expr.h>

#include <array>
#include <vector>

namespace stark::symbolic {

/// Partials by the distinct operands of a node; -1 stands for zero. For Select, Min and Max use `arms`
/// instead.
struct Partials {
  int count = 0;
  std::array<NodeId, 3> operand{-1, -1, -1};
  std::array<NodeId, 3> first{-1, -1, -1};
  std::array<std::array<NodeId, 3>, 3> second{{{-1, -1, -1}, {-1, -1, -1}, {-1, -1, -1}}};  // [i][j], i <= j
};

/// The two arms of a node that chooses: (condition ? taken : other).
struct Arms {
  NodeId condition = -1, taken = -1, other = -1;
};

inline bool is_choice(Op op) { return op == Op::Select || op == Op::Min || op == Op::Max; }
Arms choice_arms(Graph& graph, NodeId id);

/// Partials of a node that is not a choice. Second partials are formed only if asked for.
Partials local_partials(Graph& graph, NodeId id, bool with_second);

// Sums and products where -1 is an absent (zero) term.
NodeId add_term(Graph& graph, NodeId a, NodeId b);
NodeId multiply_term(Graph& graph, NodeId a, NodeId b);

}  // namespace stark::symbolic
