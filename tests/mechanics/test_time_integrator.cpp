// Coefficients of the time integrators: exact on the polynomials that their order promises.
#include <doctest/doctest.h>

#include <stark/mechanics/time_integrator.h>

using namespace stark;

namespace {

/// Velocity that a stencil gives at the end of a step of motion x(t) from t to t + h, h_before before it.
template <typename Motion>
double velocity(const TimeStencil& stencil, const Motion& x, double v, double t, double h, double h_before) {
  const double lag = v - (x(t) - x(t - h_before)) / h_before;
  return (x(t + h) - stencil.place(x(t), v, lag)) / stencil.duration;
}

}  // namespace

TEST_CASE("implicit Euler differentiates lines exactly and forgets the step before") {
  const auto line = [](double t) { return 3.0 - 2.0 * t; };
  CHECK(velocity(implicit_euler(0.1), line, -2.0, 0.4, 0.1, 0.2) == doctest::Approx(-2.0).epsilon(1e-14));
  CHECK(implicit_euler(0.1).place(1.25, 77.0, 3.0) == 1.25);
  CHECK(implicit_euler(0.1).velocity(1.25, 77.0, 5.0) == 1.25);
}

TEST_CASE("BDF2 differentiates parabolas exactly, for every ratio of steps") {
  const auto parabola = [](double t) { return 1.0 - 2.0 * t + 5.0 * t * t; };
  for (const double h : {0.025, 0.1, 0.2}) {
    const double end = 0.4 + h;
    for (const TimeStencil& stencil : {bdf2(h, 0.1), bdf2_unresolved(h, 0.1), bdf2_impact(h, 0.1)})
      CHECK(velocity(stencil, parabola, 2.0, 0.4, h, 0.1) ==
            doctest::Approx(-2.0 + 10.0 * end).epsilon(1e-13));
  }
  const auto cubic = [](double t) { return t * t * t; };
  CHECK(velocity(bdf2(0.1, 0.1), cubic, 0.48, 0.4, 0.1, 0.1) != doctest::Approx(0.75).epsilon(1e-3));
}

TEST_CASE("BDF2 with equal steps has the textbook coefficients") {
  const TimeStencil stencil = bdf2(0.3, 0.3);
  CHECK(stencil.scale == doctest::Approx(0.2).epsilon(1e-15));
  CHECK(stencil.history == doctest::Approx(1.0 / 3.0).epsilon(1e-15));
}

TEST_CASE("weight and contact balance at rest, whatever the share of contact that lasts") {
  for (const double h : {0.05, 0.1, 0.2})
    for (const double lasting : {0.0, 0.3, 1.0})
      for (const TimeStencil& stencil : {bdf2_unresolved(h, 0.1, lasting), bdf2_impact(h, 0.1, lasting)}) {
        // The step before has made the increments A = -1 by weight and p = 1 by contact in 0.1 s.
        const double weight = -10.0 * stencil.scale, contact = 10.0 * stencil.scale * stencil.contact_weight;
        CHECK(stencil.velocity(0.0, -1.0, 1.0) + weight + contact == doctest::Approx(0.0).epsilon(1e-14));
        CHECK(stencil.by_contact(1.0, contact) == doctest::Approx(10.0 * h).epsilon(1e-14));
      }
}

TEST_CASE("contact that lasts is smooth, an impact is not") {
  const TimeStencil stencil = bdf2_unresolved(0.1, 0.1);
  CHECK(smooth_part(bdf2(0.1, 0.1), -0.05, 0.25) == 1.0);
  // At rest: contact gives back what weight takes; all of it counts, and the lag dies out.
  CHECK(smooth_part(stencil, -0.25, 0.25) == 1.0);
  CHECK(next_lag(stencil, 0.0, -0.5, 0.5, 1.0) == 0.0);
  // An impact ten times as large as the increment by weight: a tenth.
  CHECK(smooth_part(stencil, -0.05 * 0.5, 0.5 * 0.5) == doctest::Approx(0.1));
  CHECK(smooth_part(stencil, 0.1, 0.25) == 0.0);
  CHECK(smooth_part(stencil, 0.0, 0.0) == 0.0);
  // Constant acceleration: half of the increment.
  CHECK(next_lag(stencil, 0.5, 1.0, 0.0, 0.0) == doctest::Approx(0.5));
  CHECK(next_lag(implicit_euler(0.1), 7.0, 1.0, 0.0, 0.0) == 0.5);
}
