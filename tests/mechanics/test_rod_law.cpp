// Strains of a segment against closed forms, laws made of traced formulas, sums.
#include <doctest/doctest.h>

#include <cmath>

#include <stark/base/error.h>
#include <stark/mechanics/rod_law.h>
#include <support/rod_bench.h>

using namespace stark;
using namespace stark::test;
using symbolic::Backend;
using symbolic::Scalar;

namespace {

/// The law whose psi is the component `which` of the strain: stretch, curvature 1 and 2, twist.
RodLaw component(int which) {
  return define_rod_law("component", "one strain", [which](PotentialBuilder&, const RodDeformation& d) {
    const RodStrain s = d.strain();
    return which == 0 ? s.stretch : which < 3 ? s.curvature[which - 1] : s.twist;
  });
}

double strain(int which, const std::vector<Vec3>& x) {
  return RodProbe(component(which), {{"shear_stiffness", {0.0}}}).energy(x) / kSegmentLength;
}

/// psi = (stretch - 1)^2 + curvature 2 times twist, with or without the past, as Python traces it.
Formula traced(int points, bool with_rate) {
  auto b = std::make_shared<PotentialBuilder>(points);
  const symbolic::Vec3 first = b->x(0), second = b->x(points - 1);
  const Scalar stretch = first[2] - b->X(0)[2];
  Scalar psi = b->parameter("k", "N", "stiffness", positive()) * stretch * stretch + second[1] * second[2];
  if (with_rate) psi += (second[0] - b->x_prev(1)[0]) / b->time_step();
  return Formula(b, {psi});
}

bool remembers(const RodLaw& law) {
  const Potential potential(rod_segment(law), Backend::Interpreter);
  for (const ElementField& field : potential.element_fields())
    if (field.source == ElementField::Source::Previous) return true;
  return false;
}

}  // namespace

TEST_CASE("frames that turn about an axis of the section give curvature or twist about it, to third order") {
  for (const double angle : {1e-3, 0.3, 2.5, -1.0})
    for (int axis = 0; axis < 3; ++axis) {
      Vec3 turn;
      turn[axis] = angle;
      for (int k = 0; k < 3; ++k) {
        const double expected =
            k == axis ? (std::tan(0.5 * angle) + std::sin(0.5 * angle)) / kSegmentLength : 0.0;
        CHECK(strain(1 + k, strained_segment(turn)) == doctest::Approx(expected).epsilon(1e-9));
      }
    }
}

TEST_CASE("the length of the edge is the stretch, whatever the frames do") {
  CHECK(strain(0, strained_segment({}, {0, 0, 1.25})) == doctest::Approx(1.25).epsilon(1e-14));
  CHECK(strain(0, strained_segment({0, 0, 0.7}, {0, 0, 0.5})) == doctest::Approx(0.5).epsilon(1e-14));
  // Bent by a, the nodes on an arc of a circle: the chord is along the middle tangent.
  CHECK(strain(0, strained_segment({0.4, 0, 0}, {0, 0, 0.99})) == doctest::Approx(0.99).epsilon(1e-14));
  for (const Vec3& turn : {Vec3{}, Vec3{3.1, 0, 0}, Vec3{1, -1, 2}})
    CHECK(strain(0, strained_segment(turn, {1.5, 0, -2})) == doctest::Approx(2.5).epsilon(1e-14));
}

TEST_CASE("an edge across the middle frame stores the energy of shear") {
  const RodProbe probe(define_rod_law("nothing", "nothing",
                                      [](PotentialBuilder&, const RodDeformation&) { return Scalar(0.0); }),
                       {{"shear_stiffness", {50.0}}});
  // k s^2 (1 - cos b) with the stretch s and the angle b: k/2 of the shear squared where that is small.
  const double s = std::sqrt(1.0 + 0.1 * 0.1 + 0.2 * 0.2);
  const double expected = 50.0 * s * (s - 1.0) * kSegmentLength;
  CHECK(probe.energy(strained_segment({}, {0.1, -0.2, 1})) == doctest::Approx(expected).epsilon(1e-13));
  // Nodes of an arc or a twisted line have none: the chord is along the middle frame.
  for (const Vec3& turn : {Vec3{0.3, 0, 0}, Vec3{0, -0.9, 0}, Vec3{0, 0, 2.0}, Vec3{1.0, -0.8, 2.0}})
    CHECK(std::fabs(probe.energy(strained_segment(turn))) < 1e-28);
}

TEST_CASE("shear grows with the angle up to half a turn: an edge that points backwards is not at rest") {
  const RodProbe probe(define_rod_law("nothing", "nothing",
                                      [](PotentialBuilder&, const RodDeformation&) { return Scalar(0.0); }),
                       {{"shear_stiffness", {50.0}}});
  double last = 0.0;
  for (int k = 1; k <= 16; ++k) {
    const double angle = k * 3.141592653589793 / 16;
    const double energy = probe.energy(strained_segment({0.7, 0, 0}, {std::sin(angle), 0, std::cos(angle)}));
    CHECK(energy > last);
    last = energy;
  }
}

