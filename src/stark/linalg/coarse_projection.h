// One cluster's rows of P^T A P, where the columns of P move clusters of blocks as rigid bodies: the product
// of a coarse space (coarse_space.h). Phase: linear solve of a Newton step.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <stark/base/math.h>
#include <stark/linalg/block_matrix.h>

namespace stark {

/// Force and moment on a cluster, row by row, by the motion of another: shift and turn, four columns each of
/// which the last stays zero.
struct CoarseBlock {
  int32_t cluster;
  alignas(32) std::array<double, 48> values;

  double operator()(int row, int column) const { return values[8 * row + 4 * (column / 3) + column % 3]; }
};
using ClusterRow = std::vector<CoarseBlock>;

struct ClusterMap {
  std::span<const int32_t> cluster;  // [block_count], -1 for blocks without modes
  std::span<const Vec3> arm;         // [block_count] from the middle of the cluster
};

/// P^T (D / 2 + U) P of the rows `blocks`, all those of one cluster: what is projected plus its transpose is
/// P^T A P. Blocks by cluster, ascending.
void project_cluster(const BlockMatrix& matrix, std::span<const int32_t> blocks, const ClusterMap& map,
                     ClusterRow& out);

}  // namespace stark
