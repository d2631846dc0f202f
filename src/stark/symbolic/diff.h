// Symbolic differentiation on the expression graph. Gradient: reverse sweep. Hessian, by several algorithms
// whose cost depends on the shape of the graph:
//   ForwardForward  A  every entry by two forward sweeps
//   ReverseForward  B  forward sweep over the reverse gradient, columns j >= i
//   EdgePushing     C  one reverse sweep carrying adjoints and a sparse matrix of second adjoints
//                      [Gower & Mello 2012, "A new framework for the computation of Hessians"]
//   StagedOuter     D  edge pushing down to the marked stages nearest to the energy, H = J^T H_p J + Hess
//   <g_p, p> StagedInner     D  the same with the stages nearest to the inputs StagedAll       D  one product
//   per level of stages
// The engine counts the operations of each result and keeps the cheapest.
// Phase: kernel building.
#pragma once

#include <stark/symbolic/expr.h>

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace stark::symbolic {

enum class Algorithm : uint8_t {
  ForwardForward,
  ReverseForward,
  EdgePushing,
  StagedOuter,
  StagedInner,
  StagedAll
};
std::string to_string(Algorithm algorithm);

struct Derivatives {
  NodeId value = -1;
  std::vector<NodeId> gradient;  // by the number of the unknown
  std::vector<NodeId> hessian;   // upper triangle, row by row
  Algorithm algorithm = Algorithm::EdgePushing;
};

/// Gradient with respect to the Unknown inputs 0 .. input_count - 1 of the graph.
Derivatives gradient(Graph& graph, NodeId energy);
/// Gradient and Hessian by one algorithm. `stages` are the marked cuts (ids of this graph); false if the
/// algorithm does not apply (no usable stage).
bool hessian(Graph& graph, NodeId energy, std::span<const NodeId> stages, Algorithm algorithm,
             Derivatives& out_result);
/// Gradient and Hessian by the cheapest of the algorithms B, C, D.
Derivatives cheapest_hessian(Graph& graph, NodeId energy, std::span<const NodeId> stages);

/// Forward sweep: derivative of each output with respect to one input; -1 is zero. `needed` flags what the
/// outputs need, as reachable() does.
std::vector<NodeId> forward(Graph& graph, std::span<const NodeId> outputs, const std::vector<char>& needed,
                            NodeId input);

/// Number of operations that are needed for these outputs.
int operation_total(const Graph& graph, std::span<const NodeId> outputs);
/// The same, weighted by throughput (a division costs several multiplications, a function some tens).
double operation_cost(const Graph& graph, std::span<const NodeId> outputs);

/// Unknown inputs by their number.
std::vector<NodeId> unknowns_of(Graph& graph);
/// Flags, by node, of what the outputs need; as long as the largest output requires.
std::vector<char> reachable(const Graph& graph, std::span<const NodeId> outputs);

}  // namespace stark::symbolic
