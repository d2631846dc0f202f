#include <stark/linalg/jacobi_matrix.h>

#include <algorithm>
#include <numeric>

#include <stark/linalg/block_rows.h>

namespace stark {

namespace {

constexpr int64_t kRowGrain = 512;          // block rows of one task
constexpr int64_t kVectorGrain = 3 * 1365;  // numbers of one partial dot product, whole blocks

}  // namespace

void JacobiMatrix::apply(const double* x, double* y, ThreadPool& pool) const {
  pool.for_each_range(block_count(), kRowGrain, [&](int64_t begin, int64_t end) {
    rows_.with_blocks([&](const auto* blocks) {
      for (int64_t i = begin; i < end; ++i) {
        const double* d = rows_.diagonal() + 9 * i;
        const double* u = x + 3 * i;
        const auto sum = multiply_row<3>(rows_.row_begin(i), rows_.row_end(i), rows_.column(), blocks, x);
        for (int r = 0; r < 3; ++r)
          y[3 * i + r] = sum[r] + (d[3 * r] * u[0] + d[3 * r + 1] * u[1] + d[3 * r + 2] * u[2]);
      }
    });
  });
}

// z = D^-1 r of the numbers [begin, end), whole blocks. Returns r^T z.
double JacobiMatrix::precondition(int64_t begin, int64_t end, const double* r, double* z) const {
  double sum = 0.0;
  for (int64_t k = begin; k < end; k += 3) {
    const double* m = rows_.inverse() + 3 * k;
    const double r0 = r[k], r1 = r[k + 1], r2 = r[k + 2];
    const double z0 = m[0] * r0 + m[1] * r1 + m[2] * r2;
    const double z1 = m[3] * r0 + m[4] * r1 + m[5] * r2;
    const double z2 = m[6] * r0 + m[7] * r1 + m[8] * r2;
    z[k] = z0;
    z[k + 1] = z1;
    z[k + 2] = z2;
    sum += r0 * z0 + r1 * z1 + r2 * z2;
  }
  return sum;
}

// r^T z of the partial sums, and of what the coarse space adds to z.
double JacobiMatrix::corrected(const double* r, double* z, ThreadPool& pool) {
  const double sum = std::accumulate(partial_.begin(), partial_.end(), 0.0);
  return coarse_ == nullptr ? sum : sum + coarse_->correct(r, z, pool);
}

double JacobiMatrix::start(const double* b, double* r, double* z, ThreadPool& pool) {
  partial_.assign((size() + kVectorGrain - 1) / kVectorGrain, 0.0);
  std::copy(b, b + size(), r);
  pool.for_each_range(size(), kVectorGrain, [&](int64_t begin, int64_t end) {
    partial_[begin / kVectorGrain] = precondition(begin, end, r, z);
  });
  return corrected(r, z, pool);
}

double JacobiMatrix::multiply(const double* z, double beta, double* p, double* q, ThreadPool& pool) {
  pool.for_each_range(size(), kVectorGrain, [&](int64_t begin, int64_t end) {
    for (int64_t k = begin; k < end; ++k) p[k] = z[k] + beta * p[k];
  });
  apply(p, q, pool);
  pool.for_each_range(size(), kVectorGrain, [&](int64_t begin, int64_t end) {
    partial_[begin / kVectorGrain] = std::inner_product(p + begin, p + end, q + begin, 0.0);
  });
  return std::accumulate(partial_.begin(), partial_.end(), 0.0);
}

double JacobiMatrix::update(double alpha, const double* p, const double* q, double* y, double* r, double* z,
                            ThreadPool& pool) {
  pool.for_each_range(size(), kVectorGrain, [&](int64_t begin, int64_t end) {
    for (int64_t k = begin; k < end; ++k) {
      y[k] += alpha * p[k];
      r[k] -= alpha * q[k];
    }
    partial_[begin / kVectorGrain] = precondition(begin, end, r, z);
  });
  return corrected(r, z, pool);
}

void JacobiMatrix::finish(const double* y, double* x, ThreadPool&) { std::copy(y, y + size(), x); }

}  // namespace stark
