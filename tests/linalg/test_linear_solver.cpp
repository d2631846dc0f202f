// The linear solver of a Newton step: every kind solves, failures are reported, and the automatic choice is
// reproducible.
#include <stark/linalg/linear_solver.h>

#include <cmath>

#include <doctest/doctest.h>
#include <stark/base/error.h>

#include "linalg/systems.h"

using namespace stark;

TEST_CASE("linear solver: every kind, float with refinement as good as double") {
  ThreadPool pool(2);
  const int n = 30;
  const BlockMatrix matrix = test::spd_matrix(BlockPattern::from_pairs(n * n, test::cloth_pairs(n)), 3, 1e4);
  const std::vector<double> b = test::random_vector(3 * n * n, 4);
  std::vector<double> exact;
  for (LinearSolverKind kind : {LinearSolverKind::Cholesky, LinearSolverKind::CholeskyFloat,
                                LinearSolverKind::Pcg, LinearSolverKind::Automatic}) {
    LinearSolver solver({.kind = kind, .pcg_tolerance = 1e-10}, pool);
    std::vector<double> x(b.size());
    const LinearSolveReport report = solver.solve(matrix, b, x, 1e-10);
    CHECK(report.ok);
    CHECK_FALSE(report.indefinite);
    CHECK(report.failed_block == -1);
    CHECK(report.used == (kind == LinearSolverKind::Automatic ? LinearSolverKind::Cholesky : kind));
    CHECK(report.factorizations == (kind == LinearSolverKind::Pcg ? 0 : 1));
    CHECK((report.iterations > 0) ==
          (kind == LinearSolverKind::Pcg || kind == LinearSolverKind::CholeskyFloat));
    const double residual = test::relative_residual(matrix, b, x);
    if (kind == LinearSolverKind::Cholesky) {
      CHECK(residual < 1e-12);
      exact = x;
    } else if (kind == LinearSolverKind::CholeskyFloat) {
      CHECK(residual <= 1.01e-10);
      CHECK(report.relative_residual == doctest::Approx(residual).epsilon(0.01));
    } else {
      CHECK(residual < 1e-8);
    }
    for (size_t k = 0; k < x.size(); ++k) REQUIRE(std::fabs(x[k] - exact[k]) < 1e-6);
  }
}

TEST_CASE("linear solver: another right-hand side is solved for with what the last solve left") {
  ThreadPool pool(2);
  const int n = 30;
  const BlockMatrix matrix = test::spd_matrix(BlockPattern::from_pairs(n * n, test::cloth_pairs(n)), 3, 1e4);
  const std::vector<double> first = test::random_vector(3 * n * n, 4), b = test::random_vector(3 * n * n, 5);
  for (LinearSolverKind kind :
       {LinearSolverKind::Cholesky, LinearSolverKind::CholeskyFloat, LinearSolverKind::Pcg}) {
    LinearSolver solver({.kind = kind, .pcg_tolerance = 1e-10}, pool);
    std::vector<double> x(b.size());
    CHECK_FALSE(solver.solve_again(matrix, b, x, 1e-8).ok);  // there was none
    REQUIRE(solver.solve(matrix, first, x, 1e-8).ok);
    const LinearSolveReport report = solver.solve_again(matrix, b, x, 1e-8);
    CHECK(report.ok);
    CHECK(report.used == kind);
    CHECK(report.factorizations == 0);
    CHECK(test::relative_residual(matrix, b, x) < (kind == LinearSolverKind::Pcg ? 1e-6 : 1e-8));
  }
}

TEST_CASE("linear solver: nothing is solved again after a failure") {
  ThreadPool pool(1);
  BlockMatrix matrix;
  matrix.pattern = BlockPattern::from_pairs(1, {});
  matrix.set_zero();
  std::vector<double> b{1.0, 2.0, 3.0}, x(3);
  LinearSolver solver({.kind = LinearSolverKind::Cholesky}, pool);
  for (int c = 0; c < 3; ++c) matrix.values[4 * c] = 2.0;
  REQUIRE(solver.solve(matrix, b, x, 1e-4).ok);
  CHECK(solver.solve_again(matrix, b, x, 1e-4).ok);
  CHECK(x[2] == doctest::Approx(1.5));
  matrix.values[4] = -2.0;
  REQUIRE_FALSE(solver.solve(matrix, b, x, 1e-4).ok);
  CHECK_FALSE(solver.solve_again(matrix, b, x, 1e-4).ok);
}

