// Cholesky as a linear solver: single precision gives way to double, and the ordering of a step is its own.
#include <stark/linalg/direct_solver.h>

#include <doctest/doctest.h>

#include "linalg/systems.h"

using namespace stark;

TEST_CASE("direct solver: nothing is solved again after a failure") {
  ThreadPool pool(1);
  BlockMatrix matrix;
  matrix.pattern = BlockPattern::from_pairs(1, {});
  matrix.set_zero();
  std::vector<double> b{1.0, 2.0, 3.0}, x(3);
  CholeskySolver solver({}, pool);
  for (int c = 0; c < 3; ++c) matrix.values[4 * c] = 2.0;
  REQUIRE(solver.solve({.A = matrix, .b = b, .tolerance = 1e-4}, x).ok);
  CHECK(solver.solve_again({.A = matrix, .b = b, .tolerance = 1e-4}, x).ok);
  CHECK(x[2] == doctest::Approx(1.5));
  matrix.values[4] = -2.0;
  REQUIRE_FALSE(solver.solve({.A = matrix, .b = b, .tolerance = 1e-4}, x).ok);
  CHECK_FALSE(solver.solve_again({.A = matrix, .b = b, .tolerance = 1e-4}, x).ok);
}

TEST_CASE("direct solver: single precision gives way to double where it cannot work") {
  ThreadPool pool(1);
  // A chain of springs of stiffness 1 with masses of 1e-9 is positive definite in double, singular in float.
  const int n = 200;
  test::Pairs pairs;
  for (int i = 1; i < n; ++i) pairs.emplace_back(i - 1, i);
  BlockMatrix matrix;
  matrix.pattern = BlockPattern::from_pairs(n, pairs);
  matrix.set_zero();
  for (int i = 0; i < n; ++i) {
    const int64_t d = matrix.pattern.row_start[i];
    for (int c = 0; c < 3; ++c) {
      matrix.values[9 * d + 4 * c] = 1e-9 + (i > 0) + (i + 1 < n);
      if (i + 1 < n) matrix.values[9 * (d + 1) + 4 * c] = -1.0;
    }
  }
  std::vector<double> b = test::random_vector(3 * n, 5), x(b.size());
  CholeskyFloatSolver solver({}, pool);
  const LinearSolveReport report = solver.solve({.A = matrix, .b = b, .tolerance = 1e-2}, x);
  CHECK(report.ok);
  CHECK(test::relative_residual(matrix, b, x) < 1e-8);
}

TEST_CASE("direct solver: a step that starts on the pattern it was analysed for has no history either") {
  ThreadPool pool(1);
  int32_t count = 0;
  const test::Pairs pairs = test::solid_pairs(6, count);
  test::Pairs more = pairs;
  for (int32_t i = 0; i + 40 < count; i += 3) more.emplace_back(i, i + 40);
  const BlockMatrix first = test::spd_matrix(BlockPattern::from_pairs(count, more), 3);
  const BlockMatrix second = test::spd_matrix(BlockPattern::from_pairs(count, pairs), 5);
  const std::vector<double> b = test::random_vector(3 * count, 4);
  std::vector<double> x(b.size()), y(b.size());
  CholeskySolver with_history({}, pool);
  CholeskySolver fresh({}, pool);
  with_history.begin_step();
  CHECK(with_history.solve({.A = first, .b = b, .tolerance = 1e-4}, x).ok);
  for (auto* solver : {&with_history, &fresh}) {
    std::vector<double>& result = solver == &fresh ? y : x;
    solver->begin_step();
    CHECK(solver->solve({.A = first, .b = b, .tolerance = 1e-4}, result).ok);
    CHECK(solver->solve({.A = second, .b = b, .tolerance = 1e-4}, result).ok);  // on the ordering of `first`
  }
  CHECK(x == y);
}
