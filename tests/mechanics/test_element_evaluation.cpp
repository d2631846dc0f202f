// One element of a potential against its closed form: a spring with a given rest length, pulled by a drag.
#include <doctest/doctest.h>

#include <stark/mechanics/element_evaluation.h>

using namespace stark;
using doctest::Approx;

TEST_CASE("energy, gradient and Hessian of one element are those of its formula") {
  const PotentialDefinition definition = define_potential("spring", 2, "", [](PotentialBuilder& b) {
    const symbolic::Vec3 pull = b.x(1) - b.x(0) - (b.X(1) - b.X(0)), slip = b.x(0) - b.x_prev(0);
    return 0.5 * b.parameter("stiffness", "N/m", "", positive()) * squared_norm(pull) +
           0.5 * b.data("drag", "N/m", "") * squared_norm(slip);
  });
  const Potential potential(definition, symbolic::Backend::Automatic);
  const Vec3 x[] = {{0.1, 0.0, 0.0}, {1.5, 2.0, 0.0}}, X[] = {{}, {1.0, 0.0, 0.0}},
             before[] = {{0.0, 0.0, 0.3}, {}};
  const ElementEvaluation element = evaluate_element(potential, x, X, before, [](const ElementInput& input) {
    CHECK(input.width == 1);
    CHECK(input.unit == "N/m");
    return std::vector<double>{input.name == "stiffness" ? 10.0 : 4.0};
  });
  const Vec3 pull{0.4, 2.0, 0.0}, slip{0.1, 0.0, -0.3};
  CHECK(element.energy == Approx(5.0 * squared_norm(pull) + 2.0 * squared_norm(slip)));
  CHECK(norm(element.gradient[1] - pull * 10.0) < 1e-12);
  CHECK(norm(element.gradient[0] - (slip * 4.0 - pull * 10.0)) < 1e-12);
  REQUIRE(element.hessian.size() == 36);
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j) {
      const double expected = i % 3 != j % 3 ? 0.0 : i != j ? -10.0 : i < 3 ? 14.0 : 10.0;
      CHECK(element.hessian[6 * i + j] == Approx(expected));
    }
}
