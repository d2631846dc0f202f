// The automatic choice of the linear solver: which one, when, and that it is reproducible.
#include <stark/linalg/automatic_solver.h>

#include <doctest/doctest.h>

#include "linalg/systems.h"

using namespace stark;

TEST_CASE("automatic solver: symbolic work only when the pattern changes") {
  ThreadPool pool(1);
  AutomaticSolver solver({}, pool);
  BlockMatrix matrix = test::spd_matrix(BlockPattern::from_pairs(400, test::cloth_pairs(20)), 3);
  const std::vector<double> b = test::random_vector(1200, 4);
  std::vector<double> x(b.size());
  for (uint32_t k = 0; k < 3; ++k) {
    matrix = test::spd_matrix(matrix.pattern, k);
    CHECK(solver.solve({.A = matrix, .b = b, .tolerance = 1e-4}, x).ok);
    CHECK(test::relative_residual(matrix, b, x) < 1e-10);
  }
  CHECK(solver.cholesky().analysis_count() == 1);
  std::vector<int64_t> slots;
  const test::Pairs contact = {{3, 7}};
  matrix = test::spd_matrix(matrix.pattern.merged_with(contact, slots), 9);
  CHECK(solver.solve({.A = matrix, .b = b, .tolerance = 1e-4}, x).ok);
  CHECK(test::relative_residual(matrix, b, x) < 1e-10);
  CHECK(solver.cholesky().analysis_count() == 2);
  CHECK(solver.cholesky().ordering_count() == 1);
}

TEST_CASE(
    "automatic solver: steps on an easy solid start with conjugate gradients and fall back when it turns "
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
  AutomaticSolver solver({.pcg_max_iterations = 40}, pool);
  // A sheet with the same pattern is factorised.
  solver.prepare(matrix.pattern, {});
  solver.begin_step();
  CHECK(solver.solve({.A = matrix, .b = b, .tolerance = 1e-4}, x).used == "cholesky_float");
  solver.prepare(matrix.pattern, std::vector<uint8_t>(count, 1));
  solver.begin_step();
  LinearSolveReport report = solver.solve({.A = matrix, .b = b, .tolerance = 1e-4}, x);
  CHECK(report.ok);
  CHECK(report.used == "pcg");
  CHECK(report.iterations < 40);
  // The material turns stiff: the cap is hit, the same call falls back to the factorisation, and so does the
  // rest of the step.
  const BlockMatrix stiff = test::spd_matrix(matrix.pattern, 3, 1e10);
  report = solver.solve({.A = stiff, .b = b, .tolerance = 1e-4}, x);
  CHECK(report.ok);
  CHECK(report.used == "cholesky");
  CHECK(report.iterations > 0);
  CHECK(solver.solve({.A = matrix, .b = b, .tolerance = 1e-4}, x).used == "cholesky");
  solver.begin_step();
  CHECK(solver.solve({.A = matrix, .b = b, .tolerance = 1e-4}, x).used == "pcg");
}

TEST_CASE("automatic solver: the bits of a step depend on the systems of that step only") {
  ThreadPool pool(1);
  int32_t count = 0;
  const test::Pairs pairs = test::solid_pairs(6, count);
  test::Pairs more = pairs;
  for (int32_t i = 0; i + 40 < count; i += 3) more.emplace_back(i, i + 40);
  const BlockMatrix first = test::spd_matrix(BlockPattern::from_pairs(count, more), 3);
  const BlockMatrix second = test::spd_matrix(BlockPattern::from_pairs(count, pairs), 5);
  const std::vector<double> b = test::random_vector(3 * count, 4);
  std::vector<double> x(b.size()), y(b.size());
  AutomaticSolver with_history({}, pool), fresh({}, pool);
  with_history.prepare(second.pattern, {});
  fresh.prepare(second.pattern, {});
  with_history.begin_step();
  CHECK(with_history.solve({.A = first, .b = b, .tolerance = 1e-4}, x).ok);
  CHECK(with_history.solve({.A = second, .b = b, .tolerance = 1e-4}, x).ok);  // on the ordering of `first`
  for (auto* solver : {&with_history, &fresh}) {
    solver->begin_step();
    CHECK(solver->solve({.A = second, .b = b, .tolerance = 1e-4}, solver == &fresh ? y : x).ok);
  }
  CHECK(x == y);
}
