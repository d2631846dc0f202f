// The expanded matrix of block-Jacobi: its product, with and without a coarse space.
#include <stark/linalg/jacobi_matrix.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>

#include <doctest/doctest.h>

#include "linalg/systems.h"

using namespace stark;

namespace {

// A p by one multiply(), where p = z, back in the order of the matrix.
struct Product {
  std::vector<double> p, q;
  double dot;
};
Product multiply(JacobiMatrix& jacobi, const std::vector<double>& b, ThreadPool& pool) {
  std::vector<double> r(jacobi.size()), z(r.size()), p(r.size()), q(r.size());
  jacobi.start(b.data(), r.data(), z.data(), pool);
  Product product{std::vector<double>(b.size()), std::vector<double>(b.size()), 0.0};
  product.dot = jacobi.multiply(z.data(), 0.0, p.data(), q.data(), pool);
  jacobi.finish(p.data(), product.p.data(), pool);
  jacobi.finish(q.data(), product.q.data(), pool);
  return product;
}

double largest(std::span<const double> values) {
  double result = 0.0;
  for (const double value : values) result = std::max(result, std::fabs(value));
  return result;
}

}  // namespace

TEST_CASE("the expanded form has the product of the matrix, on any number of threads") {
  const int n = 50;
  const BlockMatrix matrix = test::spd_matrix(BlockPattern::from_pairs(n * n, test::cloth_pairs(n)), 3);
  const std::vector<double> b = test::random_vector(3 * n * n, 4);
  std::vector<Vec3> positions;
  for (int i = 0; i < n * n; ++i) positions.push_back({0.1 * (i / n), 0.1 * (i % n), 0.0});
  for (const bool corrected : {false, true})
    for (const PcgStorage storage : {PcgStorage::Double, PcgStorage::Float}) {
      std::vector<double> reference;
      for (int threads : {1, 2, 5}) {
        CAPTURE(corrected);
        CAPTURE(threads);
        ThreadPool pool(threads);
        CoarseSpace coarse;
        coarse.prepare(matrix.pattern);
        coarse.set_positions(positions);
        REQUIRE(coarse.factor(matrix, pool));
        JacobiMatrix jacobi;
        if (corrected) jacobi.set_coarse_space(&coarse);
        REQUIRE(jacobi.prepare(matrix, storage, pool));
        const Product product = multiply(jacobi, b, pool);
        std::vector<double> expected(b.size());
        matrix.multiply(product.p.data(), expected.data(), pool);
        const double rounding = storage == PcgStorage::Double ? 1e-14 : 1e-6;
        const double scale = rounding * largest(matrix.values) * largest(product.p);
        for (size_t k = 0; k < b.size(); ++k) REQUIRE(std::fabs(product.q[k] - expected[k]) < scale);
        CHECK(product.dot == doctest::Approx(std::inner_product(product.p.begin(), product.p.end(),
                                                                product.q.begin(), 0.0)));
        if (reference.empty()) reference = product.q;
        CHECK(product.q == reference);
      }
    }
}

TEST_CASE("single precision keeps what a translation of all rows meets") {
  // Springs of 1e6 N/m with a mass of 1e-3 at each block: rounding of the blocks alone would be 0.1.
  const int n = 20;
  BlockMatrix matrix;
  matrix.pattern = BlockPattern::from_pairs(n * n, test::cloth_pairs(n));
  matrix.set_zero();
  const auto entry = [&](int32_t i, int32_t j, int a) -> double& {
    return matrix.values[9 * matrix.pattern.slot(i, j) + 4 * a];
  };
  for (int32_t i = 0; i < n * n; ++i)
    for (int64_t k = matrix.pattern.row_start[i] + 1; k < matrix.pattern.row_start[i + 1]; ++k)
      for (int a = 0; a < 3; ++a) {
        const int32_t j = matrix.pattern.column[k];
        const double stiffness = 1e6 / 3.0;
        entry(i, j, a) -= stiffness;
        entry(i, i, a) += stiffness;
        entry(j, j, a) += stiffness;
      }
  for (int32_t i = 0; i < n * n; ++i)
    for (int a = 0; a < 3; ++a) entry(i, i, a) += 1e-3;
  ThreadPool pool(1);
  JacobiMatrix jacobi;
  REQUIRE(jacobi.prepare(matrix, PcgStorage::Float, pool));
  std::vector<double> ones(jacobi.size(), 1.0), p(ones.size()), q(ones.size());
  jacobi.multiply(ones.data(), 0.0, p.data(), q.data(), pool);
  for (size_t k = 0; k + 1 < q.size(); ++k) REQUIRE(q[k] == doctest::Approx(1e-3).epsilon(1e-5));
}
