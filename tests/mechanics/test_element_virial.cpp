// Virials of elements against the energy of affine motions, and the stress that follows from them.
#include <doctest/doctest.h>

#include <cmath>

#include <stark/mechanics/element_virial.h>
#include <stark/mechanics/site_gradient.h>
#include <support/solid_bench.h>

using namespace stark;
using namespace stark::test;

namespace {

const ParameterValues kValues{{"shear_modulus", {{2.0}, false}}, {"bulk_modulus", {{3.0}, false}}};

std::vector<Vec3> shaken(const std::vector<Vec3>& vertices) {
  RandomPoints random(5);
  std::vector<Vec3> x = vertices;
  for (Vec3& p : x) p += random.point() * 0.05;
  return x;
}

/// The sum of all virials is the derivative of the energy by H, where all points move as x -> (1 + H) x.
template <typename Batch>
void check_against_affine_motions(const Batch& batch, const std::vector<Vec3>& x) {
  Mat3 sum;
  for (const Mat3& virial : element_virials(batch, x)) sum += virial;
  const double t = 1e-6;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      std::vector<Vec3> above = x, below = x;
      for (size_t p = 0; p < x.size(); ++p) {
        above[p][i] += t * x[p][j];
        below[p][i] -= t * x[p][j];
      }
      const double slope = (total_energy(batch, above) - total_energy(batch, below)) / (2.0 * t);
      CHECK(sum(i, j) == doctest::Approx(slope).epsilon(1e-6));
    }
}

}  // namespace

TEST_CASE("virials are what the energy of affine motions changes by") {
  for (const SolidMesh& mesh : distorted_boxes())
    check_against_affine_motions(make_quadrature_batch(mesh, quadrature_point(test_law()), kValues),
                                 shaken(mesh.vertices));
  const SolidMesh hexes = make_hex_box({1, 1, 1}, {2, 1, 2});
  check_against_affine_motions(make_quadrature_batch(hexes, mean_dilatation_point(test_law()), kValues),
                               shaken(hexes.vertices));
  const TetMesh tets = make_tet_box({1, 1, 1}, {2, 2, 1});
  PotentialBatch linear(std::make_shared<Potential>(tet4(test_law()), symbolic::Backend::Automatic));
  linear.resize(SolidMesh(tets).elements);
  linear.set_rest(tets.vertices);
  set_values(linear, kValues);
  check_against_affine_motions(linear, shaken(tets.vertices));
}

TEST_CASE("an affine motion gives every element the Cauchy stress of the law, far from the origin, too") {
  const Vec3 stretches{1.2, 0.9, 1.1};
  const double J = stretches[0] * stretches[1] * stretches[2];
  for (const SolidMesh& mesh : distorted_boxes()) {
    const QuadratureBatch batch = make_quadrature_batch(mesh, quadrature_point(test_law()), kValues);
    std::vector<Vec3> x;
    for (const Vec3& X : mesh.vertices) x.push_back(Mat3::diagonal(stretches) * X + Vec3{1e4, -2e4, 3e4});
    const std::vector<Mat3> virials = element_virials(batch, x);
    const std::vector<double> volumes = element_volumes(batch, x), at_rest = compute_element_volumes(mesh);
    for (size_t e = 0; e < virials.size(); ++e) {
      CHECK(volumes[e] == doctest::Approx(J * at_rest[e]).epsilon(1e-9));
      for (int i = 0; i < 3; ++i) {
        // Of G/8 |C - 1|^2 + K/2 (J - 1)^2 along a principal axis.
        const double s = stretches[i];
        const double cauchy = 2.0 * 0.5 * (s * s - 1.0) * s * s / J + 3.0 * (J - 1.0);
        CHECK(virials[e](i, i) / volumes[e] == doctest::Approx(cauchy).epsilon(1e-8));
        CHECK(std::fabs(virials[e](i, (i + 1) % 3)) < 1e-8 * volumes[e]);
      }
    }
  }
}
