#include <stark/linalg/jacobi_matrix.h>

#include <algorithm>
#include <numeric>

#include <stark/linalg/block_rows.h>

namespace stark {

namespace {

constexpr int64_t kRowGrain = 512;          // block rows of one task
constexpr int64_t kVectorGrain = 3 * 1365;  // numbers of one partial dot product, whole blocks

}  // namespace

void JacobiMatrix::expand_structure(const BlockPattern& pattern) {
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

bool JacobiMatrix::prepare(const BlockMatrix& matrix, PcgStorage storage, ThreadPool& pool) {
  const BlockPattern& pattern = matrix.pattern;
  const uint64_t hash = pattern.hash();
  if (row_start_.empty() || hash != pattern_hash_ || pattern.block_count != block_count_) {
    expand_structure(pattern);
    pattern_hash_ = hash;
  }
  storage_ = storage;
  diagonal_.resize(9 * static_cast<size_t>(block_count_));
  inverse_.resize(diagonal_.size());
  if (storage == PcgStorage::Double)
    blocks_.resize(9 * column_.size() + 1);  // the last column is read as four entries
  else
    blocks_float_.resize(9 * column_.size() + 1);
  std::vector<int32_t> failed((block_count_ + kRowGrain - 1) / kRowGrain, -1);
  const auto copy = [&](auto* blocks, int64_t begin, int64_t end) {
    for (int64_t k = begin; k < end; ++k)
      copy_columns(matrix.values.data() + 9 * (source_[k] >> 1), (source_[k] & 1) != 0, blocks + 9 * k);
  };
  pool.for_each_range(block_count_, kRowGrain, [&](int64_t begin, int64_t end) {
    for (int64_t i = begin; i < end; ++i) {
      const double* d = matrix.values.data() + 9 * pattern.row_start[i];
      std::copy(d, d + 9, diagonal_.data() + 9 * i);
      if (!invert_spd(d, inverse_.data() + 9 * i) && failed[begin / kRowGrain] < 0)
        failed[begin / kRowGrain] = static_cast<int32_t>(i);
    }
    if (storage_ == PcgStorage::Double)
      copy(blocks_.data(), row_start_[begin], row_start_[end]);
    else
      copy(blocks_float_.data(), row_start_[begin], row_start_[end]);
  });
  const auto first = std::ranges::find_if(failed, [](int32_t block) { return block >= 0; });
  failed_block_ = first == failed.end() ? -1 : *first;
  return failed_block_ < 0;
}

void JacobiMatrix::apply(const double* x, double* y, ThreadPool& pool) const {
  pool.for_each_range(block_count_, kRowGrain, [&](int64_t begin, int64_t end) {
    for (int64_t i = begin; i < end; ++i) {
      const double* d = diagonal_.data() + 9 * i;
      const double* u = x + 3 * i;
      const simd::VDouble sum =
          storage_ == PcgStorage::Double
              ? multiply_row<3>(row_start_[i], row_start_[i + 1], column_.data(), blocks_.data(), x)
              : multiply_row<3>(row_start_[i], row_start_[i + 1], column_.data(), blocks_float_.data(), x);
      for (int r = 0; r < 3; ++r)
        y[3 * i + r] = sum[r] + (d[3 * r] * u[0] + d[3 * r + 1] * u[1] + d[3 * r + 2] * u[2]);
    }
  });
}

// z = D^-1 r of the numbers [begin, end), whole blocks. Returns r^T z.
double JacobiMatrix::precondition(int64_t begin, int64_t end, const double* r, double* z) const {
  double sum = 0.0;
  for (int64_t k = begin; k < end; k += 3) {
    const double* m = inverse_.data() + 3 * k;
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
