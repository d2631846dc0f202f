// How far a force is felt in a system of blocks. Phase: choice of a linear solver in a step.
#pragma once

#include <stark/base/thread_pool.h>
#include <stark/linalg/block_matrix.h>

namespace stark {

/// 1/sqrt(s) with the median s of tr(sum_j A_ij) / tr(A_ii) over all blocks i, 0 without blocks. What is
/// elastic has no part in the sums over rows, so that s compares inertia with stiffness: a force on a node
/// moves those that are about so many nodes away, and errors of an iteration that are smoother than that
/// are none of its matter.
double find_screening_length(const BlockMatrix& matrix);

}  // namespace stark
