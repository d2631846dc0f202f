// Joints as formulas: which points are left, derivatives, values, the two kinds of frames, repeated
// definitions.
#include <doctest/doctest.h>

#include <cmath>
#include <random>

#include <stark/base/rotation.h>
#include <stark/mechanics/define.h>
#include <support/finite_differences.h>

using namespace stark;
using symbolic::Backend;
using symbolic::Order;

namespace {

JointDefinition hinge() {
  return define_joint("hinge", "", [](JointBuilder& j) {
    j.hold(j.a.origin - j.b.origin, ResidualUnit::Length);
    j.hold(j.a.z - j.b.z, ResidualUnit::Angle);
    j.coordinate("angle", symbolic::atan2(symbolic::dot(j.b.x, j.a.y), symbolic::dot(j.b.x, j.a.x)), "rad");
  });
}

JointDefinition bilinear() {
  return define_joint("bilinear", "", [](JointBuilder& j) {
    const auto d = j.b.origin - j.a.origin;
    j.hold(symbolic::dot(j.a.x, d) - j.parameter("offset", "m", "where"), ResidualUnit::Length);
    j.hold(symbolic::dot(j.a.y, j.b.z), ResidualUnit::Angle);
    j.coordinate("travel", symbolic::dot(j.a.z, j.b.origin - j.b_prev.origin), "m");
  });
}

/// A batch of one joint with its points where `x` says and random multipliers.
struct OneJoint {
  OneJoint(const JointDefinition& definition, FrameKind a, FrameKind b, std::mt19937_64& random)
      : joint(definition, a, b, Backend::Automatic), batch(joint.potential()) {
    std::uniform_real_distribution<double> number(-1.0, 1.0);
    std::vector<int32_t> stencil;
    for (size_t k = 0; k < joint.points().size(); ++k) {
      stencil.push_back(static_cast<int32_t>(k));
      x.push_back({number(random), number(random), number(random)});
    }
    batch.resize(stencil);
    batch.set_previous(x);
    batch.set_initial(x);
    for (const ElementField& field : joint.potential()->element_fields()) {
      if (field.source != ElementField::Source::Data) continue;
      std::vector<double> values;
      for (int c = 0; c < field.width; ++c) values.push_back(number(random));
      batch.set(field.name, 0, values);
    }
  }

  Joint joint;
  PotentialBatch batch;
  std::vector<Vec3> x;
};

}  // namespace

TEST_CASE("a joint has only the points that its formula uses") {
  const Joint joint(hinge(), FrameKind::Axes, FrameKind::Axes, Backend::Interpreter);
  CHECK(joint.points() == std::vector<int>{0, 1, 2, 3, 4, 5, 7});  // b.y occurs nowhere
  CHECK(joint.units().size() == 6);
  CHECK(joint.hold_sizes() == std::vector<int>{3, 3});
  CHECK(joint.coordinates().size() == 1);
  const Joint patch(hinge(), FrameKind::Axes, FrameKind::Patch, Backend::Interpreter);
  CHECK(patch.points() == std::vector<int>{0, 1, 2, 3, 4, 5, 6});
}

TEST_CASE("energy, gradient and Hessian of the augmented Lagrangian agree with differences") {
  std::mt19937_64 random(7);
  for (const JointDefinition& definition : {hinge(), bilinear()})
    for (const FrameKind a : {FrameKind::Axes, FrameKind::Patch})
      for (const FrameKind b : {FrameKind::Axes, FrameKind::Placed, FrameKind::Patch}) {
        CAPTURE(definition.name);
        OneJoint one(definition, a, b, random);
        const int n = 3 * one.batch.point_count();
        const std::vector<double> all = one.batch.evaluate(Order::Hessian, one.x);
        double scale = 1.0;
        for (int k = 1; k <= n; ++k) scale = std::max(scale, std::fabs(all[k]));
        int entry = 1 + n;
        for (int i = 0; i < n; ++i) {
          const auto at = [&](double t, Order order) {
            std::vector<Vec3> moved = one.x;
            moved[i / 3][i % 3] += t;
            return one.batch.evaluate(order, moved);
          };
          const auto slope = test::differentiate([&](double t) { return at(t, Order::Energy); }, 0.01);
          CHECK(std::fabs(slope[0] - all[1 + i]) < 1e-7 * scale);
          const auto rows = test::differentiate([&](double t) { return at(t, Order::Gradient); }, 0.01);
          for (int j = i; j < n; ++j, ++entry) CHECK(std::fabs(rows[1 + j] - all[entry]) < 1e-6 * scale);
        }
      }
}

