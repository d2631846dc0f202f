// Laws in rest states: no energy where the rest state is taken, energies by closed forms elsewhere.
#include <doctest/doctest.h>

#include <cmath>

#include <stark/base/rotation.h>
#include <stark/mechanics/rest_state.h>
#include <support/solid_bench.h>

using namespace stark;
using namespace stark::test;
using symbolic::Order;

namespace {

/// Energy and gradient of one element.
std::vector<double> evaluate(const PotentialDefinition& definition, const ParameterValues& values,
                             const std::vector<Vec3>& X, const std::vector<Vec3>& x,
                             Order order = Order::Energy) {
  PotentialBatch batch(
      std::make_shared<Potential>(definition, symbolic::Backend::Automatic, per_element_names(values)));
  std::vector<int32_t> stencil;
  for (size_t i = 0; i < X.size(); ++i) stencil.push_back(static_cast<int32_t>(i));
  batch.resize(stencil);
  batch.set_rest(X);
  set_values(batch, values);
  return batch.evaluate(order, x);
}

std::vector<Vec3> mapped(const Mat3& F, const std::vector<Vec3>& X) {
  std::vector<Vec3> x;
  for (const Vec3& p : X) x.push_back(F * p);
  return x;
}

const ParameterValues kModuli{{"shear_modulus", {{2.0}, false}}, {"bulk_modulus", {{3.0}, false}}};
const std::vector<Vec3> kTet{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};

RodLaw bar_law() {
  return define_rod_law("bar", "", [](PotentialBuilder&, const RodDeformation& deformation) {
    const RodStrain s = deformation.strain();
    return symbolic::square(s.stretch - 1.0) + symbolic::square(s.curvature[0]) +
           symbolic::square(s.curvature[1]) + symbolic::square(s.twist);
  });
}

/// Nodes and directors of a segment between places with frames.
std::vector<Vec3> segment(const Vec3& x0, const Mat3& R0, const Vec3& x1, const Mat3& R1) {
  std::vector<Vec3> points{x0, x1};
  for (const Mat3& R : {R0, R1})
    for (int k = 0; k < 3; ++k) points.push_back(R.column(k));
  return points;
}

}  // namespace

TEST_CASE("solids have no energy in the grown and heated shape, and that of its volume elsewhere") {
  const Mat3 G = Mat3::from_columns({1.2, 0.1, 0.0}, {0.0, 0.9, 0.05}, {-0.1, 0.0, 1.1});
  const double thermal = 1.0 + 2e-3 * 50.0;
  ParameterValues values = kModuli;
  values["growth"] = {{G.m.begin(), G.m.end()}, true};
  values["temperature"] = {{50.0}, true};
  values["thermal_expansion"] = {{2e-3}, false};
  const PotentialDefinition grown =
      tet4(rest_state::with_fields(test_law(), {rest_state::kGrowth, rest_state::kTemperature}));
  const Mat3 R = exp_rotation({0.4, -0.2, 1.0}), elastic = Mat3::diagonal({1.1, 1.0, 0.95});
  for (const double value : evaluate(grown, values, kTet, mapped(R * G * thermal, kTet), Order::Gradient))
    CHECK(std::fabs(value) < 1e-14);
  const double psi = 6.0 * evaluate(tet4(test_law()), kModuli, kTet, mapped(elastic, kTet))[0];
  const double J = determinant(G) * thermal * thermal * thermal;
  CHECK(evaluate(grown, values, kTet, mapped(R * elastic * G * thermal, kTet))[0] ==
        doctest::Approx(psi * J / 6.0).epsilon(1e-12));
}

TEST_CASE("muscles pull along their fibres with the active stress, whatever their length") {
  ParameterValues values = kModuli;
  values["shear_modulus"] = values["bulk_modulus"] = {{0.0}, false};
  values["active_stress"] = {{7.0}, true};
  values["fiber_direction"] = {{3.0, 0.0, 0.0}, true};
  const PotentialDefinition muscle =
      tet4(rest_state::with_fields(test_law(), {rest_state::kActiveStress, rest_state::kFiberDirection}));
  for (const double stretch : {0.7, 1.0, 1.6}) {
    const auto out =
        evaluate(muscle, values, kTet, mapped(Mat3::diagonal({stretch, 1, 1}), kTet), Order::Gradient);
    CHECK(out[0] == doctest::Approx(7.0 * (stretch - 1.0) / 6.0));
    CHECK(out[4] == doctest::Approx(7.0 / 6.0).epsilon(1e-14));  // node 1 carries S V dF_xx/dx_1
    for (const int other : {5, 6, 7, 8, 9, 10, 11, 12}) CHECK(std::fabs(out[other]) < 1e-15);
  }
}

