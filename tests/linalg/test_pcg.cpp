// Conjugate gradients with each preconditioner against dense elimination; indefiniteness; independence of
// threads.
#include <stark/linalg/pcg.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

#include <doctest/doctest.h>

#include <stark/linalg/gauss_seidel_matrix.h>
#include <stark/linalg/jacobi_matrix.h>

#include "linalg/systems.h"

using namespace stark;

TEST_CASE_TEMPLATE("pcg: solution against dense elimination", Matrix, JacobiMatrix, GaussSeidelMatrix) {
  ThreadPool pool(2);
  for (int32_t n : {1, 30, 100}) {
    for (PcgStorage storage : {PcgStorage::Double, PcgStorage::Float}) {
      const BlockMatrix matrix =
          test::spd_matrix(BlockPattern::from_pairs(n, test::random_pairs(n, 3 * n, n)), 5, 100.0);
      const std::vector<double> b = test::random_vector(3 * n, 6), expected = test::dense_solve(matrix, b);
      std::vector<double> x(b.size());
      Pcg pcg;
      Matrix prepared;
      REQUIRE(prepared.prepare(matrix, storage, pool));
      const PcgReport report = pcg.solve(prepared, b, x, 1e-12, 10000, pool);
      CHECK(report.converged);
      CHECK_FALSE(report.indefinite);
      CHECK(report.relative_residual <= 1e-12);
      double error = 0.0, scale = 0.0;
      for (size_t k = 0; k < x.size(); ++k) {
        error = std::max(error, std::fabs(x[k] - expected[k]));
        scale = std::max(scale, std::fabs(expected[k]));
      }
      // Condition number about 1e3; rounding the blocks to float changes the matrix by 6e-8 of its norm.
      CHECK(error <= (storage == PcgStorage::Double ? 1e-8 : 1e-3) * scale);
    }
  }
}

TEST_CASE_TEMPLATE("pcg: a block-diagonal matrix is solved in one iteration", Matrix, JacobiMatrix,
                   GaussSeidelMatrix) {
  ThreadPool pool(1);
  const BlockMatrix matrix = test::spd_matrix(BlockPattern::from_pairs(40, {}), 5);
  const std::vector<double> b = test::random_vector(120, 6);
  std::vector<double> x(b.size());
  Pcg pcg;
  Matrix prepared;
  REQUIRE(prepared.prepare(matrix, PcgStorage::Double, pool));
  const PcgReport report = pcg.solve(prepared, b, x, 1e-10, 100, pool);
  CHECK(report.converged);
  CHECK(report.iterations == 1);
  CHECK(test::relative_residual(matrix, b, x) < 1e-14);
}

TEST_CASE_TEMPLATE("pcg: tolerance is met in the stated norm, and bits do not depend on threads", Matrix,
                   JacobiMatrix, GaussSeidelMatrix) {
  const int n = 50;
  const BlockMatrix matrix = test::spd_matrix(BlockPattern::from_pairs(n * n, test::cloth_pairs(n)), 3);
  const std::vector<double> b = test::random_vector(3 * n * n, 4);
  std::vector<double> reference;
  for (int threads : {1, 2, 5}) {
    ThreadPool pool(threads);
    std::vector<double> x(b.size());
    Pcg pcg;
    Matrix prepared;
    REQUIRE(prepared.prepare(matrix, PcgStorage::Double, pool));
    const int iterations_loose = pcg.solve(prepared, b, x, 1e-2, 10000, pool).iterations;
    const PcgReport report = pcg.solve(prepared, b, x, 1e-8, 10000, pool);
    CHECK(report.converged);
    CHECK(report.iterations > iterations_loose);
    CHECK(test::relative_residual(matrix, b, x) <
          1e-6);  // other norm: condition of the preconditioner in between
    if (threads == 1) reference = x;
    CHECK(x == reference);
    const PcgReport cut = pcg.solve(prepared, b, x, 1e-12, 3, pool);
    CHECK_FALSE(cut.converged);
    CHECK(cut.iterations == 3);
  }
}

TEST_CASE_TEMPLATE("pcg: a change of pattern is noticed", Matrix, JacobiMatrix, GaussSeidelMatrix) {
  ThreadPool pool(1);
  Pcg pcg;
  Matrix prepared;
  for (uint32_t seed = 1; seed < 5; ++seed) {
    const BlockMatrix matrix =
        test::spd_matrix(BlockPattern::from_pairs(50, test::random_pairs(50, 100, seed)), seed, 10.0);
    const std::vector<double> b = test::random_vector(150, 6);
    std::vector<double> x(b.size());
    REQUIRE(prepared.prepare(matrix, PcgStorage::Double, pool));
    CHECK(pcg.solve(prepared, b, x, 1e-12, 1000, pool).converged);
    CHECK(test::relative_residual(matrix, b, x) < 1e-10);
  }
}

TEST_CASE_TEMPLATE("pcg: indefiniteness", Matrix, JacobiMatrix, GaussSeidelMatrix) {
  ThreadPool pool(1);
  BlockMatrix matrix = test::spd_matrix(BlockPattern::from_pairs(30, test::random_pairs(30, 60, 2)), 5, 10.0);
  const std::vector<double> b = test::random_vector(90, 6);
  std::vector<double> x(b.size());
  Pcg pcg;
  Matrix prepared;
  BlockMatrix broken = matrix;
  for (int32_t block : {12, 20}) broken.values[9 * matrix.pattern.row_start[block] + 4] = -1.0;
  CHECK_FALSE(prepared.prepare(broken, PcgStorage::Double, pool));
  PcgReport report = pcg.solve(prepared, b, x, 1e-8, 1000, pool);
  CHECK(report.indefinite);
  CHECK_FALSE(report.converged);
  CHECK(report.failed_block == 12);
  // Positive definite diagonal blocks, strong coupling: only p^T A p tells.
  BlockMatrix saddle;
  saddle.pattern = BlockPattern::from_pairs(2, {{0, 1}});
  saddle.set_zero();
  for (int c = 0; c < 3; ++c)
    saddle.values[4 * c] = saddle.values[18 + 4 * c] = 1.0, saddle.values[9 + 4 * c] = 3.0;
  const std::vector<double> rhs = {1, 2, 3, -1, -1, -2};
  std::vector<double> y(6);
  REQUIRE(prepared.prepare(saddle, PcgStorage::Double, pool));
  report = pcg.solve(prepared, rhs, y, 1e-8, 1000, pool);
  CHECK(report.indefinite);
  CHECK(report.failed_block == -1);
  CHECK(std::inner_product(rhs.begin(), rhs.end(), y.begin(), 0.0) > 0.0);
}

TEST_CASE_TEMPLATE("pcg: zero right-hand side", Matrix, JacobiMatrix, GaussSeidelMatrix) {
  ThreadPool pool(1);
  const BlockMatrix matrix = test::spd_matrix(BlockPattern::from_pairs(10, {}), 5);
  const std::vector<double> b(30, 0.0);
  std::vector<double> x(30, 1.0);
  Pcg pcg;
  Matrix prepared;
  REQUIRE(prepared.prepare(matrix, PcgStorage::Double, pool));
  CHECK(pcg.solve(prepared, b, x, 1e-8, 10, pool).converged);
  CHECK(x == b);
}