TEST_CASE("the energy is lambda C + rho/2 C^2 of the residuals") {
  std::mt19937_64 random(3);
  OneJoint one(bilinear(), FrameKind::Axes, FrameKind::Axes, random);
  const std::vector<double> values = one.batch.evaluate(one.joint.values(), one.x);
  double energy = 0.0;
  for (int k = 0; k < 2; ++k) {
    const double lambda = one.batch.get(one.batch.field_index("multiplier"), 0, k),
                 rho = one.batch.get(one.batch.field_index("penalty"), 0, k);
    energy += lambda * values[k] + 0.5 * rho * values[k] * values[k];
  }
  CHECK(one.batch.evaluate(Order::Energy, one.x)[0] == doctest::Approx(energy).epsilon(1e-13));
  CHECK(values[2] == doctest::Approx(0.0).epsilon(1e-15));  // nothing moved since the start of the step
}

TEST_CASE("axes of a patch are a right-handed rotation that follows the triangle") {
  const Mat3 R = exp_rotation({0.3, -0.2, 0.9});
  const auto axes = [](const Vec3& p0, const Vec3& p1, const Vec3& p2) {
    const auto symbol = [](const Vec3& p) { return symbolic::Vec3(p.x, p.y, p.z); };
    const symbolic::Mat3 T = patch_axes(symbol(p0), symbol(p1), symbol(p2));
    Mat3 result;
    for (int k = 0; k < 9; ++k) result.m[k] = T.m[k].value();
    return result;
  };
  const Vec3 p0{0.1, 0.2, 0.3}, p1{1.0, 0.1, 0.4}, p2{0.2, 0.9, 0.1};
  const Mat3 T = axes(p0, p1, p2), turned = axes(R * p0, R * p1, R * p2);
  CHECK(determinant(T) == doctest::Approx(1.0).epsilon(1e-14));
  for (int k = 0; k < 9; ++k) CHECK((R * T).m[k] == doctest::Approx(turned.m[k]).epsilon(1e-13));
}

TEST_CASE("a joint from a formula of eight points is the same joint") {
  const auto traced = std::make_shared<PotentialBuilder>(8);
  JointBuilder builder(*traced, FrameKind::Axes, FrameKind::Axes);
  hinge().formula(builder);
  std::vector<symbolic::Scalar> outputs = builder.residuals();
  outputs.push_back(builder.coordinates()[0].value);
  const JointDefinition again = define_joint(
      "again", "", Formula(traced, outputs),
      {.holds = {{ResidualUnit::Length, 3}, {ResidualUnit::Angle, 3}}, .coordinates = {{"angle", "rad"}}});
  std::mt19937_64 random(11), same(11);
  OneJoint first(hinge(), FrameKind::Axes, FrameKind::Patch, random),
      second(again, FrameKind::Axes, FrameKind::Patch, same);
  CHECK(first.batch.evaluate(Order::Hessian, first.x) == second.batch.evaluate(Order::Hessian, second.x));
  CHECK(first.batch.evaluate(first.joint.values(), first.x) ==
        second.batch.evaluate(second.joint.values(), second.x));
  CHECK(joint_coordinates(again)[0].unit == "rad");
  CHECK(joint_parameters(bilinear())[0].name == "offset");
}
