// Kelvin-Voigt damping of rods: tau/(2h) K (e - e_prev)^2 of every strain, nothing for rigid motion.
#include <doctest/doctest.h>

#include <cmath>

#include <stark/sim/scene/registry.h>
#include <support/rod_bench.h>

using namespace stark;
using namespace stark::test;

namespace {

constexpr double kTau = 0.05, kStep = 0.01;

RodProbe probe() {
  return {models::rod_damping(),
          {{"axial_stiffness", {100.0}},
           {"bending_stiffness_1", {2.0}},
           {"bending_stiffness_2", {3.0}},
           {"torsional_stiffness", {5.0}},
           {"strain_damping", {kTau}},
           {"time_step", {kStep}},
           {"shear_stiffness", {0.0}}}};
}

double measure(double angle) { return (std::tan(0.5 * angle) + std::sin(0.5 * angle)) / kSegmentLength; }

}  // namespace

TEST_CASE("changes of strain within the step are resisted with the stiffness of their kind") {
  const double factor = 0.5 * kTau / kStep * kSegmentLength;
  CHECK(probe().at(strained_segment({}, {0, 0, 1.2}), strained_segment({}, {0, 0, 1.1})) ==
        doctest::Approx(factor * 100.0 * 0.01).epsilon(1e-12));
  const std::array<double, 3> stiffness{2.0, 3.0, 5.0};
  for (int axis = 0; axis < 3; ++axis) {
    Vec3 now, before;
    now[axis] = 0.5;
    before[axis] = 0.2;
    const double rate = measure(0.5) - measure(0.2);
    CHECK(probe().at(strained_segment(now), strained_segment(before)) ==
          doctest::Approx(factor * stiffness[axis] * rate * rate).epsilon(1e-9));
  }
}

TEST_CASE("a deformed segment that moves rigidly is not damped") {
  const std::vector<Vec3> x = strained_segment({0.4, -0.3, 0.8}, {0.1, 0.05, 1.1});
  const Mat3 Q = exp_rotation({1.0, -2.0, 0.7});
  std::vector<Vec3> moved;
  for (size_t i = 0; i < x.size(); ++i) moved.push_back(Q * x[i] + (i < 2 ? Vec3{3, -1, 2} : Vec3{}));
  CHECK(std::fabs(probe().at(moved, x)) < 1e-20);
}
