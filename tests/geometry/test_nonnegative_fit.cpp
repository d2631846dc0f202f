// Least squares with coefficients that are not negative: optimality of random ones, exact ones, edges.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include <stark/geometry/nonnegative_fit.h>
#include <support/random_points.h>

using namespace stark;
using namespace stark::test;

namespace {

std::vector<double> slopes_of(const std::vector<double>& columns, const std::vector<double>& b,
                              const std::vector<double>& c) {
  std::vector<double> error = b, slopes;
  for (size_t k = 0; k < c.size(); ++k)
    for (size_t i = 0; i < b.size(); ++i) error[i] -= c[k] * columns[k * b.size() + i];
  for (size_t k = 0; k < c.size(); ++k) {
    slopes.push_back(0.0);
    for (size_t i = 0; i < b.size(); ++i) slopes[k] += columns[k * b.size() + i] * error[i];
  }
  return slopes;
}

}  // namespace

TEST_CASE("fits are optimal: no coefficient may grow, and positive ones may not change") {
  RandomPoints random(11);
  for (int trial = 0; trial < 50; ++trial) {
    const size_t rows = 2 + trial % 7, count = 3 + trial % 17;
    std::vector<double> columns(rows * count), b(rows);
    for (double& x : columns) x = random.uniform(-1.0, 1.0);
    for (double& x : b) x = random.uniform(-1.0, 1.0);
    const std::vector<double> c = nonnegative_fit(columns, b);
    const std::vector<double> slopes = slopes_of(columns, b, c);
    REQUIRE(c.size() == count);
    CHECK(std::ranges::count_if(c, [](double x) { return x > 0.0; }) <= static_cast<long>(rows));
    for (size_t k = 0; k < count; ++k) {
      CHECK(c[k] >= 0.0);
      CHECK(slopes[k] < 1e-9);
      if (c[k] > 0.0) CHECK(std::fabs(slopes[k]) < 1e-9);
    }
  }
}

TEST_CASE("what positive coefficients can sum to is met") {
  RandomPoints random(12);
  const size_t rows = 6, count = 40;
  std::vector<double> columns(rows * count), b(rows, 0.0);
  for (double& x : columns) x = random.uniform(0.0, 1.0);
  for (size_t k = 0; k < count; ++k)
    for (size_t i = 0; i < rows; ++i) b[i] += columns[k * rows + i] / count;
  for (const double slope : slopes_of(columns, b, nonnegative_fit(columns, b)))
    CHECK(std::fabs(slope) < 1e-9);
}

TEST_CASE("fits from a start are as good, whatever the start") {
  RandomPoints random(13);
  for (int trial = 0; trial < 20; ++trial) {
    std::vector<double> columns(5 * 12), b(5), start(12, 0.0);
    for (double& x : columns) x = random.uniform(0.0, 1.0);
    for (double& x : b) x = random.uniform(0.0, 1.0);
    for (int k = 0; k < 4; ++k) start[3 * k] = random.uniform(0.0, 1.0);
    const std::vector<double> c = nonnegative_fit(columns, b, start);
    for (size_t k = 0; k < c.size(); ++k) {
      const double slope = slopes_of(columns, b, c)[k];
      CHECK(slope < 1e-9);
      if (c[k] > 0.0) CHECK(std::fabs(slope) < 1e-9);
    }
  }
}

TEST_CASE("nothing fits what points away, and equal columns are taken once") {
  CHECK(nonnegative_fit(std::vector{1.0, 0.0, 0.0, 1.0}, std::vector{-1.0, -2.0}) == std::vector{0.0, 0.0});
  CHECK(nonnegative_fit(std::vector{1.0, 0.0}, std::vector{0.0, 0.0}) == std::vector{0.0});
  const std::vector<double> c =
      nonnegative_fit(std::vector{1.0, 1.0, 1.0, 1.0, 0.0, 1.0}, std::vector{2.0, 3.0});
  CHECK(c[0] + c[1] == doctest::Approx(2.0));
  CHECK(c[2] == doctest::Approx(1.0));
}