TEST_CASE("fibres of a sheet pull along what of their direction lies in its triangle") {
  const ShellLaw nothing = define_shell_law(
      "nothing", "", [](PotentialBuilder&, const ShellDeformation&) { return symbolic::Scalar(0.0); });
  const PotentialDefinition muscle =
      triangle3(rest_state::with_fields(nothing, {rest_state::kActiveStress, rest_state::kFiberDirection}));
  const Mat3 tilt = exp_rotation({0.3, -0.5, 0.2}), turn = exp_rotation({-0.8, 0.1, 0.6});
  const std::vector<Vec3> flat{{0, 0, 0}, {2, 0, 0}, {0.7, 1.5, 0}}, X = mapped(tilt, flat);
  const Vec3 fiber = tilt * Vec3{3.0, -4.0, 5.0};  // of length 5 in the sheet, along (0.6, -0.8, 0)
  const ParameterValues values{{"active_stress", {{7.0}, true}},
                               {"fiber_direction", {{fiber.x, fiber.y, fiber.z}, true}},
                               {"thickness", {{0.01}, false}}};
  for (const double stretch : {0.7, 1.0, 1.6}) {
    const auto out = evaluate(muscle, values, X, mapped(turn, mapped(Mat3::diagonal({stretch, 1, 1}), flat)),
                              Order::Gradient);
    const double along = std::sqrt(0.36 * stretch * stretch + 0.64);
    CHECK(out[0] == doctest::Approx(7.0 * (along - 1.0) * 0.01 * 1.5));
    // Virtual work of stretching along x: S V times the derivative of the stretch of the fibres.
    double power = 0.0;
    for (int i = 0; i < 3; ++i)
      power += dot(Vec3{out[1 + 3 * i], out[2 + 3 * i], out[3 + 3 * i]}, turn * Vec3{flat[i].x, 0, 0});
    CHECK(power == doctest::Approx(7.0 * 0.01 * 1.5 * 0.36 * stretch / along).epsilon(1e-12));
  }
}

TEST_CASE("rods pull with their active force, whatever their length") {
  const RodLaw law = rest_state::with_fields(
      define_rod_law("nothing", "",
                     [](PotentialBuilder&, const RodDeformation&) { return symbolic::Scalar(0.0); }),
      {rest_state::kActiveForce, rest_state::kGrowth});
  const ParameterValues values{
      {"active_force", {{7.0}, true}}, {"growth", {{1.3}, true}}, {"shear_stiffness", {{0.0}, false}}};
  const Mat3 I = Mat3::identity();
  for (const double stretch : {0.7, 1.0, 1.6}) {
    const auto out = evaluate(rod_segment(law), values, segment({0, 0, 0}, I, {0, 0, 0.5}, I),
                              segment({0, 0, 0}, I, {0, 0, 0.5 * stretch}, I), Order::Gradient);
    CHECK(out[0] == doctest::Approx(7.0 * 0.5 * (stretch - 1.0)));
    CHECK(out[6] == doctest::Approx(7.0).epsilon(1e-14));
  }
}

TEST_CASE("rods have no energy in a natural arc with natural twist, of any turn") {
  const Vec3 X1{0, 0, 0.5};
  const Mat3 I = Mat3::identity();
  const RodLaw law = rest_state::with_fields(
      bar_law(), {rest_state::kGrowth, rest_state::kNaturalCurvature, rest_state::kNaturalTwist});
  for (const double size : {0.0, 1e-5, 1e-3, 0.5, 3.0}) {
    const Vec3 natural = Vec3{0.6, -0.3, 0.4} * size;
    const double growth = 1.3;
    const ParameterValues values{{"growth", {{growth}, true}},
                                 {"natural_curvature", {{natural.x, natural.y}, true}},
                                 {"natural_twist", {{natural.z}, true}},
                                 {"shear_stiffness", {{1.0}, false}}};
    const Mat3 half = exp_rotation(natural * (0.5 * 0.5 * growth)), whole = half * half;
    const auto x = segment({0, 0, 0}, I, half * X1 * growth, whole);
    for (const double value :
         evaluate(rod_segment(law), values, segment({0, 0, 0}, I, X1, I), x, Order::Gradient))
      CHECK(std::fabs(value) < 1e-12);
  }
}
