// Laws apart from elements: sums, laws made of traced formulas, linear elements, frames of shells.
#include <doctest/doctest.h>

#include <stark/base/error.h>
#include <stark/base/rotation.h>
#include <stark/mechanics/define.h>
#include <support/potential_sample.h>

using namespace stark;
using namespace stark::test;
using symbolic::Backend;
using symbolic::Order;

namespace {

/// G/2 |F^T F - 1|^2, of solids and shells.
template <typename Deformation>
symbolic::Scalar strain_energy(PotentialBuilder& b, const Deformation& deformation) {
  const auto F = deformation.F();
  return 0.5 * b.parameter("stiffness", "Pa", "stiffness", positive()) *
         symbolic::squared_norm(transpose(F) * F - decltype(transpose(F) * F)::identity());
}

/// |F - F_prev|^2 / h.
symbolic::Scalar rate_energy(PotentialBuilder& b, const SolidDeformation& deformation) {
  return symbolic::squared_norm(deformation.F() - deformation.F_prev()) / b.time_step();
}

SolidLaw solid_law() { return define_solid_law("strain", "strain energy", strain_energy<SolidDeformation>); }

/// The law written as a formula of points, as Python traces it.
Formula traced(int columns, bool with_rate) {
  auto b = std::make_shared<PotentialBuilder>(columns);
  symbolic::Scalar psi = 0.0;
  const auto k = b->parameter("stiffness", "Pa", "stiffness", positive());
  for (int i = 0; i < columns; ++i)
    for (int j = 0; j < columns; ++j) {
      const auto difference = symbolic::dot(b->x(i), b->x(j)) - symbolic::dot(b->X(i), b->X(j));
      psi += 0.5 * k * difference * difference;
    }
  if (with_rate)
    for (int i = 0; i < columns; ++i) psi += symbolic::squared_norm(b->x(i) - b->x_prev(i)) / b->time_step();
  return Formula(b, {psi});
}

void check_same(const PotentialDefinition& a, const PotentialDefinition& b) {
  const Potential first(a, Backend::Interpreter), second(b, Backend::Interpreter);
  std::mt19937_64 random(3);
  for (int k = 0; k < 5; ++k) {
    const FilledSample sample = fill_sample(a, first, random);
    const auto expected = evaluate(first, sample, Order::Hessian, sample.x);
    const auto found = evaluate(second, sample, Order::Hessian, sample.x);
    REQUIRE(expected.size() == found.size());
    for (size_t i = 0; i < expected.size(); ++i)
      CHECK(found[i] == doctest::Approx(expected[i]).epsilon(1e-11).scale(1.0));
  }
}

}  // namespace

TEST_CASE("a law without memory asks for no past, a viscous one does") {
  const auto remembers = [](const PotentialDefinition& definition) {
    const Potential potential(definition, Backend::Interpreter);
    for (const ElementField& field : potential.element_fields())
      if (field.source == ElementField::Source::Previous) return true;
    return false;
  };
  CHECK_FALSE(remembers(tet4(solid_law())));
  CHECK(remembers(tet4(define_solid_law("rate", "rate", rate_energy))));
}

TEST_CASE("energy of a tetrahedron is psi of F times its volume") {
  const Potential potential(tet4(solid_law()), Backend::Interpreter);
  const std::vector<Vec3> X{{0, 0, 0}, {2, 0, 0}, {0, 3, 0}, {0, 0, 1}};
  Mat3 F = Mat3::diagonal({1.5, 1, 1});
  std::vector<Vec3> x;
  for (const Vec3& p : X) x.push_back(F * p + Vec3{1, 2, 3});
  const FilledSample sample{X, X, x, {{"stiffness", {4.0}}}};
  CHECK(energy(potential, sample, x) == doctest::Approx(1.0 * 0.5 * 4.0 * 1.25 * 1.25));  // volume 1
}

TEST_CASE("laws made of traced formulas are those laws") {
  check_same(tet4(solid_law()), tet4(solid_law_from("strain", "", traced(3, false))));
  check_same(tet4(sum("both", {solid_law(), define_solid_law("rate", "rate", rate_energy)})),
             tet4(solid_law_from("both", "", traced(3, true))));
  ShellLaw shell = define_shell_law("strain", "", strain_energy<ShellDeformation>);
  shell.isotropic = false;  // nothing is known about a formula
  check_same(triangle3(shell), triangle3(shell_law_from("strain", "", traced(2, false))));
}

TEST_CASE("formulas of another number of points are refused") {
  CHECK_THROWS_AS(solid_law_from("strain", "", traced(2, false)), InvalidArgument);
  CHECK_THROWS_AS(shell_law_from("strain", "", traced(3, false)), InvalidArgument);
}

TEST_CASE("ranges of parameters survive tracing and repetition") {
  PotentialBuilder b(4);
  (void)tet4(solid_law_from("strain", "", traced(3, false))).energy(b);
  REQUIRE(b.uniform_fields().size() == 1);
  CHECK_FALSE(b.uniform_fields()[0].rule.holds(-1.0));
}

TEST_CASE("the first axis of a shell is the projected warp direction") {
  // |F e1|^2 is the squared stretch along the warp.
  ShellLaw law = define_shell_law("warp", "", [](PotentialBuilder&, const ShellDeformation& deformation) {
    return symbolic::squared_norm(deformation.F().column(0));
  });
  law.isotropic = false;
  const Potential potential(triangle3(law), Backend::Interpreter);
  std::mt19937_64 random(5);
  const Mat3 R = exp_rotation(random_vector(random, 2.0));
  const Vec3 warp{std::cos(0.7), std::sin(0.7), 0.0};
  std::vector<Vec3> X, x;
  for (const Vec3& p : {Vec3{0.1, 0, 0}, Vec3{1.2, 0.1, 0}, Vec3{0.4, 0.9, 0}}) {
    X.push_back(R * p);
    x.push_back(p + 0.5 * dot(p, warp) * warp);  // stretched by 1.5 along the warp
  }
  const double area = 0.5 * norm(cross(X[1] - X[0], X[2] - X[0]));
  const Vec3 given = R * (warp * 3.0 + Vec3{0, 0, 1.1});  // length and normal part do not count
  const FilledSample sample{X, X, x, {{"thickness", {2.0}}, {"warp_direction", {given.x, given.y, given.z}}}};
  CHECK(energy(potential, sample, x) == doctest::Approx(2.25 * 2.0 * area).epsilon(1e-12));
  CHECK(is_projectable(given, X[0], X[1], X[2]));
  CHECK_FALSE(is_projectable(R * Vec3{0, 0, 1}, X[0], X[1], X[2]));
}
