// Values of the friction energy: Coulomb's work beyond sticking, smooth through the end of sticking and at
// rest.
#include <doctest/doctest.h>

#include <cmath>

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
           {"pull", {0, 0, 0}},
           {"way", {1, 0, 0}},
           {"pull_at_iterate", {0.0}},
           {"way_at_iterate", {0.0}},
           {"is_model", {0.0}},
           {"stick_displacement", {kEps}}}};
}

double energy_of(double slip) {
  FilledSample sample = slip_sample();
  sample.x[0] += {0.6 * slip, 0.8 * slip, 0.01};
  return energy(*contact_potentials().friction.isotropic[0], sample, sample.x);
}

double force_of(double slip) {
  FilledSample sample = slip_sample();
  sample.x[0] += {0.6 * slip, 0.8 * slip, 0.01};
  const std::vector<double> g = gradient(*contact_potentials().friction.isotropic[0], sample, sample.x);
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

TEST_CASE("anisotropic friction is that of the deflection measured in its ellipse") {
  // Shares 1 along x and 0.4 along y: force (2 - y/eps) y/eps A^T A u/y, with y = |A u|.
  FilledSample sample = slip_sample();
  sample.values["along"] = {1, 0, 0};
  sample.values["across"] = {0, 0.4, 0};
  const Potential& potential = *contact_potentials().friction.anisotropic[0];
  for (const double size : {0.2, 0.9, 3.0, 100.0}) {
    const Vec3 u{0.6 * size * kEps, -0.8 * size * kEps, 0.0};
    FilledSample moved = sample;
    moved.x[0] += u + Vec3{0, 0, 0.02};
    const double y = std::sqrt(u.x * u.x + 0.16 * u.y * u.y) / kEps, f = y < 1.0 ? (2.0 - y) * y : 1.0;
    const Vec3 force = Vec3{u.x, 0.16 * u.y, 0.0} * (5.0 * f / (y * kEps));
    const std::vector<double> g = gradient(potential, moved, moved.x);
    CHECK(norm(Vec3{g[0], g[1], g[2]} - force) < 1e-9 * 5.0);
    // On the ellipse with the half axes 5 N and 2 N once it slides.
    if (size >= 3.0) CHECK(std::hypot(g[0] / 5.0, g[1] / 2.0) == doctest::Approx(1.0).epsilon(1e-12));
  }
}

TEST_CASE("with equal shares anisotropic friction is isotropic") {
  FilledSample sample = slip_sample();
  sample.values["along"] = {0.6, 0.8, 0};
  sample.values["across"] = {-0.8, 0.6, 0};
  for (const double slip : {0.1, 0.7, 5.0}) {
    FilledSample moved = sample;
    moved.x[0] += {0.6 * slip * kEps, 0.8 * slip * kEps, 0.01};
    CHECK(energy(*contact_potentials().friction.anisotropic[0], moved, moved.x) ==
          doctest::Approx(energy_of(slip * kEps)).epsilon(1e-12));
  }
}
