// Elements with quadrature points: deformation gradients, one-point tetrahedra against the linear element,
// parameters and memory of each element.
#include <doctest/doctest.h>

#include <cmath>

#include <stark/base/rotation.h>
#include <stark/mechanics/site_gradient.h>
#include <support/solid_bench.h>

using namespace stark;
using namespace stark::test;
using symbolic::kLanes;
using symbolic::Order;

namespace {

const ParameterValues kValues{{"shear_modulus", {{2.0}, false}}, {"bulk_modulus", {{3.0}, false}}};

}  // namespace

TEST_CASE("affine motion has psi(F) times the volume, whatever the element and its shape") {
  const Mat3 F = exp_rotation({0.3, 1.0, -2.0}) * Mat3::diagonal({1.2, 0.9, 1.1});
  const double strain = 0.44 * 0.44 + 0.19 * 0.19 + 0.21 * 0.21, J = 1.2 * 0.9 * 1.1;
  const double psi = 2.0 / 8.0 * strain + 1.5 * (J - 1) * (J - 1);
  for (const SolidMesh& mesh : distorted_boxes()) {
    const QuadratureBatch batch = make_quadrature_batch(mesh, quadrature_point(test_law()), kValues);
    std::vector<Vec3> x;
    for (const Vec3& X : mesh.vertices) x.push_back(F * X + Vec3{1, 2, 3});
    double volume = 0.0;
    for (const double v : compute_element_volumes(mesh)) volume += v;
    CHECK(total_energy(batch, x) == doctest::Approx(psi * volume).epsilon(1e-12));
    CHECK(std::fabs(total_energy(batch, mesh.vertices)) < 1e-25);
  }
}

TEST_CASE("one-point tetrahedra are linear tetrahedra") {
  const TetMesh tets = make_tet_box({1, 1, 1}, {2, 2, 1});
  const QuadratureBatch batch = make_quadrature_batch(tets, quadrature_point(test_law()), kValues);
  PotentialBatch linear(std::make_shared<Potential>(tet4(test_law()), symbolic::Backend::Automatic));
  linear.resize(SolidMesh(tets).elements);
  linear.set_rest(tets.vertices);
  set_values(linear, kValues);
  std::vector<Vec3> x = tets.vertices;
  RandomPoints random(3);
  for (Vec3& p : x) p += random.point() * 0.1;
  const KinematicMap map = point_map(x.size());
  ThreadPool pool(1);
  Assembler first(map, pool), second(map, pool);
  first.set_static_batches({}, {&batch});
  second.set_static_batches({&linear});
  for (const bool project : {false, true}) {
    const DenseSystem a = assemble_dense(first, map, x, {.project = project, .pending = {}});
    const DenseSystem b = assemble_dense(second, map, x, {.project = project, .pending = {}});
    for (size_t i = 0; i < a.gradient.size(); ++i) CHECK(std::fabs(a.gradient[i] - b.gradient[i]) < 1e-13);
    if (project) continue;  // the projection acts in F and in x: nearest in different norms
    for (size_t i = 0; i < a.hessian.size(); ++i) CHECK(std::fabs(a.hessian[i] - b.hessian[i]) < 1e-12);
  }
}

TEST_CASE("each element may have values of its own, at all its points") {
  SolidMesh mesh = make_hex_box({1, 1, 1}, {3, 2, 1});
  std::vector<double> moduli;
  for (int e = 0; e < 6; ++e) moduli.push_back(1.0 + e);
  const QuadratureBatch batch =
      make_quadrature_batch(mesh, quadrature_point(test_law()),
                            {{"shear_modulus", {moduli, true}}, {"bulk_modulus", {{0.0}, false}}});
  std::vector<Vec3> x;
  for (const Vec3& X : mesh.vertices) x.push_back(Mat3::diagonal({1.2, 1, 1}) * X);
  AlignedVector<double> out(batch.law().block_count() * kLanes);
  batch.evaluate(Order::Energy, x, 0, batch.group_count(), out.data());
  for (int e = 0; e < 6; ++e)
    for (int q = 0; q < 8; ++q)
      CHECK(out[8 * e + q] == doctest::Approx((1.0 + e) * 0.44 * 0.44 / 8 / 6 / 8).epsilon(1e-12));
}

TEST_CASE("laws with memory see the deformation gradient at the start of the step") {
  const SolidLaw rate =
      define_solid_law("rate", "", [](PotentialBuilder& b, const SolidDeformation& deformation) {
        return squared_norm(deformation.F() - deformation.F_prev()) / b.time_step();
      });
  for (const SolidMesh& mesh : distorted_boxes()) {
    QuadratureBatch batch = make_quadrature_batch(mesh, quadrature_point(rate), {});
    std::vector<Vec3> before, now;
    for (const Vec3& X : mesh.vertices) {
      before.push_back(Mat3::diagonal({1.1, 1, 1}) * X);
      now.push_back(Mat3::diagonal({1.3, 1, 0.9}) * X);
    }
    batch.set_previous(before);
    batch.set_time(0.5, 1.0);
    double volume = 0.0;
    for (const double v : compute_element_volumes(mesh)) volume += v;
    CHECK(total_energy(batch, now) == doctest::Approx(volume * (0.04 + 0.01) / 0.5).epsilon(1e-12));
  }
}
