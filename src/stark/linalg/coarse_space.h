// Coarse space of rigid modes: an additive correction to a preconditioner, z += P (P^T A P)^-1 P^T r, where
// the columns of P move clusters of nodes as rigid bodies. It removes the smooth errors that a block-Jacobi
// preconditioner leaves to many iterations (theory eq. 23c; Nicolaides 1987; Saad, Iterative Methods for
// Sparse Linear Systems, section 14; for rigid modes Vanek, Mandel and Brezina 1996). Phase: linear solve of
// a Newton step.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <stark/base/aligned.h>
#include <stark/base/math.h>
#include <stark/base/thread_pool.h>
#include <stark/linalg/block_matrix.h>
#include <stark/linalg/cholesky.h>
#include <stark/linalg/coarse_projection.h>

namespace stark {

class CoarseSpace {
 public:
  /// Takes the connected parts of a pattern, that without contact. Parts of a few blocks, as rigid bodies
  /// are, stay without modes.
  void prepare(const BlockPattern& pattern);

  /// Whether any part is large enough for clusters.
  bool is_useful() const { return clustered_count_ > 0; }

  /// Clusters by recursive bisection of each part at the median of its longest direction, and their modes at
  /// `positions` [block_count] [m]. Ties are broken by index: the same bits for the same positions.
  void set_positions(std::span<const Vec3> positions);

  /// P^T A P and its factor. False if it is not positive definite; then A is not, either, up to rounding.
  bool factor(const BlockMatrix& matrix, ThreadPool& pool);

  int32_t cluster_count() const { return static_cast<int32_t>(cluster_ends_.size()); }
  /// Blocks by cluster, then those without modes, [block_count].
  std::span<const int32_t> order() const { return order_; }
  /// Where each cluster ends in that order, [clusters].
  std::span<const int32_t> cluster_ends() const { return cluster_ends_; }

  // z += P (P^T A P)^-1 P^T r in three steps, all vectors in that order; the first and last for each cluster.
  void take_forces(int32_t cluster, const double* r);
  /// Returns the part of r^T z that will be added.
  double solve(ThreadPool& pool);
  void add_motion(int32_t cluster, double* z) const;

 private:
  struct Range {
    int32_t begin, end;  // of order_
  };
  Range range_of(int32_t cluster) const {
    return {cluster == 0 ? 0 : cluster_ends_[cluster - 1], cluster_ends_[cluster]};
  }
  void bisect_parts(std::span<const Vec3> positions);
  void make_pattern();
  void fill_matrix();

  int32_t clustered_count_ = 0;        // blocks of large parts
  std::vector<Range> parts_;           // large connected parts
  std::vector<int32_t> order_;         // blocks by part, then by cluster; then those of small parts
  std::vector<int32_t> cluster_ends_;  // [clusters]
  std::vector<int32_t> cluster_;       // [block_count], -1 for blocks without modes
  std::vector<Vec3> arm_;              // [block_count] from the middle of the cluster, in its radii [1]
  std::vector<Vec3> ordered_arm_;      // the same in order_
  std::vector<ClusterRow> projected_;  // [clusters] of P^T (D / 2 + U) P
  BlockMatrix coarse_;                 // [2 clusters] blocks: translation and rotation of each cluster
  Cholesky<double> cholesky_;
  std::vector<double> right_, solution_;  // [clusters][6]
};

}  // namespace stark
