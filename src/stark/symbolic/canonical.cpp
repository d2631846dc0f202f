#include <stark/symbolic/canonical.h>

#include <stark/base/error.h>
#include <stark/base/hash.h>
#include <stark/symbolic/diff.h>
#include <stark/symbolic/substitute.h>

#include <algorithm>
#include <bit>
#include <utility>
#include <vector>

namespace stark::symbolic {

namespace {

/// Structure of a node: the height of its expression and a hash of it. Operands that may be exchanged are
/// visited by decreasing height, which needs fewer registers, then by hash.
struct Structure {
  int height = 0;
  uint64_t hash = 0;
};

bool commutes(Op op) {
  return op == Op::Add || op == Op::Mul || op == Op::And || op == Op::Or || op == Op::Fma;
}

InputKind kind_of(Op op) {
  return op == Op::Unknown ? InputKind::Unknown
                           : (op == Op::Element ? InputKind::Element : InputKind::Uniform);
}

bool precedes(const Structure& a, const Structure& b) {
  return a.height != b.height ? a.height > b.height : a.hash < b.hash;
}

/// Operands in the order in which they are visited.
std::array<NodeId, 3> visited_operands(const Node& node, const std::vector<Structure>& structures) {
  std::array<NodeId, 3> order = node.operands;
  if (commutes(node.op) && precedes(structures[order[1]], structures[order[0]]))
    std::swap(order[0], order[1]);
  return order;
}

Structure structure_of(const Node& node, const std::vector<Structure>& structures, const InputLabel& label) {
  Hash64 hash;
  hash.append(static_cast<int>(node.op));
  const int count = operand_count(node.op);
  if (node.op == Op::Constant) {
    hash.append(std::bit_cast<uint64_t>(node.value));
  } else if (count == 0) {
    hash.append(label(kind_of(node.op), node.operands[0]));
  }
  Structure result;
  if (count > 0) {
    const std::array<NodeId, 3> operands = visited_operands(node, structures);
    for (int k = 0; k < count; ++k) {
      result.height = std::max(result.height, structures[operands[k]].height + 1);
      hash.append(structures[operands[k]].hash);
    }
  }
  result.hash = hash.value();
  return result;
}

/// Nodes of the expression, operands before users, in the order of a depth-first visit.
std::vector<NodeId> visit(const Graph& graph, NodeId root, const std::vector<Structure>& structures) {
  std::vector<NodeId> order;
  std::vector<char> done(structures.size(), 0);
  std::vector<std::pair<NodeId, int>> stack{{root, 0}};
  while (!stack.empty()) {
    auto& [id, next] = stack.back();
    const Node& node = graph.node(id);
    if (done[id] || next == operand_count(node.op)) {
      if (!done[id]) order.push_back(id);
      done[id] = 1;
      stack.pop_back();
      continue;
    }
    const NodeId operand = visited_operands(node, structures)[next++];
    if (!done[operand]) stack.emplace_back(operand, 0);
  }
  return order;
}

}  // namespace

Scalar canonical_copy(Graph& target, const Scalar& output, const InputLabel& label) {
  STARK_CHECK(target.size() == Graph().size());
  if (output.is_literal()) return output;
  const Graph& source = *output.graph();
  const NodeId root[] = {output.id()};
  const std::vector<char> needed = reachable(source, root);
  std::vector<Structure> structures(needed.size());
  for (NodeId id = 0; id < static_cast<NodeId>(needed.size()); ++id)
    if (needed[id]) structures[id] = structure_of(source.node(id), structures, label);
  const auto input = [&](InputKind kind, int index) {
    return Scalar(&target, target.input_node(kind, index));
  };
  return substitute(output, visit(source, output.id(), structures), input);
}

}  // namespace stark::symbolic
