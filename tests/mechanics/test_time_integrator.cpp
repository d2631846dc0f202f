// Coefficients of the time integrators: exact on the polynomials that their order promises.
#include <doctest/doctest.h>

#include <stark/mechanics/time_integrator.h>

using namespace stark;

namespace {

/// Velocity that a stencil gives at the end of a step of motion x(t) from t to t + h, h_before before it.
template <typename Motion>
double velocity(const TimeStencil& stencil, const Motion& x, double t, double h, double h_before) {
  return (x(t + h) - stencil.reference(x(t), x(t - h_before))) / stencil.scale;
}

}  // namespace

TEST_CASE("implicit Euler differentiates lines exactly and forgets the step before") {
  const auto line = [](double t) { return 3.0 - 2.0 * t; };
  CHECK(velocity(implicit_euler(0.1), line, 0.4, 0.1, 0.2) == doctest::Approx(-2.0).epsilon(1e-14));
  CHECK(implicit_euler(0.1).reference(1.25, 77.0) == 1.25);
}

TEST_CASE("BDF2 differentiates parabolas exactly, for every ratio of steps") {
  const auto parabola = [](double t) { return 1.0 - 2.0 * t + 5.0 * t * t; };
  for (const double h : {0.025, 0.1, 0.2}) {
    const double end = 0.4 + h;
    CHECK(velocity(bdf2(h, 0.1), parabola, 0.4, h, 0.1) == doctest::Approx(-2.0 + 10.0 * end).epsilon(1e-13));
  }
  const auto cubic = [](double t) { return t * t * t; };
  CHECK(velocity(bdf2(0.1, 0.1), cubic, 0.4, 0.1, 0.1) != doctest::Approx(0.75).epsilon(1e-3));
}

TEST_CASE("BDF2 with equal steps has the textbook coefficients") {
  const TimeStencil stencil = bdf2(0.3, 0.3);
  CHECK(stencil.scale == doctest::Approx(0.2).epsilon(1e-15));
  CHECK(stencil.history == doctest::Approx(1.0 / 3.0).epsilon(1e-15));
}
