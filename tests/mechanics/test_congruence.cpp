// Mapped elements against the plain chain rule with dense matrices.
#include <doctest/doctest.h>

#include <stark/mechanics/congruence.h>
#include <support/mixed_scene.h>

using namespace stark;
using namespace stark::test;
using symbolic::kLanes;

namespace {

/// Kernel outputs of one lane with random symmetric Hessian; other lanes hold numbers that must not matter.
struct RandomElement {
  RandomElement(int point_count, RandomPoints& random) : points(point_count), n(3 * point_count) {
    out.assign((1 + n + n * (n + 1) / 2) * kLanes, 1e30);
    for (size_t k = 0; k < out.size() / kLanes; ++k) out[k * kLanes + lane] = random.uniform();
  }
  ElementView view() const { return {out.data(), n, lane}; }
  double h(int i, int j) const {  // independent of ElementView's index arithmetic
    if (i > j) std::swap(i, j);
    int slot = 1 + n;
    for (int r = 0; r < i; ++r) slot += n - r;
    return out[(slot + j - i) * kLanes + lane];
  }

  static constexpr int lane = 5;
  int points, n;
  AlignedVector<double> out;
};

}  // namespace

TEST_CASE("element views read gradient and Hessian blocks of their lane") {
  RandomPoints random(1);
  for (int points = 1; points <= 4; ++points) {
    const RandomElement element(points, random);
    const ElementView view = element.view();
    for (int p = 0; p < points; ++p)
      for (int q = 0; q < points; ++q)
        for (int a = 0; a < 3; ++a)
          for (int b = 0; b < 3; ++b)
            CHECK(view.point_hessian(p, q)(a, b) == element.h(3 * p + a, 3 * q + b));
    for (int p = 0; p < points; ++p)
      for (int a = 0; a < 3; ++a)
        CHECK(view.point_gradient(p)[a] == element.out[(1 + 3 * p + a) * kLanes + 5]);
  }
}

TEST_CASE("mapped elements are J^T g and J^T H J, also when sites share bodies and points") {
  const MixedScene scene(2);
  RandomPoints random(3);
  const int n = scene.dof_count(), blocks = n / 3;
  std::vector<std::pair<int32_t, int32_t>> all_pairs;
  for (int i = 0; i < blocks; ++i)
    for (int j = i; j < blocks; ++j) all_pairs.emplace_back(i, j);
  for (int trial = 0; trial < 200; ++trial) {
    const int points = random.integer(1, 4);
    const RandomElement element(points, random);
    std::vector<int32_t> sites;
    std::vector<SiteJacobian> jacobians;
    for (int p = 0; p < points; ++p) {
      sites.push_back(random.integer(0, scene.map.site_count() - 1));
      jacobians.push_back(scene.map.jacobian(sites.back(), scene.configuration));
    }
    // Dense J of the whole element.
    std::vector<double> J(element.n * n, 0.0);
    std::vector<Mat3> moment(MixedScene::kBodies);
    for (int p = 0; p < points; ++p) {
      for (int k = 0; k < jacobians[p].term_count; ++k) {
        const JacobianTerm& term = jacobians[p].terms[k];
        const Mat3 block = jacobians[p].matrix(term);
        for (int r = 0; r < 3; ++r)
          for (int c = 0; c < 3; ++c) J[(3 * p + r) * n + 3 * term.block + c] += block(r, c);
      }
      for (size_t k = 0; k < jacobians[p].support_blocks.size(); ++k)
        if (const int32_t block = jacobians[p].support_blocks[k]; block != kNoBlock)
          for (int r = 0; r < 3; ++r) J[(3 * p + r) * n + 3 * block + r] += jacobians[p].support_weights[k];
      if (jacobians[p].body >= 0)
        moment[jacobians[p].body] += outer(element.view().point_gradient(p), jacobians[p].lever);
    }
    std::vector<double> gradient(n, 0.0);
    std::vector<Mat3> body_moment(MixedScene::kBodies);
    BlockMatrix hessian;
    hessian.pattern = BlockPattern::from_pairs(blocks, all_pairs);
    hessian.set_zero();
    SitePairs pairs;
    add_mapped_gradients(element.view(), jacobians, {}, gradient, body_moment);
    add_mapped_hessian(element.view(), sites, jacobians, hessian, pairs);
    pairs.scatter(scene.map, scene.configuration, hessian);
    const std::vector<double> dense = to_dense(hessian);
    double worst = 0.0;
    for (int i = 0; i < n; ++i) {
      double g = 0.0;
      for (int r = 0; r < element.n; ++r) g += J[r * n + i] * element.out[(1 + r) * kLanes + 5];
      worst = std::fmax(worst, std::fabs(g - gradient[i]));
      for (int j = 0; j < n; ++j) {
        double h = 0.0;
        for (int r = 0; r < element.n; ++r)
          for (int s = 0; s < element.n; ++s) h += J[r * n + i] * element.h(r, s) * J[s * n + j];
        worst = std::fmax(worst, std::fabs(h - dense[i * n + j]));
      }
    }
    for (int b = 0; b < MixedScene::kBodies; ++b)
      for (int k = 0; k < 9; ++k) worst = std::fmax(worst, std::fabs(moment[b].m[k] - body_moment[b].m[k]));
    CHECK(worst < 1e-13);
  }
}

TEST_CASE("pending motion of prescribed sites changes the gradient by H d") {
  const MixedScene scene(4);
  RandomPoints random(5);
  const RandomElement element(3, random);
  const std::vector<int32_t> sites{0, 5, 6};  // a free point and two prescribed ones
  std::vector<Vec3> pending(scene.map.site_count(), Vec3{7, 7, 7}),
      change(3);  // that of free sites must not count
  pending[5] = random.point();
  pending[6] = random.point();
  pending_gradient(element.view(), sites, scene.map, pending, change);
  for (int i = 0; i < 9; ++i) {
    double expected = 0.0;
    for (int q = 1; q < 3; ++q)
      for (int c = 0; c < 3; ++c) expected += element.h(i, 3 * q + c) * pending[sites[q]][c];
    CHECK(change[i / 3][i % 3] == doctest::Approx(expected).epsilon(1e-13));
  }
}
