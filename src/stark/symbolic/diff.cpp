// The differentiation algorithms and the choice among them.
// Phase: kernel building.
#include <stark/symbolic/diff.h>

#include <stark/base/error.h>
#include <stark/symbolic/edge_pushing.h>

#include <algorithm>
#include <limits>
#include <utility>

namespace stark::symbolic {

namespace {

using Seed = EdgePushing::Seed;

std::vector<NodeId> unknowns_of(Graph& graph) {
  std::vector<NodeId> ids;
  for (int i = 0; i < graph.input_count(InputKind::Unknown); ++i)
    ids.push_back(graph.input_node(InputKind::Unknown, i));
  return ids;
}

size_t upper_index(size_t n, size_t i, size_t j) { return i * n - i * (i + 1) / 2 + j; }  // i <= j

// Nodes needed for the outputs.
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

// Forward derivative of `outputs` with respect to one input; -1 is zero.
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
    } else if (!is_condition(n.op)) {
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

// Level of every stage: 1 if it depends on no other stage, else one more than the deepest stage it depends
// on.
std::vector<int> stage_levels(const Graph& graph, NodeId energy, std::span<const NodeId> stages) {
  std::vector<char> is_stage(graph.size(), 0);
  for (const NodeId s : stages) is_stage[s] = 1;
  std::vector<int> level(graph.size(), 0);
  for (NodeId id = 0; id <= energy; ++id) {
    const Node& n = graph.node(id);
    for (int k = 0; k < operand_count(n.op); ++k) level[id] = std::max(level[id], level[n.operands[k]]);
    if (is_stage[id]) ++level[id];
  }
  std::vector<int> result;
  for (const NodeId s : stages) result.push_back(level[s]);
  return result;
}

// One elimination step: from g, H over `outer` variables to g, H over `inner` ones, H <- J^T H J + Hess <g,
// outer>.
struct Stage {
  std::vector<NodeId> variables, g;
  std::vector<std::vector<NodeId>> H;  // full symmetric, -1 is zero
};

// Stages of `inner` that the outer variables use only inside arms of selects go to out_conditional, and
// nothing else is done then: behind such a stage the Jacobian may be infinite where the stage is not used.
Stage eliminate(Graph& graph, const Stage& outer, const std::vector<NodeId>& inner,
                std::vector<NodeId>& out_conditional) {
  const size_t p = outer.variables.size(), q = inner.size();
  std::vector<Seed> seeds;
  for (size_t k = 0; k < p; ++k) {
    if (outer.g[k] >= 0) seeds.push_back({outer.variables[k], outer.g[k]});
  }
  const EdgePushing curvature(graph, inner, seeds, true);
  for (size_t k = 0; k < q; ++k) {
    if (graph.node(inner[k]).op != Op::Unknown && curvature.is_conditional(static_cast<int>(k)))
      out_conditional.push_back(inner[k]);
  }
  if (!out_conditional.empty()) return {};
  std::vector<std::vector<NodeId>> J(p);
  for (size_t k = 0; k < p; ++k) {
    const Seed seed[] = {{outer.variables[k], graph.constant(1.0)}};
    J[k] = EdgePushing(graph, inner, seed, false).gradient();
  }
  Stage result{inner, curvature.gradient(), std::vector(q, std::vector<NodeId>(q, -1))};
  for (size_t i = 0; i < q; ++i) {
    for (const auto& e : curvature.hessian()[i]) result.H[i][e.column] = result.H[e.column][i] = e.value;
  }
  std::vector<std::vector<NodeId>> HJ(p, std::vector<NodeId>(q, -1));
  for (size_t k = 0; k < p; ++k) {
    for (size_t j = 0; j < q; ++j) {
      for (size_t l = 0; l < p; ++l)
        HJ[k][j] = add_term(graph, HJ[k][j], multiply_term(graph, outer.H[k][l], J[l][j]));
    }
  }
  for (size_t i = 0; i < q; ++i) {
    for (size_t j = i; j < q; ++j) {
      for (size_t k = 0; k < p; ++k) {
        result.H[i][j] = add_term(graph, result.H[i][j], multiply_term(graph, J[k][i], HJ[k][j]));
      }
      result.H[j][i] = result.H[i][j];
    }
  }
  return result;
}

// The variables that occur, so that products stay small.
Stage packed(const Stage& stage) {
  Stage result;
  std::vector<size_t> place;
  for (size_t k = 0; k < stage.variables.size(); ++k) {
    if (stage.g[k] >= 0) place.push_back(k);
  }
  for (const size_t k : place) {
    result.variables.push_back(stage.variables[k]);
    result.g.push_back(stage.g[k]);
    result.H.emplace_back();
    for (const size_t l : place) result.H.back().push_back(stage.H[k][l]);
  }
  return result;
}

bool staged(Graph& graph, NodeId energy, std::span<const NodeId> stages, Algorithm algorithm,
            Derivatives& d) {
  const NodeId root[] = {energy};
  const auto needed = reachable(graph, root);
  std::vector<NodeId> used;
  for (const NodeId s : stages) {
    if (s < energy && needed[s] && std::find(used.begin(), used.end(), s) == used.end()) used.push_back(s);
  }
  if (used.empty()) return false;
  std::vector<int> levels = stage_levels(graph, energy, used);
  const int deepest = *std::max_element(levels.begin(), levels.end());
  if (algorithm != Algorithm::StagedOuter && deepest == 1) return false;  // all variants are the same

  // The cuts from the energy to the inputs: the highest and the lowest level of stages that each keeps.
  std::vector<std::pair<int, int>> cuts;
  if (algorithm == Algorithm::StagedInner) cuts = {{1, 1}};
  if (algorithm == Algorithm::StagedOuter) cuts = {{deepest, 1}};
  if (algorithm == Algorithm::StagedAll) {
    for (int top = deepest; top >= 1; --top) cuts.push_back({top, 1});
  }
  const std::vector<NodeId> inputs = unknowns_of(graph);
  Stage stage{{energy}, {graph.constant(1.0)}, {{-1}}};
  for (const auto& [high, low] : cuts) {
    for (;;) {
      std::vector<NodeId> next, conditional;
      for (size_t k = 0; k < used.size(); ++k) {
        if (levels[k] <= high && levels[k] >= low) next.push_back(used[k]);
      }
      next.insert(next.end(), inputs.begin(), inputs.end());
      Stage result = eliminate(graph, stage, next, conditional);
      if (conditional.empty()) {
        stage = packed(result);
        break;
      }
      for (size_t k = used.size(); k-- > 0;) {
        if (std::find(conditional.begin(), conditional.end(), used[k]) == conditional.end()) continue;
        used.erase(used.begin() + static_cast<std::ptrdiff_t>(k));
        levels.erase(levels.begin() + static_cast<std::ptrdiff_t>(k));
      }
    }
  }
  if (used.empty()) return false;
  std::vector<NodeId> none;
  stage = eliminate(graph, stage, inputs, none);
  d.gradient = stage.g;
  for (size_t i = 0; i < inputs.size(); ++i) {
    for (size_t j = i; j < inputs.size(); ++j) d.hessian.push_back(stage.H[i][j]);
  }
  return true;
}

std::vector<NodeId> all_outputs(const Derivatives& d) {
  std::vector<NodeId> outputs{d.value};
  outputs.insert(outputs.end(), d.gradient.begin(), d.gradient.end());
  outputs.insert(outputs.end(), d.hessian.begin(), d.hessian.end());
  return outputs;
}

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
      if (!staged(graph, energy, stages, algorithm, d)) return false;
  }
  fill_zeros(graph, d.gradient);
  fill_zeros(graph, d.hessian);
  out_result = std::move(d);
  return true;
}

Derivatives cheapest_hessian(Graph& graph, NodeId energy, std::span<const NodeId> stages) {
  Derivatives best;
  double best_cost = std::numeric_limits<double>::infinity();
  for (const Algorithm algorithm : {Algorithm::EdgePushing, Algorithm::StagedOuter, Algorithm::StagedInner,
                                    Algorithm::StagedAll, Algorithm::ReverseForward}) {
    Derivatives d;
    if (!hessian(graph, energy, stages, algorithm, d)) continue;
    const double cost = operation_cost(graph, all_outputs(d));
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
