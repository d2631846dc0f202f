// Block-Jacobi conjugate gradients: expansion of the upper triangle, threaded products, fixed-order dot
// products.
#include <stark/linalg/pcg.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include <stark/base/error.h>
#include <stark/base/simd.h>

namespace stark {

namespace {

constexpr double kSurely = 1e-2;        // of the squared residual that is asked: then decreases do not matter
constexpr int64_t kRowGrain = 512;      // block rows of one task
constexpr int64_t kVectorGrain = 4096;  // scalars of one partial dot product

// Inverse of a symmetric 3x3 block (its symmetric part is taken) through its Cholesky factor; false if the
// block is not positive definite.
bool invert_spd(const double* a, double* inverse) {
  const double a10 = 0.5 * (a[1] + a[3]), a20 = 0.5 * (a[2] + a[6]), a21 = 0.5 * (a[5] + a[7]);
  if (!(a[0] > 0.0)) return false;
  const double i0 = 1.0 / std::sqrt(a[0]), l10 = a10 * i0, l20 = a20 * i0;
  const double d1 = a[4] - l10 * l10;
  if (!(d1 > 0.0)) return false;
  const double i1 = 1.0 / std::sqrt(d1), l21 = (a21 - l20 * l10) * i1;
  const double d2 = a[8] - l20 * l20 - l21 * l21;
  if (!(d2 > 0.0)) return false;
  const double i2 = 1.0 / std::sqrt(d2);
  const double m10 = -l10 * i0 * i1, m21 = -l21 * i1 * i2, m20 = -(l20 * i0 + l21 * m10) * i2;
  inverse[0] = i0 * i0 + m10 * m10 + m20 * m20;
  inverse[1] = inverse[3] = m10 * i1 + m20 * m21;
  inverse[2] = inverse[6] = m20 * i2;
  inverse[4] = i1 * i1 + m21 * m21;
  inverse[5] = inverse[7] = m21 * i2;
  inverse[8] = i2 * i2;
  return std::isfinite(inverse[0]) && std::isfinite(inverse[4]) && std::isfinite(inverse[8]);
}

simd::VDouble load_column(const double* p) { return simd::load(p); }
simd::VDouble load_column(const float* p) {
  typedef float Four __attribute__((vector_size(16)));
  Four four;
  std::memcpy(&four, p, sizeof(four));
  return __builtin_convertvector(four, simd::VDouble);
}

// Sum over a row's blocks, stored column by column: three lanes are used, the fourth reads on into what
// follows.
template <typename Real>
simd::VDouble multiply_row(int64_t begin, int64_t end, const int32_t* column, const Real* blocks,
                           const double* x) {
  simd::VDouble sum[3] = {simd::splat(0.0), simd::splat(0.0), simd::splat(0.0)};
  for (int64_t k = begin; k < end; ++k) {
    const Real* a = blocks + 9 * k;
    const double* u = x + 3 * static_cast<int64_t>(column[k]);
    for (int c = 0; c < 3; ++c) sum[c] = simd::fma(load_column(a + 3 * c), simd::splat(u[c]), sum[c]);
  }
  return (sum[0] + sum[1]) + sum[2];
}

}  // namespace

void Pcg::expand_structure(const BlockPattern& pattern) {
  const int32_t n = pattern.block_count;
  block_count_ = n;
  row_start_.assign(static_cast<size_t>(n) + 1, 0);
  for (int32_t i = 0; i < n; ++i) {
    row_start_[i + 1] += pattern.row_start[i + 1] - pattern.row_start[i] - 1;
    for (int64_t k = pattern.row_start[i] + 1; k < pattern.row_start[i + 1]; ++k)
      ++row_start_[pattern.column[k] + 1];
  }
  for (int32_t i = 0; i < n; ++i) row_start_[i + 1] += row_start_[i];
  column_.resize(row_start_[n]);
  source_.resize(row_start_[n]);
  // Rows are visited in order, so that every row receives its lower columns, then its upper ones: sorted.
  std::vector<int64_t> next(row_start_.begin(), row_start_.end() - 1);
  for (int32_t i = 0; i < n; ++i) {
    for (int64_t k = pattern.row_start[i] + 1; k < pattern.row_start[i + 1]; ++k) {
      const int32_t j = pattern.column[k];
      column_[next[j]] = i;
      source_[next[j]++] = 2 * k + 1;
      column_[next[i]] = j;
      source_[next[i]++] = 2 * k;
    }
  }
}

bool Pcg::prepare(const BlockMatrix& matrix, ThreadPool& pool, PcgStorage storage) {
  const BlockPattern& pattern = matrix.pattern;
  const uint64_t hash = pattern.hash();
  if (row_start_.empty() || hash != pattern_hash_ || pattern.block_count != block_count_) {
    expand_structure(pattern);
    pattern_hash_ = hash;
  }
  storage_ = storage;
  diagonal_.resize(9 * static_cast<size_t>(block_count_));
  inverse_.resize(diagonal_.size());
  if (storage == PcgStorage::Double) {
    blocks_.resize(9 * column_.size() + 1);  // the last column is read as four entries
  } else {
    blocks_float_.resize(9 * column_.size() + 1);
  }
  const int64_t tasks = (block_count_ + kRowGrain - 1) / kRowGrain;
  std::vector<int32_t> failed(tasks, -1);
  const auto copy_blocks = [&](auto* blocks, int64_t begin, int64_t end) {
    using Real = std::remove_reference_t<decltype(*blocks)>;
    for (int64_t k = begin; k < end; ++k) {
      const double* a = matrix.values.data() + 9 * (source_[k] >> 1);
      const int across = (source_[k] & 1) != 0 ? 3 : 1, down = 4 - across;
      for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 3; ++c) blocks[9 * k + 3 * c + r] = static_cast<Real>(a[down * r + across * c]);
    }
  };
  pool.for_each_range(block_count_, kRowGrain, [&](int64_t begin, int64_t end) {
    for (int64_t i = begin; i < end; ++i) {
      const double* d = matrix.values.data() + 9 * pattern.row_start[i];
      std::copy(d, d + 9, diagonal_.data() + 9 * i);
      if (!invert_spd(d, inverse_.data() + 9 * i) && failed[begin / kRowGrain] < 0)
        failed[begin / kRowGrain] = static_cast<int32_t>(i);
    }
    if (storage_ == PcgStorage::Double) {
      copy_blocks(blocks_.data(), row_start_[begin], row_start_[end]);
    } else {
      copy_blocks(blocks_float_.data(), row_start_[begin], row_start_[end]);
    }
  });
  failed_block_ = -1;
  for (int32_t block : failed)
    if (block >= 0 && failed_block_ < 0) failed_block_ = block;
  return failed_block_ < 0;
}

