// Symmetric Gauss-Seidel: the split matrix and its preconditioner against the matrix; the gain.
#include <stark/linalg/gauss_seidel_matrix.h>

#include <numeric>

#include <doctest/doctest.h>

#include <stark/linalg/jacobi_matrix.h>

#include "linalg/systems.h"

using namespace stark;

TEST_CASE("the split matrix is K^-1 A K^-T, preconditioned by D^-1") {
  // For p = K^T x its product is K^-1 A x, which start() says of A x. r^T z = r^T D r = b^T M^-1 b.
  const int32_t n = 40;
  const BlockMatrix matrix =
      test::spd_matrix(BlockPattern::from_pairs(n, test::random_pairs(n, 4 * n, 2)), 5, 10.0);
  ThreadPool pool(1);
  GaussSeidelMatrix split;
  REQUIRE(split.prepare(matrix, PcgStorage::Double, pool));
  std::vector<double> p(split.size(), 0.0), q(p), z(p), r(p), unused(p);
  const std::vector<double> y = test::random_vector(split.size(), 7);
  for (size_t k = 0; k < y.size(); ++k) z[k] = k % 4 == 3 ? 0.0 : y[k];
  const double pq = split.multiply(z.data(), 0.0, p.data(), q.data(), pool);
  std::vector<double> x(3 * n), product(3 * n);
  split.finish(p.data(), x.data(), pool);
  matrix.multiply(x.data(), product.data(), pool);
  const double rz = split.start(product.data(), r.data(), unused.data(), pool);
  for (size_t k = 0; k < q.size(); ++k) CHECK(q[k] == doctest::Approx(r[k]).epsilon(1e-9).scale(1.0));
  CHECK(pq == doctest::Approx(std::inner_product(x.begin(), x.end(), product.begin(), 0.0)).epsilon(1e-10));
  CHECK(rz > 0.0);
}

TEST_CASE("symmetric Gauss-Seidel takes six tenths of the iterations of block-Jacobi or less") {
  const int n = 40;
  const BlockMatrix matrix = test::spd_matrix(BlockPattern::from_pairs(n * n, test::cloth_pairs(n)), 3, 1e3);
  const std::vector<double> b = test::random_vector(3 * n * n, 4);
  std::vector<double> x(b.size());
  ThreadPool pool(1);
  Pcg pcg;
  JacobiMatrix jacobi;
  REQUIRE(jacobi.prepare(matrix, PcgStorage::Double, pool));
  const int plain = pcg.solve(jacobi, b, x, 1e-8, 10000, pool).iterations;
  GaussSeidelMatrix split;
  REQUIRE(split.prepare(matrix, PcgStorage::Double, pool));
  const PcgReport report = pcg.solve(split, b, x, 1e-8, 10000, pool);
  CHECK(report.converged);
  CHECK(10 * report.iterations <= 6 * plain);
  CHECK(test::relative_residual(matrix, b, x) < 1e-6);
}
