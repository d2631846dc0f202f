// Forces on sites against differences of energies, for stencils and for elements with quadrature points.
#include <doctest/doctest.h>

#include <cmath>

#include <stark/mechanics/site_gradient.h>
#include <support/solid_bench.h>

using namespace stark;
using namespace stark::test;

namespace {

const ParameterValues kValues{{"shear_modulus", {{2.0}, false}}, {"bulk_modulus", {{3.0}, false}}};

template <typename Batch>
void check_against_differences(const Batch& batch, std::vector<Vec3> x) {
  std::vector<Vec3> gradient(x.size(), Vec3{1, 2, 3});  // what is there stays
  add_site_gradient(batch, x, 2.0, gradient);
  const double h = 1e-6;
  for (size_t i = 0; i < x.size(); i += 3)
    for (int a = 0; a < 3; ++a) {
      const double there = x[i][a];
      x[i][a] = there + h;
      const double above = total_energy(batch, x);
      x[i][a] = there - h;
      const double below = total_energy(batch, x);
      x[i][a] = there;
      CHECK(gradient[i][a] == doctest::Approx(1.0 + a + (above - below) / h).epsilon(1e-7));
    }
}

}  // namespace

TEST_CASE("site gradients are the derivatives of the energy") {
  RandomPoints random(5);
  for (const SolidMesh& mesh : distorted_boxes()) {
    std::vector<Vec3> x = mesh.vertices;
    for (Vec3& p : x) p += random.point() * 0.05;
    check_against_differences(make_quadrature_batch(mesh, quadrature_point(test_law()), kValues), x);
  }
  const TetMesh tets = make_tet_box({1, 1, 1}, {2, 2, 1});
  PotentialBatch linear(std::make_shared<Potential>(tet4(test_law()), symbolic::Backend::Automatic));
  linear.resize(SolidMesh(tets).elements);
  linear.set_rest(tets.vertices);
  set_values(linear, kValues);
  std::vector<Vec3> x = tets.vertices;
  for (Vec3& p : x) p += random.point() * 0.05;
  check_against_differences(linear, x);
}