void Pcg::multiply(const double* x, double* y, ThreadPool& pool) const {
  pool.for_each_range(block_count_, kRowGrain, [&](int64_t begin, int64_t end) {
    for (int64_t i = begin; i < end; ++i) {
      const double* d = diagonal_.data() + 9 * i;
      const double* u = x + 3 * i;
      const simd::VDouble sum =
          storage_ == PcgStorage::Double
              ? multiply_row(row_start_[i], row_start_[i + 1], column_.data(), blocks_.data(), x)
              : multiply_row(row_start_[i], row_start_[i + 1], column_.data(), blocks_float_.data(), x);
      for (int r = 0; r < 3; ++r)
        y[3 * i + r] = sum[r] + (d[3 * r] * u[0] + d[3 * r + 1] * u[1] + d[3 * r + 2] * u[2]);
    }
  });
}

PcgReport Pcg::solve(std::span<const double> b, std::span<double> x, double tolerance, int max_iterations,
                     ThreadPool& pool, CoarseSpace* coarse) {
  const int64_t size = 3 * static_cast<int64_t>(block_count_);
  STARK_CHECK(static_cast<int64_t>(b.size()) == size && static_cast<int64_t>(x.size()) == size);
  PcgReport report;
  if (failed_block_ >= 0) {
    std::fill(x.begin(), x.end(), 0.0);
    report.indefinite = true;
    report.failed_block = failed_block_;
    return report;
  }
  r_.assign(b.begin(), b.end());
  z_.resize(size);
  p_.resize(size);
  q_.resize(size);
  std::fill(x.begin(), x.end(), 0.0);
  const int64_t grain = 3 * (kVectorGrain / 3);  // whole blocks
  const int64_t tasks = (size + grain - 1) / grain;
  partial_.resize(tasks);
  const auto sum_partials = [&] {
    double sum = 0.0;
    for (double part : partial_) sum += part;
    return sum;
  };
  // z = M^-1 r and r^T z in one pass.
  const auto precondition = [&](int64_t begin, int64_t end) {
    double sum = 0.0;
    for (int64_t k = begin; k < end; k += 3) {
      const double* m = inverse_.data() + 3 * k;
      const double r0 = r_[k], r1 = r_[k + 1], r2 = r_[k + 2];
      const double z0 = m[0] * r0 + m[1] * r1 + m[2] * r2;
      const double z1 = m[3] * r0 + m[4] * r1 + m[5] * r2;
      const double z2 = m[6] * r0 + m[7] * r1 + m[8] * r2;
      z_[k] = z0;
      z_[k + 1] = z1;
      z_[k + 2] = z2;
      sum += r0 * z0 + r1 * z1 + r2 * z2;
    }
    partial_[begin / grain] = sum;
  };
  const auto corrected = [&](double rz) {
    return coarse == nullptr ? rz : rz + coarse->correct(r_.data(), z_.data(), pool);
  };
  pool.for_each_range(size, grain, precondition);
  double rz = corrected(sum_partials());
  const double rz_start = rz;
  if (!(rz > 0.0)) {  // b = 0, or not finite
    report.converged = rz == 0.0;
    report.relative_residual = rz == 0.0 ? 0.0 : 1.0;
    return report;
  }
  const double rz_stop = tolerance * tolerance * rz_start;
  double beta = 0.0, total = 0.0;
  while (report.iterations < max_iterations) {
    pool.for_each_range(size, grain, [&](int64_t begin, int64_t end) {
      if (beta == 0.0) {
        std::copy(z_.data() + begin, z_.data() + end, p_.data() + begin);
      } else {
        for (int64_t k = begin; k < end; ++k) p_[k] = z_[k] + beta * p_[k];
      }
    });
    multiply(p_.data(), q_.data(), pool);
    pool.for_each_range(size, grain, [&](int64_t begin, int64_t end) {
      double sum = 0.0;
      for (int64_t k = begin; k < end; ++k) sum += p_[k] * q_[k];
      partial_[begin / grain] = sum;
    });
    const double pq = sum_partials();
    ++report.iterations;
    if (!(pq > 0.0)) {
      report.indefinite = true;
      if (report.iterations == 1) std::copy(z_.begin(), z_.end(), x.begin());
      break;
    }
    const double alpha = rz / pq;
    const double decrease = alpha * rz;
    total += decrease;
    pool.for_each_range(size, grain, [&](int64_t begin, int64_t end) {
      for (int64_t k = begin; k < end; ++k) {
        x[k] += alpha * p_[k];
        r_[k] -= alpha * q_[k];
      }
      precondition(begin, end);
    });
    const double rz_next = corrected(sum_partials());
    beta = rz_next / rz;
    rz = rz_next;
    if (!(rz > rz_stop)) {
      const bool is_settled = report.iterations * decrease <= tolerance * tolerance * total;
      if (is_settled || !(rz > kSurely * rz_stop)) {
        report.converged = rz <= rz_stop;
        break;
      }
    }
  }
  report.relative_residual = std::sqrt(rz / rz_start);
  return report;
}

}  // namespace stark
