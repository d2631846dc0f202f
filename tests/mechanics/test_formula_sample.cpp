// A formula on elements that are given as arrays: the same numbers as by hand.
#include <doctest/doctest.h>

#include <stark/base/error.h>
#include <stark/mechanics/formula_sample.h>

using namespace stark;
using symbolic::Backend;
using symbolic::Order;

namespace {

/// Half k |x - X|^2 of one point.
Formula spring() {
  return formula_of(define_potential("spring", 1, "", [](PotentialBuilder& b) {
    return 0.5 * b.parameter("k", "N/m", "") * symbolic::squared_norm(b.x(0) - b.X(0));
  }));
}

FormulaSample sample(const std::vector<double>& stiffness) {
  const std::vector<Vec3> rest(2);
  return {spring(), Backend::Automatic,
          SamplePoints{.x = {{1, 0, 0}, {0, 2, 0}}, .X = rest, .x_prev = rest, .x_initial = rest},
          [&](const ParameterDeclaration& field) {
            CHECK(field.name == "k");
            return stiffness;
          }};
}

}  // namespace

TEST_CASE("elements have values and positions of their own") {
  FormulaSample springs = sample({2.0, 3.0});
  CHECK(springs.point_count() == 2);
  CHECK(springs.evaluate(Order::Energy) == std::vector<double>{1.0, 6.0});
  springs.set_positions({{0, 0, 0}, {0, 0, 4}});
  CHECK(springs.evaluate(Order::Energy) == std::vector<double>{0.0, 24.0});
  springs.run(Order::Hessian);
}

TEST_CASE("values are as many as elements need") {
  CHECK_THROWS_WITH_AS(sample({2.0}), "k: got 1 numbers: must be 2", InvalidArgument);
}

TEST_CASE("points are as many as before") {
  FormulaSample springs = sample({2.0, 3.0});
  CHECK_THROWS_WITH_AS(springs.set_positions({Vec3{}}), "x: got 1 points: must be 2", InvalidArgument);
}
