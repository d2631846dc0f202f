// Hessian through stages: derivatives with respect to marked intermediate values first, then the chain rule
// as explicit products. Cheaper than elimination node by node where few inputs fan out to many values that
// meet again in few points, as with rigid bodies. Phase: kernel building.
#pragma once

#include <stark/symbolic/diff.h>

#include <span>

namespace stark::symbolic {

/// One of the staged algorithms of diff.h; zero entries are -1. False if there is no usable stage, or if the
/// algorithm is the same as StagedOuter here.
bool staged_hessian(Graph& graph, NodeId energy, std::span<const NodeId> stages, Algorithm algorithm,
                    Derivatives& out_result);

}  // namespace stark::symbolic
