// Cholesky factorisation against dense elimination, residuals, indefinite matrices, and independence of
// threads.
#include <stark/linalg/cholesky.h>

#include <cmath>
#include <numeric>

#include <doctest/doctest.h>

#include "linalg/systems.h"

namespace {

using namespace stark;

struct Case {
  const char* name;
  int32_t block_count;
  test::Pairs pairs;
};

std::vector<Case> small_cases() {
  std::vector<Case> cases;
  cases.push_back({"single block", 1, {}});
  cases.push_back({"two blocks", 2, {{0, 1}}});
  cases.push_back({"diagonal", 20, {}});
  cases.push_back({"cloth", 81, test::cloth_pairs(9)});
  int32_t count = 0;
  test::Pairs solid = test::solid_pairs(3, count);
  cases.push_back({"solid", count, solid});
  cases.push_back({"sparse random", 60, test::random_pairs(60, 70, 3)});
  cases.push_back({"dense random", 50, test::random_pairs(50, 600, 4)});
  test::Pairs full, star, chain, arrow;
  for (int i = 0; i < 40; ++i)
    for (int j = 0; j < i; ++j) full.emplace_back(i, j);
  for (int i = 1; i < 90; ++i) star.emplace_back(0, i);
  for (int i = 1; i < 90; ++i) chain.emplace_back(i - 1, i);
  cases.push_back({"full", 40, full});
  cases.push_back({"star", 90, star});
  cases.push_back({"chain", 90, chain});
  // Three components of different kinds, interleaved numbers.
  test::Pairs disconnected;
  for (const auto& [i, j] : test::cloth_pairs(5)) disconnected.emplace_back(3 * i, 3 * j);
  for (int i = 1; i < 25; ++i) disconnected.emplace_back(3 * (i - 1) + 1, 3 * i + 1);
  cases.push_back({"disconnected", 80, disconnected});
  return cases;
}

double max_difference(const std::vector<double>& a, const std::vector<double>& b) {
  double largest = 0.0;
  for (size_t k = 0; k < a.size(); ++k) largest = std::max(largest, std::fabs(a[k] - b[k]));
  return largest;
}

double max_abs(const std::vector<double>& a) { return max_difference(a, std::vector<double>(a.size(), 0.0)); }

}  // namespace

TEST_CASE("cholesky: small systems against dense elimination in long double") {
  ThreadPool pool(2);
  for (const Case& c : small_cases()) {
    CAPTURE(c.name);
    for (double contrast : {10.0, 1e6}) {
      const BlockMatrix matrix =
          test::spd_matrix(BlockPattern::from_pairs(c.block_count, c.pairs), 7, contrast);
      const std::vector<double> b = test::random_vector(3 * c.block_count, 8),
                                expected = test::dense_solve(matrix, b);
      std::vector<double> x(b.size());
      Cholesky<double> cholesky;
      cholesky.analyze(matrix.pattern);
      const FactorStatus status = cholesky.factor(matrix, pool);
      REQUIRE(status.positive_definite);
      REQUIRE(status.failed_block == -1);
      cholesky.solve(b.data(), x.data());
      // Forward error: condition number (about contrast x connectivity) times 1e-16, with a margin of 100.
      CHECK(max_difference(x, expected) <= 1e-13 * contrast * max_abs(expected));
      x = b;
      cholesky.solve(x.data(), x.data());
      CHECK(max_difference(x, expected) <= 1e-13 * contrast * max_abs(expected));
      Cholesky<float> single;
      single.analyze(matrix.pattern);
      REQUIRE(single.factor(matrix, pool).positive_definite);
      single.solve(b.data(), x.data());
      if (contrast < 100.0) CHECK(max_difference(x, expected) <= 2e-4 * max_abs(expected));
    }
  }
}

TEST_CASE("cholesky: residual on meshes, and the same bits on 1, 2 and 5 threads") {
  int32_t solid_count = 0;
  const test::Pairs solid = test::solid_pairs(8, solid_count);
  std::vector<Case> cases;
  cases.push_back({"cloth", 60 * 60, test::cloth_pairs(60)});
  cases.push_back({"solid", solid_count, solid});
  cases.push_back({"random", 1500, test::random_pairs(1500, 2500, 11)});
  for (const Case& c : cases) {
    CAPTURE(c.name);
    const BlockMatrix matrix = test::spd_matrix(BlockPattern::from_pairs(c.block_count, c.pairs), 12);
    const std::vector<double> b = test::random_vector(3 * c.block_count, 13);
    std::vector<double> reference, reference_single;
    for (int threads : {1, 2, 5}) {
      ThreadPool pool(threads);
      Cholesky<double> cholesky;
      cholesky.analyze(matrix.pattern);
      REQUIRE(cholesky.factor(matrix, pool).positive_definite);
      std::vector<double> x(b.size());
      cholesky.solve(b.data(), x.data());
      CHECK(test::relative_residual(matrix, b, x) < 1e-12);
      std::vector<double> shared(b.size());
      cholesky.solve(b.data(), shared.data(), pool);
      CHECK(shared == x);
      Cholesky<float> single;
      single.analyze(matrix.pattern);
      REQUIRE(single.factor(matrix, pool).positive_definite);
      std::vector<double> y(b.size());
      single.solve(b.data(), y.data());
      CHECK(test::relative_residual(matrix, b, y) < 1e-2);
      if (threads == 1) reference = x, reference_single = y;
      CHECK(x == reference);
      CHECK(y == reference_single);
    }
  }
}

