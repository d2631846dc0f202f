// Values of the barrier energies against the formula written out, and their limits.
#include <doctest/doctest.h>

#include <support/contact_potentials.h>
#include <support/potential_sample.h>
#include <support/random_points.h>

using namespace stark;
using namespace stark::test;

namespace {

const Potential& barrier_of(StencilKind kind) {
  return *contact_potentials().barriers[static_cast<int>(kind)];
}

FilledSample sample_at(std::vector<Vec3> x, double d_hat, double kappa, double threshold = 1.0,
                       double least = 0.0) {
  return {x,
          x,
          x,
          {{"contact_distance", {d_hat}},
           {"least_distance", {least}},
           {"stiffness", {kappa}},
           {"parallel_threshold", {threshold}}}};
}

}  // namespace

TEST_CASE("every stencil has the energy kappa b(d) of its distance") {
  RandomPoints random(1);
  for (int trial = 0; trial < 50; ++trial) {
    const double d = random.uniform(0.001, 0.0099), d_hat = 0.01, kappa = 300.0,
                 expected = kappa * barrier(d, d_hat);
    const auto flat = [&](double z) { return Vec3{random.uniform(), random.uniform(), z}; };
    const auto check = [&](StencilKind kind, const std::vector<Vec3>& x) {
      const FilledSample sample = sample_at(x, d_hat, kappa);
      CHECK(energy(barrier_of(kind), sample, x) == doctest::Approx(expected).epsilon(1e-9));
    };
    const Vec3 p = random.point();
    check(StencilKind::PointPoint, {p, p + d * normalized(random.point())});
    check(StencilKind::PointEdge, {{0.3, 0, d}, {-1, 0, 0}, {1, 0, 0}});
    check(StencilKind::PointTriangle, {{0, 0, d}, flat(0), flat(0), flat(0)});
    check(StencilKind::PointTriangle, {{0, 0, -d}, flat(0), flat(0), flat(0)});  // from below as well
    check(StencilKind::EdgeEdge, {{-1, 0.1, 0}, {1, 0.2, 0}, {0.1, -1, d}, {0.3, 1, d}});
  }
}

TEST_CASE("mollified stencils multiply by (2 - c/eps) c/eps of the squared cross product c") {
  const double d = 0.004, d_hat = 0.01, kappa = 300.0, eps = 0.05;
  for (const double angle : {0.0, 0.05, 0.15, 0.2}) {
    // Edges of unit length at an angle, the second one d above.
    const Vec3 b{std::cos(angle), std::sin(angle), 0};
    const double c = std::pow(std::sin(angle), 2), m = (2.0 - c / eps) * c / eps;
    CAPTURE(angle);
    const std::vector<Vec3> crossing{
        {-0.5, 0, 0}, {0.5, 0, 0}, b * -0.5 + Vec3{0, 0, d}, b * 0.5 + Vec3{0, 0, d}};
    if (angle > 0.0)
      CHECK(energy(barrier_of(StencilKind::MollifiedEdgeEdge), sample_at(crossing, d_hat, kappa, eps),
                   crossing) == doctest::Approx(m * kappa * barrier(d, d_hat)).epsilon(1e-9));
    const std::vector<Vec3> ends{
        {0, 0, 0}, {-1, 0, 0}, {0, 0, d}, b + Vec3{0, 0, d}};  // point 0 against point 2
    CHECK(energy(barrier_of(StencilKind::MollifiedPointPoint), sample_at(ends, d_hat, kappa, eps), ends) ==
          doctest::Approx(m * kappa * barrier(d, d_hat)).epsilon(1e-9));
    // Point 0 above the inside of edge (2, 3).
    const std::vector<Vec3> inside{{0, 0, d}, b + Vec3{0, 0, d}, {-0.5, 0, 0}, {0.5, 0, 0}};
    CHECK(energy(barrier_of(StencilKind::MollifiedPointEdge), sample_at(inside, d_hat, kappa, eps), inside) ==
          doctest::Approx(m * kappa * barrier(d, d_hat)).epsilon(1e-9));
  }
}

TEST_CASE("force and stiffness vanish towards the contact distance and grow without bound towards touching") {
  const double d_hat = 0.01;
  const auto slope_at = [&](double d) {
    const std::vector<Vec3> x{{0, 0, d}, {0, 0, 0}};
    return gradient(barrier_of(StencilKind::PointPoint), sample_at(x, d_hat, 1.0), x)[2];
  };
  for (const double d : {1e-9, 1e-6, 1e-3, 5e-3, 9e-3})
    CHECK(slope_at(d) == doctest::Approx(barrier_slope(d, d_hat)).epsilon(1e-9));
  CHECK(std::fabs(slope_at(d_hat * (1 - 1e-6))) <
        1e-10 * d_hat);  // quadratic in the overlap: 3 (1e-6)^2 d_hat
  CHECK(slope_at(1e-9) < -1e4 * d_hat);
  CHECK(slope_at(1e-4) < slope_at(2e-4));
}

TEST_CASE("within twice the least distance a second barrier adds up, without bound towards that") {
  const double d_hat = 0.01, least = 1e-5, kappa = 300.0;
  const auto at = [&](double d, double xi) {
    const std::vector<Vec3> x{{0, 0, d}, {0, 0, 0}};
    const FilledSample sample = sample_at(x, d_hat, kappa, 1.0, xi);
    const Potential& potential = barrier_of(StencilKind::PointPoint);
    return std::pair(energy(potential, sample, x), gradient(potential, sample, x)[2]);
  };
  for (const double d : {2.01e-5, 1e-4, 9e-3}) CHECK(at(d, least) == at(d, 0.0));
  for (const double d : {1.001e-5, 1.1e-5, 1.5e-5, 1.99e-5}) {
    CAPTURE(d);
    const double u = (d - least) / least, wall = -(u - 1.0) * (u - 1.0) * std::log(u);
    CHECK(at(d, least).first ==
          doctest::Approx(kappa * (barrier(d, d_hat) + d_hat * d_hat * wall)).epsilon(1e-9));
    CHECK(at(d, least).second < at(d, 0.0).second);
  }
  CHECK(at(least * (1.0 + 1e-9), least).second < -1e10 * kappa * d_hat);
  CHECK(std::isnan(at(0.5 * least, least).first));  // no step ends there
}
