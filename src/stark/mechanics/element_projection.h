// Projection of element Hessians in the kernels' layout (step phase 4d).
#pragma once

#include <stark/mechanics/potential.h>

namespace stark {

/// Makes the Hessians of the blocks of lanes at `out`, outputs of Order::Hessian, positive semidefinite;
/// returns how many were not.
int64_t project_blocks(const Potential& potential, int64_t block_count, double* out);

/// The same of n x n matrices whose upper triangles start at output `first` of `outputs`. `reduced`: that of
/// psd_project(), for matrices of points that translations leave alone.
int64_t project_blocks(int n, int first, int outputs, bool reduced, int64_t block_count, double* out);

}  // namespace stark
