// Quadrature of cells that are filled in part: moments, weights, what is refused.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include <stark/geometry/cut_rule.h>
#include <support/box_filling.h>
#include <support/random_points.h>

using namespace stark;
using namespace stark::test;

namespace {

constexpr double kEvenly = 0.0005;  // of an empty cell is mixed in
/// What moments of thin fillings that lie between candidates of points are off by: those are up to 0.23
/// apart.
constexpr double kBetween = 2e-4, kOfPoints = 0.01;

std::array<double, 27> moments_of(const std::vector<QuadraturePoint>& rule) {
  std::array<double, 27> sums{};
  for (const auto& [x, weight] : rule)
    for (int k = 0; k < 3; ++k)
      for (int j = 0; j < 3; ++j)
        for (int i = 0; i < 3; ++i)
          sums[i + 3 * j + 9 * k] += weight * std::pow(x.x, i) * std::pow(x.y, j) * std::pow(x.z, k);
  return sums;
}

/// Moments that a rule of volume one has to have.
std::array<double, 27> wanted(const CellFilling& filling) {
  std::array<double, 27> result = CellFilling::of_full_cell();
  const double evenly = kEvenly * std::pow(1.0 - filling.part(), 4);
  for (size_t m = 0; m < 27; ++m)
    result[m] = (filling.moments[m] + evenly * result[m]) / (filling.part() + evenly);
  return result;
}

/// Half of a box in a cell, on one side of the diagonal plane x + y = s, by points.
CellFilling wedge(double s) {
  CellFilling filling;
  filling.moments = {};
  constexpr int n = 24;
  for (int a = 0; a < n; ++a)
    for (int b = 0; b < n; ++b)
      for (int c = 0; c < n; ++c) {
        const double x = (a + 0.5) / n, y = (b + 0.5) / n, z = (c + 0.5) / n;
        if (x + y > s) continue;
        for (int k = 0; k < 3; ++k)
          for (int j = 0; j < 3; ++j)
            for (int i = 0; i < 3; ++i)
              filling.moments[i + 3 * j + 9 * k] +=
                  std::pow(x, i) * std::pow(y, j) * std::pow(z, k) / (n * n * n);
      }
  return filling;
}

}  // namespace

TEST_CASE("rules of boxes and wedges have their moments: all with 27 nodes, up to the second order with 8") {
  RandomPoints random(4);
  std::vector<CellFilling> fillings{wedge(0.3), wedge(0.8), wedge(1.4)};
  for (int trial = 0; trial < 20; ++trial) {
    Vec3 low, high;
    for (int k = 0; k < 3; ++k) {
      low[k] = random.uniform(0.0, 0.4);
      high[k] = low[k] + random.uniform(0.2, 0.6);
    }
    fillings.push_back(box_filling(low, high));
  }
  for (const CellFilling& filling : fillings) {
    const std::array<double, 27> expected = wanted(filling);
    for (const ElementType type : {ElementType::Hex8, ElementType::Hex27}) {
      const auto rule = cut_rule(type, filling);
      REQUIRE(rule.size() == reference_element(type).quadrature.size());
      const std::array<double, 27> found = moments_of(rule);
      for (const auto& [x, weight] : rule) CHECK(weight > 0.0);
      for (int k = 0; k < 3; ++k)
        for (int j = 0; j < 3; ++j)
          for (int i = 0; i < 3; ++i) {
            if (type == ElementType::Hex8 && i + j + k > 2) continue;
            const size_t m = i + 3 * j + 9 * k;
            CHECK(std::fabs(found[m] - expected[m]) < (type == ElementType::Hex8 ? 1e-12 : kBetween));
          }
      CHECK(is_of_a_cell(filling));
    }
  }
}

TEST_CASE("slivers have rules that hold all nodes") {
  for (const Vec3& corner : {Vec3{0.0, 0.0, 0.0}, Vec3{1.0, 0.0, 1.0}, Vec3{0.3, 0.7, 1.0}}) {
    const CellFilling sliver = box_filling(corner, corner, 0.01);
    CHECK(is_of_a_cell(sliver));
    for (const ElementType type : {ElementType::Hex8, ElementType::Hex27}) {
      const std::array<double, 27> found = moments_of(cut_rule(type, sliver)), expected = wanted(sliver);
      const Vec3 error{found[1] - expected[1], found[3] - expected[3], found[9] - expected[9]};
      CHECK(max_abs(error) < kOfPoints);
      const double spread = found[2] - found[1] * found[1];
      CHECK(spread > 0.5 * (expected[2] - expected[1] * expected[1]));
    }
  }
}

TEST_CASE("the rule of eight points has the symmetries of what is filled") {
  const auto rule = cut_rule(ElementType::Hex8, wedge(0.8));  // symmetric in x and y, and about z = 1/2
  const auto has = [&](const Vec3& x) {
    return std::ranges::any_of(rule, [&](const QuadraturePoint& q) { return norm(q.position - x) < 1e-9; });
  };
  for (const auto& [x, weight] : rule) {
    CHECK(has({x.y, x.x, x.z}));
    CHECK(has({x.x, x.y, 1.0 - x.z}));
  }
}

TEST_CASE("moments of no part of a cell are found") {
  CellFilling wrong;
  CHECK(is_of_a_cell(wrong));
  wrong.moments[2] = 0.2;  // a mean square below the square of the mean
  CHECK(!is_of_a_cell(wrong));
  wrong = {};
  wrong.moments[1] = 1.5;
  CHECK(!is_of_a_cell(wrong));
  wrong = {};
  wrong.moments[4] = 0.5;  // x y that its mean squares do not allow
  CHECK(!is_of_a_cell(wrong));
  wrong = {};
  for (double& m : wrong.moments) m *= 2.0;
  CHECK(!is_of_a_cell(wrong));
  wrong.moments[0] = 0.0;
  CHECK(!is_of_a_cell(wrong));
}
