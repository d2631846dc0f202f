// Strain limit of edges: nothing at all below it, a cubic above, smooth to the second derivative at it.
#include <doctest/doctest.h>

#include <stark/base/rotation.h>
#include <support/model_checks.h>

using namespace stark;
using namespace stark::test;

namespace {

const std::vector<Vec3> kEdge{{0.1, 0.2, 0.3}, {0.3, -0.1, 0.9}};
FilledSample edge() {
  return element(kEdge, kEdge, {{"volume", 2e-3}, {"strain_limit", 0.1}, {"strain_limit_stiffness", 1e4}});
}
std::vector<Vec3> stretched(double s) {
  const Mat3 R = exp_rotation({1, -2, 0.5});
  return {{4, 5, 6}, Vec3{4, 5, 6} + R * (kEdge[1] - kEdge[0]) * s};
}

}  // namespace

TEST_CASE("edges below the limit and in compression have no energy, force or stiffness") {
  const Potential potential = compiled(models::edge_strain_limit());
  for (const double s : {0.3, 0.9, 1.0, 1.05, 1.0999})
    CHECK(largest(evaluate(potential, edge(), symbolic::Order::Hessian, stretched(s))) == 0.0);
}

TEST_CASE("the energy of edges above the limit is V k/3 (strain - limit)^3") {
  const Potential potential = compiled(models::edge_strain_limit());
  const double length = norm(kEdge[1] - kEdge[0]);
  for (const double s : {1.11, 1.2, 1.7}) {
    const double excess = s - 1.1;
    CHECK(energy(potential, edge(), stretched(s)) ==
          doctest::Approx(2e-3 * 1e4 / 3.0 * std::pow(excess, 3)).epsilon(1e-9));
    const std::vector<double> g = gradient(potential, edge(), stretched(s));
    const Vec3 f0{g[0], g[1], g[2]}, f1{g[3], g[4], g[5]};
    CHECK(norm(f1) == doctest::Approx(2e-3 * 1e4 * excess * excess / length).epsilon(1e-9));
    CHECK(norm(f0 + f1) < 1e-14 * norm(f1));
    CHECK(dot(f1, stretched(s)[1] - stretched(s)[0]) > 0.0);  // pulls together
  }
}

TEST_CASE("stiffness of edges grows from zero at the limit") {
  const Potential potential = compiled(models::edge_strain_limit());
  const double just_above = largest(hessian(potential, edge(), stretched(1.1 + 1e-6)));
  const double far = largest(hessian(potential, edge(), stretched(1.3)));
  CHECK(just_above > 0.0);
  CHECK(just_above < 1e-4 * far);
}
