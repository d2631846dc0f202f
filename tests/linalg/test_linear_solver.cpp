// What all linear solvers promise, and their registry.
#include <stark/linalg/linear_solver.h>

#include <algorithm>
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
  for (const std::string name : {"cholesky", "cholesky_float", "pcg", "automatic"}) {
    const auto solver = make_linear_solver({.solver = name, .pcg_tolerance = 1e-10}, pool);
    std::vector<double> x(b.size());
    const LinearSolveReport report = solver->solve({.A = matrix, .b = b, .tolerance = 1e-10}, x);
    CHECK(report.ok);
    CHECK_FALSE(report.indefinite);
    CHECK(report.failed_block == -1);
    CHECK(report.used == (name == "automatic" ? "cholesky" : name));
    CHECK(report.factorizations == (name == "pcg" ? 0 : 1));
    CHECK((report.iterations > 0) == (name == "pcg" || name == "cholesky_float"));
    const double residual = test::relative_residual(matrix, b, x);
    if (name == "cholesky") {
      CHECK(residual < 1e-12);
      exact = x;
    } else if (name == "cholesky_float") {
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
  for (const std::string name : {"cholesky", "cholesky_float", "pcg"}) {
    const auto solver = make_linear_solver({.solver = name, .pcg_tolerance = 1e-10}, pool);
    std::vector<double> x(b.size());
    CHECK_FALSE(solver->solve_again({.A = matrix, .b = b, .tolerance = 1e-8}, x).ok);  // there was none
    REQUIRE(solver->solve({.A = matrix, .b = first, .tolerance = 1e-8}, x).ok);
    const LinearSolveReport report = solver->solve_again({.A = matrix, .b = b, .tolerance = 1e-8}, x);
    CHECK(report.ok);
    CHECK(report.used == name);
    CHECK(report.factorizations == 0);
    CHECK(test::relative_residual(matrix, b, x) < (name == "pcg" ? 1e-6 : 1e-8));
  }
}

TEST_CASE("linear solver: indefinite matrices") {
  ThreadPool pool(1);
  BlockMatrix matrix = test::spd_matrix(BlockPattern::from_pairs(100, test::cloth_pairs(10)), 3, 100.0);
  matrix.values[9 * matrix.pattern.row_start[42]] = -5.0;
  const std::vector<double> b = test::random_vector(300, 4);
  for (const std::string name : {"cholesky", "cholesky_float", "pcg", "automatic"}) {
    const auto solver = make_linear_solver({.solver = name}, pool);
    std::vector<double> x(b.size());
    const LinearSolveReport report = solver->solve({.A = matrix, .b = b, .tolerance = 1e-4}, x);
    CHECK_FALSE(report.ok);
    CHECK(report.indefinite);
    CHECK(report.failed_block == 42);
  }
}

TEST_CASE("linear solver: settings are checked, empty and zero systems are solved") {
  ThreadPool pool(1);
  CHECK_THROWS_AS(make_linear_solver({.pcg_tolerance = 0.0}, pool), InvalidSetting);
  CHECK_THROWS_AS(make_linear_solver({.pcg_tolerance = std::nan("")}, pool), InvalidSetting);
  CHECK_THROWS_AS(make_linear_solver({.pcg_max_iterations = 0}, pool), InvalidSetting);
  CHECK_THROWS_WITH(make_linear_solver({.solver = "choleski"}, pool),
                    doctest::Contains("must be one of 'automatic', 'cholesky', 'cholesky_float', 'pcg'"));
  for (const std::string name : {"cholesky", "cholesky_float", "pcg", "automatic"}) {
    const auto solver = make_linear_solver({.solver = name}, pool);
    BlockMatrix empty;
    empty.pattern = BlockPattern::from_pairs(0, {});
    empty.set_zero();
    CHECK(solver->solve({.A = empty, .b = {}, .tolerance = 1e-4}, {}).ok);
    const BlockMatrix matrix = test::spd_matrix(BlockPattern::from_pairs(10, {{1, 2}}), 5);
    const std::vector<double> b(30, 0.0);
    std::vector<double> x(30, 1.0);
    CHECK(solver->solve({.A = matrix, .b = b, .tolerance = 1e-4}, x).ok);
    CHECK(x == b);
  }
}

namespace {

/// Gauss-Seidel sweeps: a solver that is not of the library.
class GaussSeidel final : public LinearSolver {
 protected:
  LinearSolveReport solve_system(const LinearSystem& system, std::span<double> x) override {
    std::ranges::fill(x, 0.0);
    std::vector<double> product(x.size());
    LinearSolveReport report;
    for (int sweep = 0; sweep < 200; ++sweep)
      for (size_t i = 0; i < x.size(); ++i) {
        system.A.multiply(x.data(), product.data(), pool_);
        x[i] +=
            (system.b[i] - product[i]) / system.A.values[9 * system.A.pattern.row_start[i / 3] + 4 * (i % 3)];
      }
    report.ok = test::relative_residual(system.A, {system.b.begin(), system.b.end()}, {x.begin(), x.end()}) <=
                system.tolerance;
    report.used = "gauss_seidel";
    return report;
  }

 private:
  ThreadPool pool_{1};
};

}  // namespace

TEST_CASE("linear solver: a solver of the user is made by its name") {
  ThreadPool pool(1);
  const BlockMatrix matrix = test::spd_matrix(BlockPattern::from_pairs(4, {{0, 1}, {1, 2}}), 5, 10.0);
  const std::vector<double> b = test::random_vector(12, 4);
  std::vector<double> x(b.size());
  CHECK_THROWS_AS(make_linear_solver({.solver = "gauss_seidel"}, pool), InvalidSetting);
  register_linear_solver("gauss_seidel",
                         [](const LinearSettings&, ThreadPool&) { return std::make_unique<GaussSeidel>(); });
  CHECK(linear_solver_names().back() == "gauss_seidel");
  const auto solver = make_linear_solver({.solver = "gauss_seidel"}, pool);
  CHECK(solver->solve({.A = matrix, .b = b}, x).used == "gauss_seidel");
  CHECK(test::relative_residual(matrix, b, x) < 1e-4);
  CHECK_FALSE(solver->solve_again({.A = matrix, .b = b}, x).ok);  // it keeps nothing
  CHECK_THROWS_AS(register_linear_solver("pcg", nullptr), InvalidArgument);
  CHECK_THROWS_AS(register_linear_solver("pcg", [](const LinearSettings&,
                                                   ThreadPool&) { return std::make_unique<GaussSeidel>(); }),
                  InvalidArgument);
}
