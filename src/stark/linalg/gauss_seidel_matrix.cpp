#include <stark/linalg/gauss_seidel_matrix.h>

#include <algorithm>

#include <stark/base/simd.h>
#include <stark/linalg/block_rows.h>

namespace stark {

namespace {

using simd::VDouble;

// The fourth lane of products has read on into what follows.
VDouble without_fourth(VDouble v) {
  v[3] = 0.0;
  return v;
}

// A diagonal block, or its inverse, times a vector.
VDouble multiply_block(const double* a, VDouble v) {
  const VDouble product =
      simd::fma(simd::load(a), simd::splat(v[0]),
                simd::fma(simd::load(a + 3), simd::splat(v[1]), simd::load(a + 6) * simd::splat(v[2])));
  return without_fourth(product);
}

double sum_of(VDouble v) { return (v[0] + v[1]) + v[2]; }

VDouble load3(const double* p) { return VDouble{p[0], p[1], p[2], 0.0}; }

}  // namespace

void GaussSeidelMatrix::expand_structure(const BlockPattern& pattern) {
  const int32_t n = block_count_ = pattern.block_count;
  std::vector<int64_t> below(n, 0);
  for (int32_t i = 0; i < n; ++i)
    for (int64_t slot = pattern.row_start[i] + 1; slot < pattern.row_start[i + 1]; ++slot)
      ++below[pattern.column[slot]];
  row_start_.assign(static_cast<size_t>(n) + 1, 0);
  above_.resize(n);
  for (int32_t i = 0; i < n; ++i) {
    above_[i] = row_start_[i] + below[i];
    row_start_[i + 1] = above_[i] + pattern.row_start[i + 1] - pattern.row_start[i] - 1;
  }
  column_.resize(row_start_[n]);
  source_.resize(row_start_[n]);
  below.assign(row_start_.begin(), row_start_.end() - 1);
  for (int32_t i = 0; i < n; ++i) {
    int64_t above = row_start_[i + 1];  // from the last to the first
    for (int64_t slot = pattern.row_start[i] + 1; slot < pattern.row_start[i + 1]; ++slot) {
      const int32_t j = pattern.column[slot];
      column_[--above] = j;
      source_[above] = 2 * slot;
      column_[below[j]] = i;
      source_[below[j]++] = 2 * slot + 1;
    }
  }
}

bool GaussSeidelMatrix::prepare(const BlockMatrix& matrix, PcgStorage storage, ThreadPool&) {
  const uint64_t hash = matrix.pattern.hash();
  if (row_start_.empty() || hash != pattern_hash_ || matrix.pattern.block_count != block_count_) {
    expand_structure(matrix.pattern);
    pattern_hash_ = hash;
  }
  storage_ = storage;
  diagonal_.resize(9 * static_cast<size_t>(block_count_) + 1);  // last columns are read as four entries
  inverse_.resize(diagonal_.size());
  solved_.resize(size());
  product_.resize(size());
  if (storage == PcgStorage::Double)
    blocks_.resize(9 * column_.size() + 1);
  else
    blocks_float_.resize(9 * column_.size() + 1);
  copy_blocks(matrix);
  return failed_block_ < 0;
}

void GaussSeidelMatrix::copy_blocks(const BlockMatrix& matrix) {
  failed_block_ = -1;
  for (int32_t k = 0; k < block_count_; ++k) {
    const double* d = matrix.values.data() + 9 * matrix.pattern.row_start[k];
    double* out = diagonal_.data() + 9 * k;
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c) out[3 * r + c] = 0.5 * (d[3 * r + c] + d[3 * c + r]);
    if (!invert_spd(d, inverse_.data() + 9 * k) && failed_block_ < 0) failed_block_ = k;
  }
  const auto copy = [&](auto* blocks) {
    for (size_t k = 0; k < column_.size(); ++k)
      copy_columns(matrix.values.data() + 9 * (source_[k] >> 1), (source_[k] & 1) != 0, blocks + 9 * k);
  };
  if (storage_ == PcgStorage::Double)
    copy(blocks_.data());
  else
    copy(blocks_float_.data());
}

