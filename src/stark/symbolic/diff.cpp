// The differentiation algorithms and the choice among them.
// Phase: kernel building.
#include <stark/symbolic/diff.h>

#include <stark/base/error.h>
#include <stark/symbolic/edge_pushing.h>
#include <stark/symbolic/staged.h>

#include <algorithm>
#include <limits>
#include <utility>

namespace stark::symbolic {

namespace {

using Seed = EdgePushing::Seed;

size_t upper_index(size_t n, size_t i, size_t j) { return i * n - i * (i + 1) / 2 + j; }  // i <= j

// Replaces absent terms by a zero node.
void fill_zeros(Graph& graph, std::vector<NodeId>& values) {
  for (NodeId& v : values) {
    if (v < 0) v = graph.constant(0.0);
  }
}

void forward_forward(Graph& graph, NodeId energy, Derivatives& d) {
  const std::vector<NodeId> x = unknowns_of(graph);
  const NodeId root[] = {energy};
  const auto needed = reachable(graph, root);
  for (const NodeId u : x) d.gradient.push_back(forward(graph, root, needed, u)[0]);
  for (size_t i = 0; i < x.size(); ++i) {
    if (d.gradient[i] < 0) {
      d.hessian.insert(d.hessian.end(), x.size() - i, -1);
      continue;
    }
    const NodeId slope[] = {d.gradient[i]};
    const auto needed_slope = reachable(graph, slope);
    for (size_t j = i; j < x.size(); ++j) d.hessian.push_back(forward(graph, slope, needed_slope, x[j])[0]);
  }
}

void reverse_forward(Graph& graph, NodeId energy, Derivatives& d) {
  const std::vector<NodeId> x = unknowns_of(graph);
  const size_t n = x.size();
  d.gradient = gradient(graph, energy).gradient;
  d.hessian.assign(n * (n + 1) / 2, -1);
  for (size_t j = 0; j < n; ++j) {
    const std::span<const NodeId> rows(d.gradient.data(), j + 1);
    const std::vector<NodeId> column = forward(graph, rows, reachable(graph, rows), x[j]);
    for (size_t i = 0; i <= j; ++i) d.hessian[upper_index(n, i, j)] = column[i];
  }
}

void edge_pushing(Graph& graph, NodeId energy, Derivatives& d) {
  const std::vector<NodeId> x = unknowns_of(graph);
  const Seed seed[] = {{energy, graph.constant(1.0)}};
  const EdgePushing sweep(graph, x, seed, true);
  d.gradient = sweep.gradient();
  d.hessian.assign(x.size() * (x.size() + 1) / 2, -1);
  for (size_t i = 0; i < x.size(); ++i) {
    for (const auto& e : sweep.hessian()[i]) d.hessian[upper_index(x.size(), e.column, i)] = e.value;
  }
}

std::vector<NodeId> all_outputs(const Derivatives& d) {
  std::vector<NodeId> outputs{d.value};
  outputs.insert(outputs.end(), d.gradient.begin(), d.gradient.end());
  outputs.insert(outputs.end(), d.hessian.begin(), d.hessian.end());
  return outputs;
}

// Edge pushing keeps fewer values alive than its rivals: at equal counts its code is faster by about this
// much.
constexpr double kHandicap = 1.08;

// Relative throughput cost of one operation on a wide vector unit.
double weight(Op op) {
  switch (op) {
    case Op::Constant:
    case Op::Unknown:
    case Op::Element:
    case Op::Uniform:
      return 0.0;
    case Op::Div:
      return 7.0;
    case Op::Sqrt:
      return 9.0;
    case Op::Exp:
      return 25.0;
    case Op::Log:
      return 35.0;
    case Op::Sin:
    case Op::Cos:
      return 35.0;
    case Op::Tan:
      return 60.0;
    case Op::Asin:
    case Op::Acos:
      return 40.0;
    case Op::Atan:
    case Op::Atan2:
      return 50.0;
    case Op::Tanh:
      return 50.0;
    case Op::Pow:
      return 100.0;
    default:
      return 1.0;
  }
}

}  // namespace

std::vector<NodeId> unknowns_of(Graph& graph) {
  std::vector<NodeId> ids;
  for (int i = 0; i < graph.input_count(InputKind::Unknown); ++i)
    ids.push_back(graph.input_node(InputKind::Unknown, i));
  return ids;
}

std::vector<char> reachable(const Graph& graph, std::span<const NodeId> outputs) {
  NodeId size = 0;
  for (const NodeId id : outputs) size = std::max(size, id + 1);
  std::vector<char> seen(size, 0);
  for (const NodeId id : outputs) seen[id] = 1;
  for (NodeId id = size - 1; id >= 0; --id) {
    if (!seen[id]) continue;
    const Node& n = graph.node(id);
    for (int k = 0; k < operand_count(n.op); ++k) seen[n.operands[k]] = 1;
  }
  return seen;
}

std::vector<NodeId> forward(Graph& graph, std::span<const NodeId> outputs, const std::vector<char>& needed,
                            NodeId input) {
  std::vector<NodeId> tangent(needed.size(), -1);
  for (NodeId id = 0; id < static_cast<NodeId>(needed.size()); ++id) {
    if (!needed[id]) continue;
    const Node n = graph.node(id);
    if (id == input) {
      tangent[id] = graph.constant(1.0);
    } else if (is_choice(n.op)) {
      const Arms arms = choice_arms(graph, id);
      const NodeId a = tangent[arms.taken], b = tangent[arms.other], zero = graph.constant(0.0);
      if (a >= 0 || b >= 0) tangent[id] = graph.select(arms.condition, a < 0 ? zero : a, b < 0 ? zero : b);
    } else if (!is_condition(n.op) && n.op != Op::Held) {
      bool any = false;
      for (int k = 0; k < operand_count(n.op); ++k) any |= tangent[n.operands[k]] >= 0;
      if (!any) continue;
      const Partials p = local_partials(graph, id, false);
      for (int k = 0; k < p.count; ++k) {
        tangent[id] = add_term(graph, tangent[id], multiply_term(graph, p.first[k], tangent[p.operand[k]]));
      }
    }
  }
  std::vector<NodeId> result;
  for (const NodeId id : outputs) result.push_back(tangent[id]);
  return result;
}

std::string to_string(Algorithm algorithm) {
  switch (algorithm) {
    case Algorithm::ForwardForward:
      return "forward-forward";
    case Algorithm::ReverseForward:
      return "reverse-forward";
    case Algorithm::EdgePushing:
      return "edge pushing";
    case Algorithm::StagedOuter:
      return "staged (outer)";
    case Algorithm::StagedInner:
      return "staged (inner)";
    case Algorithm::StagedAll:
      return "staged (all)";
  }
  return "unknown";
}

Derivatives gradient(Graph& graph, NodeId energy) {
  const std::vector<NodeId> x = unknowns_of(graph);
  const Seed seed[] = {{energy, graph.constant(1.0)}};
  Derivatives d;
  d.value = energy;
  d.gradient = EdgePushing(graph, x, seed, false).gradient();
  fill_zeros(graph, d.gradient);
  return d;
}

bool hessian(Graph& graph, NodeId energy, std::span<const NodeId> stages, Algorithm algorithm,
             Derivatives& out_result) {
  Derivatives d;
  d.value = energy;
  d.algorithm = algorithm;
  switch (algorithm) {
    case Algorithm::ForwardForward:
      forward_forward(graph, energy, d);
      break;
    case Algorithm::ReverseForward:
      reverse_forward(graph, energy, d);
      break;
    case Algorithm::EdgePushing:
      edge_pushing(graph, energy, d);
      break;
    default:
      if (!staged_hessian(graph, energy, stages, algorithm, d)) return false;
  }
  fill_zeros(graph, d.gradient);
  fill_zeros(graph, d.hessian);
  out_result = std::move(d);
  return true;
}

Derivatives cheapest_hessian(Graph& graph, NodeId energy, std::span<const NodeId> stages) {
  Derivatives best;
  double best_cost = std::numeric_limits<double>::infinity();
  bool has_stages = false;
  for (const Algorithm algorithm : {Algorithm::EdgePushing, Algorithm::StagedOuter, Algorithm::StagedInner,
                                    Algorithm::StagedAll, Algorithm::ReverseForward}) {
    // Where stages apply they serve the same graphs as reverse-forward (few inputs, many intermediates)
    // better.
    if (algorithm == Algorithm::ReverseForward && has_stages) continue;
    Derivatives d;
    if (!hessian(graph, energy, stages, algorithm, d)) continue;
    has_stages |= algorithm == Algorithm::StagedOuter;
    double cost = operation_cost(graph, all_outputs(d));
    if (algorithm != Algorithm::EdgePushing) cost *= kHandicap;
    if (cost < best_cost) {
      best_cost = cost;
      best = std::move(d);
    }
  }
  return best;
}

int operation_total(const Graph& graph, std::span<const NodeId> outputs) {
  const auto needed = reachable(graph, outputs);
  int total = 0;
  for (NodeId id = 0; id < static_cast<NodeId>(needed.size()); ++id) {
    total += needed[id] && operand_count(graph.node(id).op) > 0;
  }
  return total;
}

double operation_cost(const Graph& graph, std::span<const NodeId> outputs) {
  const auto needed = reachable(graph, outputs);
  const auto size = static_cast<NodeId>(needed.size());
  std::vector<int> uses(size, 0);
  for (const NodeId id : outputs) ++uses[id];
  double total = 0.0;
  for (NodeId id = 0; id < size; ++id) {
    if (!needed[id]) continue;
    const Node& n = graph.node(id);
    total += weight(n.op);
    for (int k = 0; k < operand_count(n.op); ++k) ++uses[n.operands[k]];
  }
  // A product with one user that is a sum costs nothing: it is fused.
  const auto is_single_product = [&](NodeId id) { return graph.node(id).op == Op::Mul && uses[id] == 1; };
  for (NodeId id = 0; id < size; ++id) {
    const Node& n = graph.node(id);
    if (!needed[id] || (n.op != Op::Add && n.op != Op::Sub)) continue;
    if (is_single_product(n.operands[0]) || is_single_product(n.operands[1])) total -= 1.0;
  }
  return total;
}

}  // namespace stark::symbolic
