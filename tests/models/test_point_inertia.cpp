// Lumped inertia with mass damping: the forces of implicit Euler; none in quasistatics.
#include <doctest/doctest.h>

#include <support/model_checks.h>

using namespace stark;
using namespace stark::test;

TEST_CASE("inertia pulls to the prediction with m/h^2, damping to the start with m a/h") {
  const Potential potential = compiled(models::point_inertia());
  const Vec3 x_prev{0.1, 0.2, 0.3}, predicted{0.4, -0.2, 0.5}, x{1, 2, 3};
  const double m = 2.5, a = 0.7, h = 0.01;
  FilledSample sample =
      element({x_prev}, {x_prev},
              {{"mass", m}, {"damping", a}, {"inverse_scale_squared", 1.0 / (h * h)}, {"time_step", h}});
  sample.values["predicted"] = {predicted.x, predicted.y, predicted.z};
  const Vec3 expected = (x - predicted) * (m / (h * h)) + (x - x_prev) * (m * a / h);
  const std::vector<double> g = gradient(potential, sample, {x});
  for (int c = 0; c < 3; ++c) CHECK(g[c] == doctest::Approx(expected[c]).epsilon(1e-13));
  CHECK(energy(potential, sample, {x}) ==
        doctest::Approx(0.5 * m * (squared_norm(x - predicted) / (h * h) + a / h * squared_norm(x - x_prev)))
            .epsilon(1e-13));
  const std::vector<double> H = hessian(potential, sample, {x});
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      CHECK(H[3 * i + j] == doctest::Approx(i == j ? m / (h * h) + m * a / h : 0.0).epsilon(1e-13));

  sample.values["inverse_scale_squared"] = {0.0};
  sample.values["time_step"] = {1e150};
  CHECK(largest(gradient(potential, sample, {x})) < 1e-140);
}
