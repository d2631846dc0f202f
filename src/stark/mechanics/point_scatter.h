// Sums of elements whose sites are points alone, as most contacts of cloth and solids: each thread adds what
// falls into its rows of the system, so that every entry is one sum in the order of the elements, on any
// number of threads (step phase 4e).
#pragma once

#include <span>
#include <vector>

#include <stark/base/thread_pool.h>
#include <stark/linalg/block_matrix.h>
#include <stark/mechanics/kinematic_map.h>
#include <stark/mechanics/potential_batch.h>

namespace stark {

class PointScatter {
 public:
  /// Takes a batch. Returns false where it is not worth several threads: too few elements or one thread, or
  /// sites of other kinds than points and prescribed ones.
  bool take(const PotentialBatch& batch, const KinematicMap& map, ThreadPool& pool);

  /// Adds the gradients and Hessians of the batch that was taken: `lanes` are the outputs of its kernel,
  /// block of lanes by block of lanes.
  void add(const PotentialBatch& batch, const double* lanes, ThreadPool& pool, std::span<double> gradient,
           BlockMatrix& hessian) const;

 private:
  /// Cuts the rows so that about as many nodes of elements are in each range.
  void cut_rows(int32_t row_count, int ranges);

  std::vector<int32_t> blocks_;  ///< [element][node], kNoBlock where a node is prescribed
  std::vector<int32_t> cuts_;    ///< rows [cuts_[k], cuts_[k + 1]) are of task k
};

}  // namespace stark
