// H <- J^T H J + Hess <g, p> from one set of stages p to the next, down to the inputs.
// Phase: kernel building.
#include <stark/symbolic/staged.h>

#include <stark/symbolic/edge_pushing.h>

#include <algorithm>
#include <utility>
#include <vector>

namespace stark::symbolic {

namespace {

using Seed = EdgePushing::Seed;

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

}  // namespace

bool staged_hessian(Graph& graph, NodeId energy, std::span<const NodeId> stages, Algorithm algorithm,
                    Derivatives& out_result) {
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
  out_result.gradient = stage.g;
  for (size_t i = 0; i < inputs.size(); ++i) {
    for (size_t j = i; j < inputs.size(); ++j) out_result.hessian.push_back(stage.H[i][j]);
  }
  return true;
}

}  // namespace stark::symbolic