template <typename Sweep>
auto GaussSeidelMatrix::with_blocks(Sweep&& sweep) {
  return storage_ == PcgStorage::Double ? sweep(blocks_.data()) : sweep(blocks_float_.data());
}

// r = K^-1 b and z = D r.
double GaussSeidelMatrix::start(const double* b, double* r, double* z, ThreadPool&) {
  return with_blocks([&](const auto* blocks) {
    double sum = 0.0;
    for (int64_t i = 0; i < block_count_; ++i) {
      const VDouble below = multiply_row<4>(row_start_[i], above_[i], column_.data(), blocks, r);
      const VDouble given = load3(b + 3 * i);
      const VDouble left = multiply_block(inverse_.data() + 9 * i, given - below);
      const VDouble turned = multiply_block(diagonal_.data() + 9 * i, left);
      simd::store(r + 4 * i, left);
      simd::store(z + 4 * i, turned);
      sum += sum_of(left * turned);
    }
    return sum;
  });
}

// With t = K^-T p, K^-1 A K^-T p = t + K^-1 (p - D t), where p - D t is what is above times t.
double GaussSeidelMatrix::multiply(const double* z, double beta, double* p, double* q, ThreadPool&) {
  double *t = solved_.data(), *product = product_.data();
  return with_blocks([&](const auto* blocks) {
    for (int64_t i = block_count_; i-- > 0;) {
      const VDouble direction = simd::load(z + 4 * i) + simd::splat(beta) * simd::load(p + 4 * i);
      const VDouble above = multiply_row<4>(above_[i], row_start_[i + 1], column_.data(), blocks, t);
      simd::store(p + 4 * i, direction);
      simd::store(product + 4 * i, above);
      simd::store(t + 4 * i, multiply_block(inverse_.data() + 9 * i, direction - above));
    }
    VDouble sum = simd::splat(0.0);
    double* u = product;  // row by row in the place of the product
    for (int64_t i = 0; i < block_count_; ++i) {
      const VDouble below = multiply_row<4>(row_start_[i], above_[i], column_.data(), blocks, u);
      const VDouble left = multiply_block(inverse_.data() + 9 * i, simd::load(product + 4 * i) - below);
      const VDouble both = simd::load(t + 4 * i) + left;
      simd::store(u + 4 * i, left);
      simd::store(q + 4 * i, both);
      sum = sum + simd::load(p + 4 * i) * both;
    }
    return sum_of(sum);
  });
}

double GaussSeidelMatrix::update(double alpha, const double* p, const double* q, double* y, double* r,
                                 double* z, ThreadPool&) {
  VDouble sum = simd::splat(0.0);
  const VDouble step = simd::splat(alpha);
  for (int64_t i = 0; i < block_count_; ++i) {
    simd::store(y + 4 * i, simd::load(y + 4 * i) + step * simd::load(p + 4 * i));
    const VDouble left = simd::load(r + 4 * i) - step * simd::load(q + 4 * i);
    const VDouble turned = multiply_block(diagonal_.data() + 9 * i, left);
    simd::store(r + 4 * i, left);
    simd::store(z + 4 * i, turned);
    sum = sum + left * turned;
  }
  return sum_of(sum);
}

// x = K^-T y.
void GaussSeidelMatrix::finish(const double* y, double* x, ThreadPool&) {
  double* t = solved_.data();
  with_blocks([&](const auto* blocks) {
    for (int64_t i = block_count_; i-- > 0;) {
      const VDouble above = multiply_row<4>(above_[i], row_start_[i + 1], column_.data(), blocks, t);
      const VDouble solved = multiply_block(inverse_.data() + 9 * i, simd::load(y + 4 * i) - above);
      simd::store(t + 4 * i, solved);
      for (int a = 0; a < 3; ++a) x[3 * i + a] = solved[a];
    }
    return 0;
  });
}

}  // namespace stark