TEST_CASE("half a turn between neighbouring frames takes energy without bound") {
  constexpr double kHalfTurn = 3.141592653589793;
  const RodLaw bending = define_rod_law("bending", "bending", [](PotentialBuilder&, const RodDeformation& d) {
    const RodStrain s = d.strain();
    return symbolic::square(s.curvature[0]) + symbolic::square(s.curvature[1]) + symbolic::square(s.twist);
  });
  const RodProbe probe(bending, {{"shear_stiffness", {0.0}}});
  for (const Vec3& axis : {Vec3{1, 0, 0}, Vec3{0, 0, 1}, Vec3{0.6, 0, 0.8}})
    for (const double rest : {1e-2, 1e-3, 1e-4}) {
      // tan(phi/2) = 2/rest to second order
      const double expected = 4.0 / (rest * rest) / kSegmentLength;
      CHECK(probe.energy(strained_segment(axis * (kHalfTurn - rest))) ==
            doctest::Approx(expected).epsilon(2.0 * rest));
    }
}

TEST_CASE("strains do not change when the segment is moved and turned") {
  const std::vector<Vec3> x = strained_segment({0.4, -0.3, 0.8}, {0.1, 0.05, 1.1});
  const Mat3 Q = exp_rotation({1.0, -2.0, 0.7});
  std::vector<Vec3> moved;
  for (size_t i = 0; i < x.size(); ++i) moved.push_back(Q * x[i] + (i < 2 ? Vec3{3, -1, 2} : Vec3{}));
  for (int k = 0; k < 4; ++k) CHECK(strain(k, moved) == doctest::Approx(strain(k, x)).epsilon(1e-10));
}

TEST_CASE("a traced formula of two points is the law written directly") {
  const RodLaw traced_law = rod_law_from("traced", "traced", traced(2, false));
  const RodLaw direct = define_rod_law("direct", "direct", [](PotentialBuilder& b, const RodDeformation& d) {
    const RodStrain s = d.strain();
    return b.parameter("k", "N", "stiffness", positive()) * symbolic::square(s.stretch - 1.0) +
           s.curvature[1] * s.twist;
  });
  const std::map<std::string, std::vector<double>> values{{"k", {3.0}}, {"shear_stiffness", {2.0}}};
  const std::vector<Vec3> x = strained_segment({0.4, -0.3, 0.8}, {0.1, 0.05, 1.1});
  CHECK(RodProbe(traced_law, values).energy(x) ==
        doctest::Approx(RodProbe(direct, values).energy(x)).epsilon(1e-13));
  CHECK_FALSE(traced_law.zero_at_rest);
}

TEST_CASE("only laws that use the past have inputs for it") {
  CHECK_FALSE(remembers(rod_law_from("traced", "traced", traced(2, false))));
  CHECK(remembers(rod_law_from("traced", "traced", traced(2, true))));
}

TEST_CASE("formulas of another number of points are refused") {
  CHECK_THROWS_AS(rod_law_from("wrong", "wrong", traced(3, false)), InvalidArgument);
}

TEST_CASE("the energy of a sum is the sum of the energies") {
  const RodLaw both = sum("both", {component(0), component(3)});
  const std::map<std::string, std::vector<double>> values{{"shear_stiffness", {0.0}}};
  const std::vector<Vec3> x = strained_segment({0.4, -0.3, 0.8}, {0.1, 0.05, 1.1});
  CHECK(RodProbe(both, values).energy(x) ==
        doctest::Approx((strain(0, x) + strain(3, x)) * kSegmentLength).epsilon(1e-13));
  CHECK(both.zero_at_rest);
  RodLaw unknown = component(1);
  unknown.zero_at_rest = false;
  CHECK_FALSE(sum("both", {component(0), unknown}).zero_at_rest);
}

TEST_CASE("a bar has the energy of its law at the stretch of its edge, and the memory of the law") {
  const RodLaw law = define_rod_law("all", "all strains", [](PotentialBuilder& b, const RodDeformation& d) {
    const RodStrain s = d.strain(), before = d.strain_prev();
    return b.parameter("k", "N", "stiffness") *
               (square(s.stretch - 1.0) + square(s.stretch - before.stretch)) +
           square(s.curvature[0]) + square(s.twist);
  });
  const PotentialDefinition bar = rod_bar(law);
  CHECK(bar.point_count == 2);
  CHECK(bar.translation_invariant);
  const std::vector<Vec3> X{{0, 0, 0}, {0, 0, 2}}, before{{0, 0, 0}, {2.2, 0, 0}},
      now{{1, 1, 1}, {1, 3.6, 1}};
  const FilledSample sample{X, before, now, {{"k", {5.0}}}};
  CHECK(test::energy(compiled(bar), sample, now) ==
        doctest::Approx(2.0 * 5.0 * (0.09 + 0.04)).epsilon(1e-12));
}
