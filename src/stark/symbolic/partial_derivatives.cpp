// Derivatives with respect to any values: the sweeps of edge_pushing.h and diff.h with repeated targets and
// zeros put in. Phase: model building.
#include <stark/symbolic/partial_derivatives.h>

#include <stark/symbolic/diff.h>
#include <stark/symbolic/edge_pushing.h>

#include <algorithm>
#include <utility>

namespace stark::symbolic {

namespace {

/// The distinct targets, and the place of every target among them.
struct DistinctTargets {
  std::vector<NodeId> nodes;
  std::vector<size_t> place;
};

DistinctTargets distinct(std::span<const NodeId> targets) {
  DistinctTargets d;
  for (const NodeId id : targets) {
    const auto found = std::find(d.nodes.begin(), d.nodes.end(), id);
    d.place.push_back(static_cast<size_t>(found - d.nodes.begin()));
    if (found == d.nodes.end()) d.nodes.push_back(id);
  }
  return d;
}

NodeId or_zero(Graph& graph, NodeId id) { return id < 0 ? graph.constant(0.0) : id; }

std::vector<NodeId> reverse_jacobian(Graph& graph, std::span<const NodeId> outputs,
                                     std::span<const NodeId> inputs) {
  std::vector<NodeId> entries;
  for (const NodeId y : outputs) {
    const std::vector<NodeId> row = partial_derivatives(graph, y, inputs);
    entries.insert(entries.end(), row.begin(), row.end());
  }
  return entries;
}

std::vector<NodeId> forward_jacobian(Graph& graph, std::span<const NodeId> outputs,
                                     std::span<const NodeId> inputs) {
  const std::vector<char> needed = reachable(graph, outputs);
  std::vector<NodeId> entries(outputs.size() * inputs.size());
  for (size_t j = 0; j < inputs.size(); ++j) {
    const std::vector<NodeId> column = forward(graph, outputs, needed, inputs[j]);
    for (size_t i = 0; i < outputs.size(); ++i) entries[i * inputs.size() + j] = or_zero(graph, column[i]);
  }
  return entries;
}

}  // namespace

std::vector<NodeId> partial_derivatives(Graph& graph, NodeId output, std::span<const NodeId> targets) {
  const DistinctTargets d = distinct(targets);
  const EdgePushing::Seed seed[] = {{output, graph.constant(1.0)}};
  const EdgePushing sweep(graph, d.nodes, seed, false);
  std::vector<NodeId> result;
  for (const size_t p : d.place) result.push_back(or_zero(graph, sweep.gradient()[p]));
  return result;
}

std::vector<NodeId> second_partial_derivatives(Graph& graph, NodeId output, std::span<const NodeId> targets) {
  const DistinctTargets d = distinct(targets);
  const EdgePushing::Seed seed[] = {{output, graph.constant(1.0)}};
  const EdgePushing sweep(graph, d.nodes, seed, true);
  const size_t n = d.nodes.size();
  std::vector<NodeId> full(n * n, graph.constant(0.0));
  for (size_t i = 0; i < n; ++i) {
    for (const auto& e : sweep.hessian()[i]) full[i * n + e.column] = full[e.column * n + i] = e.value;
  }
  std::vector<NodeId> upper;
  for (size_t i = 0; i < targets.size(); ++i) {
    for (size_t j = i; j < targets.size(); ++j) upper.push_back(full[d.place[i] * n + d.place[j]]);
  }
  return upper;
}

std::vector<NodeId> jacobian(Graph& graph, std::span<const NodeId> outputs, std::span<const NodeId> inputs) {
  std::vector<NodeId> reverse = reverse_jacobian(graph, outputs, inputs);
  std::vector<NodeId> forward = forward_jacobian(graph, outputs, inputs);
  return operation_cost(graph, forward) < operation_cost(graph, reverse) ? forward : reverse;
}

}  // namespace stark::symbolic
