// Hinges that yield: energy of a fold below and above the yield moment, about a rest angle.
#include <doctest/doctest.h>

#include <stark/sim/scene/registry.h>
#include <support/hinge.h>

using namespace stark;
using namespace stark::test;

TEST_CASE("a fold stores and dissipates as a spring with a slider of linear hardening") {
  const Potential potential = compiled(models::plastic_bending());
  const double k = 0.02, yield = 0.01, hardening = 0.005;
  for (const double rest : {-1.0, 0.0, 0.5})
    for (const double theta : {-2.5, -0.3, 1e-3, 0.2, 0.5, 3.0}) {
      const FilledSample sample = hinge_element(rest, theta,
                                                {{"bending_stiffness", k},
                                                 {"bending_yield_moment", yield},
                                                 {"bending_hardening", hardening},
                                                 {"rest_angle", rest}});
      // Moment k w theta with w of hinge_factor(), yield moment times the length of the edge; the hardening
      // enters as the stiffness does.
      const double w = hinge_factor(), moment = yield * norm(sample.X[1] - sample.X[0]);
      const double fold = std::fabs(theta - rest);
      const double slip = std::fmax(k * w * fold - moment, 0.0) / ((k + hardening) * w);
      const double exact =
          0.5 * k * w * (fold - slip) * (fold - slip) + moment * slip + 0.5 * hardening * w * slip * slip;
      CHECK(energy(potential, sample, folded(theta)) == doctest::Approx(exact).epsilon(1e-9).scale(1e-6));
    }
}
