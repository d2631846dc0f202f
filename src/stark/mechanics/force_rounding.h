// What doubles leave of the balance of forces (step phase 4j): no tolerance can ask for less; and what they
// make of energies at rest (phase 4i). [theory eq. 23b]
#pragma once

#include <span>
#include <vector>

#include <stark/base/math.h>
#include <stark/linalg/block_matrix.h>
#include <stark/mechanics/dof_layout.h>

namespace stark {

/// Part of the unbalanced forces that is rounding, by block [N, N m]: positions x are known to eps |x|, and
/// the matrix says what forces that makes, sum_j |H_ij| eps |x_j|. Rotations are known to eps.
std::vector<double> force_rounding(const BlockMatrix& hessian, std::span<const Vec3> block_positions,
                                   const DofLayout& layout);

/// Rounding of the energy of elements. At rest energies vanish and their terms do not, which are the
/// stiffness times the square of the size; strained by as much as they are large, they are as uncertain as
/// their positions, which are known to eps |x|: sum over pairs of points of eps |H_ij| |x_i - x_j| (|x_i -
/// x_j| + max(|x_i|, |x_j|)) [J].
double energy_rounding(const BlockMatrix& hessian, std::span<const Vec3> block_positions,
                       const DofLayout& layout);

}  // namespace stark
