#include <stark/symbolic/substitute.h>

#include <stark/base/error.h>
#include <stark/symbolic/diff.h>

#include <algorithm>

namespace stark::symbolic {

namespace {

Scalar rebuild(const Node& node, const Scalar* x) {
  switch (node.op) {
    case Op::Neg:
      return -x[0];
    case Op::Held:
      return held(x[0]);
    case Op::Total:
      return total(x[0]);
    case Op::Abs:
      return abs(x[0]);
    case Op::Sqrt:
      return sqrt(x[0]);
    case Op::Exp:
      return exp(x[0]);
    case Op::Log:
      return log(x[0]);
    case Op::Sin:
      return sin(x[0]);
    case Op::Cos:
      return cos(x[0]);
    case Op::Tan:
      return tan(x[0]);
    case Op::Asin:
      return asin(x[0]);
    case Op::Acos:
      return acos(x[0]);
    case Op::Atan:
      return atan(x[0]);
    case Op::Tanh:
      return tanh(x[0]);
    case Op::Add:
      return x[0] + x[1];
    case Op::Sub:
      return x[0] - x[1];
    case Op::Mul:
      return x[0] * x[1];
    case Op::Div:
      return x[0] / x[1];
    case Op::Min:
      return min(x[0], x[1]);
    case Op::Max:
      return max(x[0], x[1]);
    case Op::Pow:
      return pow(x[0], x[1]);
    case Op::Atan2:
      return atan2(x[0], x[1]);
    case Op::Fma:
      return fma(x[0], x[1], x[2]);
    case Op::Select:
      return select(x[0], x[1], x[2]);
    case Op::Less:
      return x[0] < x[1];
    case Op::LessEqual:
      return x[0] <= x[1];
    case Op::And:
      return x[0] && x[1];
    case Op::Or:
      return x[0] || x[1];
    case Op::Not:
      return !x[0];
    case Op::Constant:
    case Op::Unknown:
    case Op::Element:
    case Op::Uniform:
      break;
  }
  throw InternalError("substitute: unknown operation.");
}

InputKind kind_of(Op op) {
  return op == Op::Unknown ? InputKind::Unknown
                           : (op == Op::Element ? InputKind::Element : InputKind::Uniform);
}

/// Copies nodes, operands before users, and the marked cuts among them. Nodes that were not copied stay
/// empty.
std::vector<Scalar> copy_nodes(const Graph& source, std::span<const NodeId> order,
                               const InputSubstitution& input, const TotalSubstitution& total = {}) {
  std::vector<Scalar> image(source.size());
  std::vector<char> copied(source.size(), 0);
  for (const NodeId id : order) {
    const Node& node = source.node(id);
    copied[id] = 1;
    if (node.op == Op::Constant) {
      image[id] = node.value;
    } else if (operand_count(node.op) == 0) {
      image[id] = input(kind_of(node.op), node.operands[0]);
    } else if (node.op == Op::Total && total) {
      image[id] = total(node.operands[0]);
    } else {
      Scalar x[3];
      for (int k = 0; k < operand_count(node.op); ++k) x[k] = image[node.operands[k]];
      image[id] = rebuild(node, x);
    }
  }
  std::vector<Scalar> stages;
  for (const NodeId stage : source.stages())
    if (copied[stage] && !image[stage].is_literal()) stages.push_back(image[stage]);
  // In the order of the copies, whatever order they were marked in.
  std::ranges::sort(stages, {}, [](const Scalar& stage) { return stage.id(); });
  for (const Scalar& stage : stages) stage.graph()->mark_stage(stage);
  return image;
}

/// Nodes of an expression but for what is summed, operands before users.
std::vector<NodeId> order_above_totals(const Graph& graph, NodeId root) {
  std::vector<char> needed(static_cast<size_t>(root) + 1, 0);
  needed[root] = 1;
  std::vector<NodeId> order;
  for (NodeId id = root; id >= 0; --id) {
    if (!needed[id]) continue;
    order.push_back(id);
    const Node& node = graph.node(id);
    for (int k = 0; node.op != Op::Total && k < operand_count(node.op); ++k) needed[node.operands[k]] = 1;
  }
  std::ranges::reverse(order);
  return order;
}

}  // namespace

std::vector<Scalar> substitute(std::span<const Scalar> outputs, const InputSubstitution& input) {
  const Graph* source = nullptr;
  std::vector<NodeId> roots;
  for (const Scalar& output : outputs) {
    if (output.is_literal()) continue;
    STARK_CHECK(source == nullptr || source == output.graph());
    source = output.graph();
    roots.push_back(output.id());
  }
  if (!source) return {outputs.begin(), outputs.end()};
  const std::vector<char> needed = reachable(*source, roots);
  std::vector<NodeId> order;
  for (NodeId id = 0; id < static_cast<NodeId>(needed.size()); ++id)
    if (needed[id]) order.push_back(id);
  const std::vector<Scalar> image = copy_nodes(*source, order, input);
  std::vector<Scalar> result;
  for (const Scalar& output : outputs) result.push_back(output.is_literal() ? output : image[output.id()]);
  return result;
}

Scalar substitute(const Scalar& output, const InputSubstitution& input, const TotalSubstitution& total) {
  if (output.is_literal()) return output;
  const Graph& graph = *output.graph();
  return copy_nodes(graph, order_above_totals(graph, output.id()), input, total)[output.id()];
}

std::vector<Scalar> totals_in(const Scalar& output) {
  std::vector<Scalar> found;
  if (output.is_literal()) return found;
  for (const NodeId id : order_above_totals(*output.graph(), output.id()))
    if (const Node& node = output.graph()->node(id); node.op == Op::Total)
      found.emplace_back(output.graph(), node.operands[0]);
  return found;
}

Scalar substitute(const Scalar& output, std::span<const NodeId> order, const InputSubstitution& input) {
  return output.is_literal() ? output : copy_nodes(*output.graph(), order, input)[output.id()];
}

}  // namespace stark::symbolic
