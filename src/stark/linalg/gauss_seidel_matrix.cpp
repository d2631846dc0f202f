#include <stark/linalg/gauss_seidel_matrix.h>

#include <utility>

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

bool GaussSeidelMatrix::prepare(const BlockMatrix& matrix, PcgStorage storage, ThreadPool& pool) {
  const bool is_definite = rows_.prepare(matrix, storage, pool);
  solved_.resize(size());
  product_.resize(size());
  // Rounding may have left the diagonal blocks unsymmetric, and M would be.
  for (double* d = rows_.diagonal(); d != rows_.diagonal() + 9 * static_cast<int64_t>(block_count()); d += 9)
    for (const auto [upper, lower] : {std::pair(1, 3), {2, 6}, {5, 7}})
      d[upper] = d[lower] = 0.5 * (d[upper] + d[lower]);
  return is_definite;
}

// r = K^-1 b and z = D r.
double GaussSeidelMatrix::start(const double* b, double* r, double* z, ThreadPool&) {
  return rows_.with_blocks([&](const auto* blocks) {
    double sum = 0.0;
    for (int64_t i = 0; i < block_count(); ++i) {
      const VDouble below = multiply_row<4>(rows_.row_begin(i), rows_.above(i), rows_.column(), blocks, r);
      const VDouble given = load3(b + 3 * i);
      const VDouble left = multiply_block(rows_.inverse() + 9 * i, given - below);
      const VDouble turned = multiply_block(rows_.diagonal() + 9 * i, left);
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
  return rows_.with_blocks([&](const auto* blocks) {
    for (int64_t i = block_count(); i-- > 0;) {
      const VDouble direction = simd::load(z + 4 * i) + simd::splat(beta) * simd::load(p + 4 * i);
      const VDouble above = multiply_row<4>(rows_.above(i), rows_.row_end(i), rows_.column(), blocks, t);
      simd::store(p + 4 * i, direction);
      simd::store(product + 4 * i, above);
      simd::store(t + 4 * i, multiply_block(rows_.inverse() + 9 * i, direction - above));
    }
    VDouble sum = simd::splat(0.0);
    double* u = product;  // row by row in the place of the product
    for (int64_t i = 0; i < block_count(); ++i) {
      const VDouble below = multiply_row<4>(rows_.row_begin(i), rows_.above(i), rows_.column(), blocks, u);
      const VDouble left = multiply_block(rows_.inverse() + 9 * i, simd::load(product + 4 * i) - below);
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
  for (int64_t i = 0; i < block_count(); ++i) {
    simd::store(y + 4 * i, simd::load(y + 4 * i) + step * simd::load(p + 4 * i));
    const VDouble left = simd::load(r + 4 * i) - step * simd::load(q + 4 * i);
    const VDouble turned = multiply_block(rows_.diagonal() + 9 * i, left);
    simd::store(r + 4 * i, left);
    simd::store(z + 4 * i, turned);
    sum = sum + left * turned;
  }
  return sum_of(sum);
}

// x = K^-T y.
void GaussSeidelMatrix::finish(const double* y, double* x, ThreadPool&) {
  double* t = solved_.data();
  rows_.with_blocks([&](const auto* blocks) {
    for (int64_t i = block_count(); i-- > 0;) {
      const VDouble above = multiply_row<4>(rows_.above(i), rows_.row_end(i), rows_.column(), blocks, t);
      const VDouble solved = multiply_block(rows_.inverse() + 9 * i, simd::load(y + 4 * i) - above);
      simd::store(t + 4 * i, solved);
      for (int a = 0; a < 3; ++a) x[3 * i + a] = solved[a];
    }
    return 0;
  });
}

}  // namespace stark
