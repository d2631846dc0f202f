// Yielding of several strains: the closed form against a search for the least energy, its bounds and its
// limits.
#include <doctest/doctest.h>

#include <cmath>
#include <limits>

#include <stark/models/yielding.h>
#include <support/model_checks.h>

using namespace stark;
using namespace stark::test;

namespace {

constexpr double kStiffness[3] = {2.0, 3.0, 4.0}, kHardening = 0.4;

/// Three strains, the coordinates of a point, as an energy with memory.
PotentialDefinition probe(double hardening) {
  return define_potential("probe", 1, "three strains that yield", [hardening](PotentialBuilder& b) {
    std::vector<models::YieldingStrain> strains;
    for (int i = 0; i < 3; ++i)
      strains.push_back(
          {square(b.x(0)[i]), kStiffness[i],
           b.parameter("yield" + std::to_string(i), "N", "yield force", positive_or_infinity())});
    const auto p = b.internal("p", {0.5}, "J", "plastic work before");
    const models::Yielding yields = models::yielding(strains, hardening, p[0]);
    b.update("p", {p[0] + yields.work});
    return yields.energy;
  });
}

/// Energy of a step with the slip d: what the closed form is the least of.
double energy_with(const Vec3& e, const Vec3& d, const Vec3& yield, double H) {
  double stored = 0.5 * H * 0.25, squared = 0.0;  // p = 0.5
  for (int i = 0; i < 3; ++i) {
    stored += 0.5 * kStiffness[i] * (e[i] - d[i]) * (e[i] - d[i]);
    squared += yield[i] * d[i] * yield[i] * d[i];
  }
  return stored + (1.0 + 0.5 * H) * std::sqrt(squared) + 0.5 * H * squared;
}

/// Coordinate search with shrinking steps.
double least_energy(const Vec3& e, const Vec3& yield, double H) {
  Vec3 d;
  double best = energy_with(e, d, yield, H);
  for (double step = 0.5; step > 1e-9;) {
    bool better = false;
    for (int k = 0; k < 27; ++k) {
      const Vec3 trial = d + Vec3{k % 3 - 1.0, (k / 3) % 3 - 1.0, k / 9 - 1.0} * step;
      if (const double value = energy_with(e, trial, yield, H); value < best) {
        best = value;
        d = trial;
        better = true;
      }
    }
    if (!better) step *= 0.5;
  }
  return best;
}

FilledSample sample_at(const Vec3& e, const Vec3& yield) {
  return {{{}}, {e}, {e}, {{"yield0", {yield.x}}, {"yield1", {yield.y}}, {"yield2", {yield.z}}}};
}

}  // namespace

TEST_CASE("the energy of a step is the least over all slips") {
  std::mt19937_64 random(5);
  for (const double H : {0.0, kHardening}) {
    const Potential potential = compiled(probe(H));
    for (int k = 0; k < 12; ++k) {
      const Vec3 e = random_vector(random, 2.0);
      const Vec3 yield{uniform(random, 0.7, 1.3), uniform(random, 0.7, 1.3), uniform(random, 0.7, 1.3)};
      const double least = least_energy(e, yield, H);
      CHECK(energy(potential, sample_at(e, yield), {e}) == doctest::Approx(least).epsilon(1e-9));
    }
  }
}

TEST_CASE("forces end on the ellipsoid, to rounding where stiffnesses over squared yield forces are alike") {
  const Potential potential = compiled(probe(0.0));
  std::mt19937_64 random(9);
  const auto off = [&](const Vec3& yield) {  // largest distance from the ellipsoid, as a part of it
    double worst = 0.0;
    for (int k = 0; k < 50; ++k) {
      const Vec3 e = random_vector(random, 5.0) + Vec3{6.0, 6.0, 6.0};
      const std::vector<double> s = gradient(potential, sample_at(e, yield), {e});
      double squared = 0.0;
      for (int i = 0; i < 3; ++i) squared += s[i] * s[i] / (yield[i] * yield[i]);
      worst = std::fmax(worst, std::fabs(std::sqrt(squared) - 1.0));
    }
    return worst;
  };
  CHECK(off({0.5, 0.4, 0.4}) < 1e-12);   // they differ by 3.1
  CHECK(off({0.5, 0.25, 0.22}) < 1e-6);  // tenfold
}

TEST_CASE("below yielding, and without any yield force, the energy is the elastic one") {
  const double infinity = std::numeric_limits<double>::infinity();
  const Potential potential = compiled(probe(0.0));
  const Vec3 e{0.3, -0.2, 0.1};
  const double elastic = 0.5 * (2.0 * 0.09 + 3.0 * 0.04 + 4.0 * 0.01);
  for (const Vec3& yield : {Vec3{9, 9, 9}, Vec3{infinity, infinity, infinity}, Vec3{infinity, 9, infinity}})
    CHECK(energy(potential, sample_at(e, yield), {e}) == doctest::Approx(elastic).epsilon(1e-15));
  for (const double v : hessian(potential, sample_at({}, {1, 1, 1}), {Vec3{}})) CHECK(std::isfinite(v));
}