TEST_CASE("linear solver: single precision gives way to double where it cannot work") {
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
  LinearSolver solver({.kind = LinearSolverKind::CholeskyFloat}, pool);
  const LinearSolveReport report = solver.solve(matrix, b, x, 1e-2);
  CHECK(report.ok);
  CHECK(test::relative_residual(matrix, b, x) < 1e-8);
}

TEST_CASE("linear solver: indefinite matrices") {
  ThreadPool pool(1);
  BlockMatrix matrix = test::spd_matrix(BlockPattern::from_pairs(100, test::cloth_pairs(10)), 3, 100.0);
  matrix.values[9 * matrix.pattern.row_start[42]] = -5.0;
  const std::vector<double> b = test::random_vector(300, 4);
  for (LinearSolverKind kind : {LinearSolverKind::Cholesky, LinearSolverKind::CholeskyFloat,
                                LinearSolverKind::Pcg, LinearSolverKind::Automatic}) {
    LinearSolver solver({.kind = kind}, pool);
    std::vector<double> x(b.size());
    const LinearSolveReport report = solver.solve(matrix, b, x, 1e-4);
    CHECK_FALSE(report.ok);
    CHECK(report.indefinite);
    CHECK(report.failed_block == 42);
  }
}

TEST_CASE("linear solver: symbolic work only when the pattern changes") {
  ThreadPool pool(1);
  LinearSolver solver({}, pool);
  BlockMatrix matrix = test::spd_matrix(BlockPattern::from_pairs(400, test::cloth_pairs(20)), 3);
  const std::vector<double> b = test::random_vector(1200, 4);
  std::vector<double> x(b.size());
  for (uint32_t k = 0; k < 3; ++k) {
    matrix = test::spd_matrix(matrix.pattern, k);
    CHECK(solver.solve(matrix, b, x, 1e-4).ok);
    CHECK(test::relative_residual(matrix, b, x) < 1e-10);
  }
  CHECK(solver.analysis_count() == 1);
  std::vector<int64_t> slots;
  const test::Pairs contact = {{3, 7}};
  matrix = test::spd_matrix(matrix.pattern.merged_with(contact, slots), 9);
  CHECK(solver.solve(matrix, b, x, 1e-4).ok);
  CHECK(test::relative_residual(matrix, b, x) < 1e-10);
  CHECK(solver.analysis_count() == 2);
  CHECK(solver.ordering_count() == 1);
}

TEST_CASE(
    "linear solver: steps on an easy solid start with conjugate gradients and fall back when it turns "
    "stiff") {
  ThreadPool pool(1);
  int32_t count = 0;
  const test::Pairs pairs = test::solid_pairs(24, count);
  // Inertia dominates: a handful of iterations suffice, while the factorisation has solid fill.
  BlockMatrix matrix = test::spd_matrix(BlockPattern::from_pairs(count, pairs), 3, 1.0);
  for (int32_t i = 0; i < count; ++i)
    for (int c = 0; c < 3; ++c) matrix.values[9 * matrix.pattern.row_start[i] + 4 * c] += 100.0;
  const std::vector<double> b = test::random_vector(3 * count, 4);
  std::vector<double> x(b.size());
  LinearSolver solver({}, pool);
  solver.prepare(matrix.pattern);
  solver.begin_step();
  LinearSolveReport report = solver.solve(matrix, b, x, 1e-4);
  CHECK(report.ok);
  CHECK(report.used == LinearSolverKind::Pcg);
  CHECK(report.iterations < 40);
  // The material turns stiff: the cap is hit, the same call falls back to the factorisation, and so does the
  // rest of the step.
  const BlockMatrix stiff = test::spd_matrix(matrix.pattern, 3, 1e10);
  report = solver.solve(stiff, b, x, 1e-4);
  CHECK(report.ok);
  CHECK(report.used == LinearSolverKind::Cholesky);
  CHECK(report.iterations > 0);
  CHECK(solver.solve(matrix, b, x, 1e-4).used == LinearSolverKind::Cholesky);
  solver.begin_step();
  CHECK(solver.solve(matrix, b, x, 1e-4).used == LinearSolverKind::Pcg);
}

