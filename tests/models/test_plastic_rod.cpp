// Rods that yield: each strain alone against the closed form of linear hardening.
#include <doctest/doctest.h>

#include <cmath>

#include <stark/sim/scene/registry.h>
#include <support/rod_bench.h>

using namespace stark;
using namespace stark::test;

namespace {

constexpr double kHardening = 0.02;  // [m/J]

RodProbe probe() {
  return {models::plastic_rod(),
          {{"axial_stiffness", {100.0}},
           {"bending_stiffness_1", {2.0}},
           {"bending_stiffness_2", {3.0}},
           {"torsional_stiffness", {5.0}},
           {"shear_stiffness", {40.0}},
           {"yield_force", {3.0}},
           {"yield_moment_1", {1.5}},
           {"yield_moment_2", {1.0}},
           {"yield_torque", {2.0}},
           {"yield_hardening", {kHardening}}}};
}

/// Energy per length of one strain that yields: elastic, plastic and of hardening.
double exact(double stiffness, double yield, double strain) {
  const double excess = stiffness * std::fabs(strain) - yield, H = kHardening * yield * yield;
  const double slip = std::fmax(excess, 0.0) / (stiffness + H), rest = std::fabs(strain) - slip;
  return 0.5 * stiffness * rest * rest + yield * slip + 0.5 * H * slip * slip;
}

}  // namespace

TEST_CASE("a stretched segment yields at the yield force") {
  for (const double s : {0.9, 0.98, 1.02, 1.3})
    CHECK(probe().energy(strained_segment({}, {0, 0, s})) ==
          doctest::Approx(exact(100.0, 3.0, s - 1.0) * kSegmentLength).epsilon(1e-12));
}

TEST_CASE("bending and twist yield at the moment about their axis") {
  const std::array<double, 3> stiffness{2.0, 3.0, 5.0}, yield{1.5, 1.0, 2.0};
  for (int axis = 0; axis < 3; ++axis)
    for (const double angle : {-0.9, 0.02, 0.4}) {
      Vec3 turn;
      turn[axis] = angle;
      const double u = (std::tan(0.5 * angle) + std::sin(0.5 * angle)) / kSegmentLength;
      CHECK(probe().energy(strained_segment(turn)) ==
            doctest::Approx(exact(stiffness[axis], yield[axis], u) * kSegmentLength).epsilon(1e-9));
    }
}
