#include <stark/linalg/jacobi_matrix.h>

#include <algorithm>
#include <numeric>
#include <type_traits>

#include <stark/linalg/block_rows.h>

namespace stark {

namespace {

constexpr int64_t kRunRows = 512;  // block rows of a run that is no cluster
constexpr int64_t kRunGrain = 4;   // runs of one task

}  // namespace

bool JacobiMatrix::prepare(const BlockMatrix& matrix, PcgStorage storage, ThreadPool& pool) {
  const int64_t count = matrix.pattern.block_count;
  run_begin_.assign(1, 0);
  if (coarse_ != nullptr) {
    const auto clusters = coarse_->cluster_ends();
    run_begin_.insert(run_begin_.end(), clusters.begin(), clusters.end());
  }
  while (run_begin_.back() < count) run_begin_.push_back(std::min(count, run_begin_.back() + kRunRows));
  partial_.assign(run_begin_.size() - 1, 0.0);
  return rows_.prepare(matrix, storage, pool,
                       coarse_ != nullptr ? coarse_->order() : std::span<const int32_t>());
}

// Sum of body(run, first row, end of rows) over all runs.
template <typename Body>
double JacobiMatrix::sum_over_runs(ThreadPool& pool, Body&& body) {
  pool.for_each_range(static_cast<int64_t>(partial_.size()), kRunGrain, [&](int64_t first, int64_t last) {
    for (int64_t run = first; run < last; ++run)
      partial_[run] = body(run, run_begin_[run], run_begin_[run + 1]);
  });
  return std::accumulate(partial_.begin(), partial_.end(), 0.0);
}

// z = D^-1 r of a run, whose forces the coarse space takes. Returns r^T z.
double JacobiMatrix::precondition(int64_t run, const double* r, double* z) {
  double sum = 0.0;
  for (int64_t i = run_begin_[run]; i < run_begin_[run + 1]; ++i) {
    const double* m = rows_.inverse() + 9 * i;
    const double r0 = r[3 * i], r1 = r[3 * i + 1], r2 = r[3 * i + 2];
    const double z0 = m[0] * r0 + m[1] * r1 + m[2] * r2;
    const double z1 = m[3] * r0 + m[4] * r1 + m[5] * r2;
    const double z2 = m[6] * r0 + m[7] * r1 + m[8] * r2;
    z[3 * i] = z0;
    z[3 * i + 1] = z1;
    z[3 * i + 2] = z2;
    sum += r0 * z0 + r1 * z1 + r2 * z2;
  }
  if (is_cluster(run)) coarse_->take_forces(static_cast<int32_t>(run), r);
  return sum;
}

// r^T z of what the runs sum up to, and of what the coarse space will add to z.
double JacobiMatrix::correct(double sum, ThreadPool& pool) {
  return coarse_ == nullptr ? sum : sum + coarse_->solve(pool);
}

double JacobiMatrix::start(const double* b, double* r, double* z, ThreadPool& pool) {
  return correct(sum_over_runs(pool,
                               [&](int64_t run, int64_t begin, int64_t end) {
                                 for (int64_t i = begin; i < end; ++i)
                                   std::copy_n(b + 3 * static_cast<int64_t>(rows_.source_row(i)), 3,
                                               r + 3 * i);
                                 return precondition(run, r, z);
                               }),
                 pool);
}

// q = A p of rows [begin, end). Returns p^T q. With blocks in single precision, A p is the sum of a row's
// blocks times its own p, and what other rows differ from that.
template <typename Real>
double JacobiMatrix::multiply_run(const Real* blocks, int64_t begin, int64_t end, const double* p,
                                  double* q) const {
  double dot = 0.0;
  for (int64_t i = begin; i < end; ++i) {
    const double* d = rows_.diagonal() + 9 * i;
    const double* u = p + 3 * i;
    simd::VDouble sum;
    if constexpr (std::is_same_v<Real, float>)
      sum = multiply_differences(rows_.row_begin(i), rows_.row_end(i), rows_.column(), blocks, p,
                                 simd::load(u));
    else
      sum = multiply_row<3>(rows_.row_begin(i), rows_.row_end(i), rows_.column(), blocks, p);
    for (int r = 0; r < 3; ++r) {
      const double value = sum[r] + (d[3 * r] * u[0] + d[3 * r + 1] * u[1] + d[3 * r + 2] * u[2]);
      q[3 * i + r] = value;
      dot += u[r] * value;
    }
  }
  return dot;
}

double JacobiMatrix::multiply(const double* z, double beta, double* p, double* q, ThreadPool& pool) {
  const auto runs = static_cast<int64_t>(partial_.size());
  pool.for_each_range(runs, kRunGrain, [&](int64_t first, int64_t last) {
    for (int64_t k = 3 * run_begin_[first]; k < 3 * run_begin_[last]; ++k) p[k] = z[k] + beta * p[k];
    for (int64_t run = first; run < last && is_cluster(run); ++run)
      coarse_->add_motion(static_cast<int32_t>(run), p);
  });
  return rows_.with_blocks([&](const auto* blocks) {
    return sum_over_runs(
        pool, [&](int64_t, int64_t begin, int64_t end) { return multiply_run(blocks, begin, end, p, q); });
  });
}

double JacobiMatrix::update(double alpha, const double* p, const double* q, double* y, double* r, double* z,
                            ThreadPool& pool) {
  return correct(sum_over_runs(pool,
                               [&](int64_t run, int64_t begin, int64_t end) {
                                 for (int64_t k = 3 * begin; k < 3 * end; ++k) {
                                   y[k] += alpha * p[k];
                                   r[k] -= alpha * q[k];
                                 }
                                 return precondition(run, r, z);
                               }),
                 pool);
}

void JacobiMatrix::finish(const double* y, double* x, ThreadPool&) {
  for (int64_t i = 0; i < block_count(); ++i)
    std::copy_n(y + 3 * i, 3, x + 3 * static_cast<int64_t>(rows_.source_row(i)));
}

}  // namespace stark