TEST_CASE("linear solver: the bits of a step depend on the systems of that step only") {
  ThreadPool pool(1);
  int32_t count = 0;
  const test::Pairs pairs = test::solid_pairs(6, count);
  test::Pairs more = pairs;
  for (int32_t i = 0; i + 40 < count; i += 3) more.emplace_back(i, i + 40);
  const BlockMatrix first = test::spd_matrix(BlockPattern::from_pairs(count, more), 3);
  const BlockMatrix second = test::spd_matrix(BlockPattern::from_pairs(count, pairs), 5);
  const std::vector<double> b = test::random_vector(3 * count, 4);
  std::vector<double> x(b.size()), y(b.size());
  LinearSolver with_history({}, pool), fresh({}, pool);
  with_history.prepare(second.pattern);
  fresh.prepare(second.pattern);
  with_history.begin_step();
  CHECK(with_history.solve(first, b, x, 1e-4).ok);
  CHECK(with_history.solve(second, b, x, 1e-4).ok);  // on the ordering of `first`
  for (LinearSolver* solver : {&with_history, &fresh}) {
    solver->begin_step();
    CHECK(solver->solve(second, b, solver == &fresh ? y : x, 1e-4).ok);
  }
  CHECK(x == y);
}

TEST_CASE("linear solver: a step that starts on the pattern it was analysed for has no history either") {
  ThreadPool pool(1);
  int32_t count = 0;
  const test::Pairs pairs = test::solid_pairs(6, count);
  test::Pairs more = pairs;
  for (int32_t i = 0; i + 40 < count; i += 3) more.emplace_back(i, i + 40);
  const BlockMatrix first = test::spd_matrix(BlockPattern::from_pairs(count, more), 3);
  const BlockMatrix second = test::spd_matrix(BlockPattern::from_pairs(count, pairs), 5);
  const std::vector<double> b = test::random_vector(3 * count, 4);
  std::vector<double> x(b.size()), y(b.size());
  LinearSolver with_history({.kind = LinearSolverKind::Cholesky}, pool);
  LinearSolver fresh({.kind = LinearSolverKind::Cholesky}, pool);
  with_history.begin_step();
  CHECK(with_history.solve(first, b, x, 1e-4).ok);
  for (LinearSolver* solver : {&with_history, &fresh}) {
    std::vector<double>& result = solver == &fresh ? y : x;
    solver->begin_step();
    CHECK(solver->solve(first, b, result, 1e-4).ok);
    CHECK(solver->solve(second, b, result, 1e-4).ok);  // on the ordering of `first`
  }
  CHECK(x == y);
}

TEST_CASE("linear solver: settings are checked, empty and zero systems are solved") {
  ThreadPool pool(1);
  CHECK_THROWS_AS(LinearSolver({.pcg_tolerance = 0.0}, pool), InvalidSetting);
  CHECK_THROWS_AS(LinearSolver({.pcg_tolerance = std::nan("")}, pool), InvalidSetting);
  CHECK_THROWS_AS(LinearSolver({.pcg_max_iterations = 0}, pool), InvalidSetting);
  for (LinearSolverKind kind : {LinearSolverKind::Cholesky, LinearSolverKind::CholeskyFloat,
                                LinearSolverKind::Pcg, LinearSolverKind::Automatic}) {
    LinearSolver solver({.kind = kind}, pool);
    BlockMatrix empty;
    empty.pattern = BlockPattern::from_pairs(0, {});
    empty.set_zero();
    CHECK(solver.solve(empty, {}, {}, 1e-4).ok);
    const BlockMatrix matrix = test::spd_matrix(BlockPattern::from_pairs(10, {{1, 2}}), 5);
    const std::vector<double> b(30, 0.0);
    std::vector<double> x(30, 1.0);
    CHECK(solver.solve(matrix, b, x, 1e-4).ok);
    CHECK(x == b);
  }
}
