// A block matrix with the preconditioner block-Jacobi, to which a coarse space may be added. Rows then are in
// the order of its clusters, so that a cluster is one run of memory. A product reads every block once, row by
// row; vectors are passed over once before it and once after it. Runs of rows are shared among threads, and
// dot products are summed run by run. Phase: linear solve of a Newton step.
#pragma once

#include <cstdint>
#include <vector>

#include <stark/linalg/coarse_space.h>
#include <stark/linalg/expanded_matrix.h>
#include <stark/linalg/pcg.h>

namespace stark {

class JacobiMatrix final : public PreconditionedMatrix {
 public:
  bool prepare(const BlockMatrix& matrix, PcgStorage storage, ThreadPool& pool) override;
  /// Corrects the preconditioner from the next prepare() on, nullptr: no longer. It has a factor of the
  /// matrix.
  void set_coarse_space(CoarseSpace* coarse) { coarse_ = coarse; }

  int32_t block_count() const override { return rows_.block_count(); }
  int32_t failed_block() const override { return rows_.failed_block(); }
  int64_t size() const override { return 3 * static_cast<int64_t>(block_count()) + 1; }  // a number to spare
  double start(const double* b, double* r, double* z, ThreadPool& pool) override;
  double multiply(const double* z, double beta, double* p, double* q, ThreadPool& pool) override;
  double update(double alpha, const double* p, const double* q, double* y, double* r, double* z,
                ThreadPool& pool) override;
  void finish(const double* y, double* x, ThreadPool& pool) override;

 private:
  template <typename Body>
  double sum_over_runs(ThreadPool& pool, Body&& body);
  double precondition(int64_t run, const double* r, double* z);
  template <typename Real>
  double multiply_run(const Real* blocks, int64_t begin, int64_t end, const double* p, double* q) const;
  double correct(double sum, ThreadPool& pool);
  bool is_cluster(int64_t run) const { return coarse_ != nullptr && run < coarse_->cluster_count(); }

  ExpandedMatrix rows_{ExpandedMatrix::Above::Ascending, ExpandedMatrix::Diagonal::RowSum};
  std::vector<int64_t> run_begin_;  // [runs + 1] rows; those of clusters come first
  std::vector<double> partial_;     // [runs]
  CoarseSpace* coarse_ = nullptr;
};

}  // namespace stark