TEST_CASE("cholesky: a matrix that is not positive definite is reported with a block") {
  for (int threads : {1, 3}) {
    ThreadPool pool(threads);
    const BlockPattern pattern = BlockPattern::from_pairs(900, test::cloth_pairs(30));
    BlockMatrix matrix = test::spd_matrix(pattern, 21);
    Cholesky<double> cholesky;
    Cholesky<float> single;
    cholesky.analyze(pattern);
    single.analyze(pattern);
    for (int32_t bad : {0, 17, 450, 899}) {
      CAPTURE(bad);
      BlockMatrix broken = matrix;
      // The pivot of this entry cannot exceed the entry itself, so this block must fail, and as no other
      // block is touched, nothing before it can.
      broken.values[9 * pattern.row_start[bad] + 4] = -1.0;
      const FactorStatus status = cholesky.factor(broken, pool);
      CHECK_FALSE(status.positive_definite);
      CHECK(status.failed_block == bad);
      const FactorStatus status_single = single.factor(broken, pool);
      CHECK_FALSE(status_single.positive_definite);
      CHECK(status_single.failed_block == bad);
    }
    BlockMatrix nan = matrix;
    nan.values[9 * pattern.row_start[100]] = std::nan("");
    CHECK_FALSE(cholesky.factor(nan, pool).positive_definite);
    // Recovers after a failure.
    REQUIRE(cholesky.factor(matrix, pool).positive_definite);
    const std::vector<double> b = test::random_vector(2700, 22);
    std::vector<double> x(b.size());
    cholesky.solve(b.data(), x.data());
    CHECK(test::relative_residual(matrix, b, x) < 1e-12);
  }
}

TEST_CASE("cholesky: indefinite with a positive diagonal") {
  ThreadPool pool(1);
  BlockMatrix matrix;
  matrix.pattern = BlockPattern::from_pairs(2, {{0, 1}});
  matrix.set_zero();
  for (int c = 0; c < 3; ++c) matrix.values[4 * c] = matrix.values[18 + 4 * c] = 1.0;
  for (double coupling : {0.999, 1.001}) {
    matrix.values[9 + 4] = coupling;  // eigenvalues 1 -+ coupling
    Cholesky<double> cholesky;
    cholesky.analyze(matrix.pattern);
    CHECK(cholesky.factor(matrix, pool).positive_definite == (coupling < 1.0));
  }
}

TEST_CASE("cholesky: the ordering is kept while couplings change little and redone when they change much") {
  ThreadPool pool(1);
  const int n = 40;
  Cholesky<double> cholesky;
  const BlockPattern base = BlockPattern::from_pairs(n * n, test::cloth_pairs(n));
  cholesky.analyze(base);
  CHECK(cholesky.ordering_count() == 1);
  const double base_flops = cholesky.flops();
  std::vector<int64_t> slots;
  const test::Pairs few = {{0, 5}, {100, 105}, {801, 803}};
  const BlockPattern slightly = base.merged_with(few, slots);
  cholesky.analyze(slightly);
  CHECK(cholesky.ordering_count() == 1);
  CHECK(cholesky.analysis_count() == 2);
  CHECK(cholesky.flops() >= 0.9 * base_flops);
  const auto check_solves = [&](const BlockPattern& pattern) {
    const BlockMatrix matrix = test::spd_matrix(pattern, 31);
    const std::vector<double> b = test::random_vector(3 * n * n, 32);
    std::vector<double> x(b.size());
    REQUIRE(cholesky.factor(matrix, pool).positive_definite);
    cholesky.solve(b.data(), x.data());
    CHECK(test::relative_residual(matrix, b, x) < 1e-12);
  };
  check_solves(slightly);
  // Fold the cloth: each node meets its mirror image, which couples the two halves everywhere.
  test::Pairs fold;
  for (int32_t i = 0; i < n * n / 2; ++i) fold.emplace_back(i, n * n - 1 - i);
  const BlockPattern folded = base.merged_with(fold, slots);
  cholesky.analyze(folded);
  CHECK(cholesky.ordering_count() == 2);
  check_solves(folded);
  // Unfolded again: the ordering for the folded cloth serves for a while, then is replaced by a better one.
  cholesky.analyze(base);
  check_solves(base);
  CHECK(cholesky.ordering_count() == 2);
  CHECK(cholesky.flops() > 1.1 * base_flops);
  for (int k = 0; k < 25; ++k) cholesky.analyze(base);
  CHECK(cholesky.ordering_count() == 3);
  CHECK(cholesky.flops() < 1.01 * base_flops);
  check_solves(base);
  cholesky.analyze(BlockPattern::from_pairs(25, test::cloth_pairs(5)));
  CHECK(cholesky.ordering_count() == 4);
}

TEST_CASE("cholesky: counts of a full matrix") {
  const int32_t n = 8;
  test::Pairs pairs;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < i; ++j) pairs.emplace_back(i, j);
  Cholesky<double> cholesky;
  cholesky.analyze(BlockPattern::from_pairs(n, pairs));
  CHECK(cholesky.factor_nonzeros() == 24 * 25 / 2);
  double flops = 0.0;  // column k: one root, k divisions, k (k + 1) for the update
  for (int k = 0; k < 24; ++k) flops += (k + 1.0) * (k + 1.0);
  CHECK(cholesky.flops() == doctest::Approx(flops).epsilon(1e-12));
}
