// Values of the friction energy: Coulomb's work beyond sticking, smooth through the end of sticking and at
// rest.
#include <doctest/doctest.h>

#include <support/contact_potentials.h>
#include <support/potential_sample.h>

using namespace stark;
using namespace stark::test;

namespace {

constexpr double kEps = 2e-5;  ///< stick displacement [m]

FilledSample slip_sample() {
  const std::vector<Vec3> x{{0, 0, 0.1}, {0, 0, 0}};
  return {x,
          x,
          x,
          {{"limit", {5.0}},
           {"normal", {0, 0, 1}},
           {"weight0", {1.0}},
           {"weight1", {-1.0}},
           {"deflection", {0, 0, 0}},
           {"slope", {0.0}},
           {"majorant", {0.0}},
           {"stick_displacement", {kEps}}}};
}

double energy_of(double slip) {
  FilledSample sample = slip_sample();
  sample.x[0] += {0.6 * slip, 0.8 * slip, 0.01};
  return energy(*contact_potentials().frictions[0], sample, sample.x);
}

double force_of(double slip) {
  FilledSample sample = slip_sample();
  sample.x[0] += {0.6 * slip, 0.8 * slip, 0.01};
  const std::vector<double> g = gradient(*contact_potentials().frictions[0], sample, sample.x);
  return 0.6 * g[0] + 0.8 * g[1];
}

}  // namespace

TEST_CASE("energy is mu lambda f0 of the slip [Li et al. 2020, eq. 17]") {
  for (const double r : {0.0, 0.1, 0.5, 0.999, 1.001, 3.0, 1e4}) {
    const double y = r * kEps;
    const double f0 = r < 1.0 ? y * y / kEps - y * y * y / (3 * kEps * kEps) + kEps / 3 : y;
    CHECK(energy_of(y) == doctest::Approx(5.0 * f0).epsilon(1e-9));
  }
}

TEST_CASE("force is continuous at the end of sticking and vanishes at rest") {
  CHECK(force_of(kEps * (1 - 1e-6)) == doctest::Approx(force_of(kEps * (1 + 1e-6))).epsilon(1e-9));
  CHECK(force_of(2 * kEps) == doctest::Approx(5.0).epsilon(1e-12));
  CHECK(force_of(0.0) == 0.0);
  CHECK(force_of(1e-12 * kEps) < 1e-10);
  CHECK(force_of(1e-3 * kEps) == doctest::Approx(5.0 * (2e-3 - 1e-6)).epsilon(1e-9));
  double last = -1.0;
  for (double r = 0.0; r < 1.0; r += 0.01) {  // monotone
    CHECK(force_of(r * kEps) > last);
    last = force_of(r * kEps);
  }
}
