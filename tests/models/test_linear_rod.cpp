// Kirchhoff's rod with stretch: each strain against its stiffness.
#include <doctest/doctest.h>

#include <cmath>

#include <stark/sim/scene/registry.h>
#include <support/rod_bench.h>

using namespace stark;
using namespace stark::test;

namespace {

RodProbe probe() {
  return {models::linear_rod(),
          {{"axial_stiffness", {100.0}},
           {"bending_stiffness_1", {2.0}},
           {"bending_stiffness_2", {3.0}},
           {"torsional_stiffness", {5.0}},
           {"shear_stiffness", {40.0}}}};
}

}  // namespace

TEST_CASE("a stretched segment stores EA/2 (s - 1)^2 per length") {
  for (const double s : {0.8, 1.3})
    CHECK(probe().energy(strained_segment({}, {0, 0, s})) ==
          doctest::Approx(50.0 * (s - 1) * (s - 1) * kSegmentLength).epsilon(1e-12));
}

TEST_CASE("bending and twist store half the stiffness about their axis times the square of their measure") {
  const std::array<double, 3> stiffness{2.0, 3.0, 5.0};
  for (int axis = 0; axis < 3; ++axis)
    for (const double angle : {-0.9, 0.2}) {
      Vec3 turn;
      turn[axis] = angle;
      const double u = (std::tan(0.5 * angle) + std::sin(0.5 * angle)) / kSegmentLength;
      CHECK(probe().energy(strained_segment(turn)) ==
            doctest::Approx(0.5 * stiffness[axis] * u * u * kSegmentLength).epsilon(1e-9));
    }
}

TEST_CASE("a segment at rest stores nothing") { CHECK(probe().energy(strained_segment({})) < 1e-25); }
