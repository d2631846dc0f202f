// Positions, Jacobians and curvature of all kinds of sites against differences of the retraction.
#include <doctest/doctest.h>

#include <stark/mechanics/kinematic_map.h>
#include <support/finite_differences.h>
#include <support/mixed_scene.h>

using namespace stark;
using namespace stark::test;

namespace {

/// dx_site / d unknown as a dense 3 x n row-major matrix.
std::vector<double> dense_jacobian(const MixedScene& scene, int32_t site) {
  const int n = scene.dof_count();
  std::vector<double> J(3 * n);
  const SiteJacobian jacobian = scene.map.jacobian(site, scene.configuration);
  for (int k = 0; k < jacobian.term_count; ++k) {
    const JacobianTerm& term = jacobian.terms[k];
    const Mat3 block = jacobian.matrix(term);
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c) J[r * n + 3 * term.block + c] += block(r, c);
  }
  for (size_t k = 0; k < jacobian.support_blocks.size(); ++k)
    if (const int32_t block = jacobian.support_blocks[k]; block != kNoBlock)
      for (int r = 0; r < 3; ++r) J[r * n + 3 * block + r] += jacobian.support_weights[k];
  return J;
}

}  // namespace

TEST_CASE("positions follow the definitions of the kinds of sites") {
  const MixedScene scene(1);
  const Configuration& c = scene.configuration;
  const std::vector<Vec3> x = scene.positions(c);
  for (int p = 0; p < MixedScene::kPoints; ++p) CHECK(x[p] == c.point_position[p]);
  for (int32_t i = 0; i < scene.map.site_count(); ++i) {
    const Site& site = scene.map.site(i);
    if (site.kind == SiteKind::RigidPoint)
      CHECK(norm(x[i] - c.body_position[site.index]) == doctest::Approx(norm(site.local)).epsilon(1e-14));
    if (site.kind == SiteKind::RigidDirection)
      CHECK(norm(x[i]) == doctest::Approx(norm(site.local)).epsilon(1e-14));
  }
  const Vec3 mean = 0.1 * c.point_position[0] + 0.2 * c.point_position[1] + 0.3 * c.point_position[2] +
                    0.4 * c.point_position[3];
  CHECK(max_abs(x[scene.first_barycentric] - mean) < 1e-15);

  Configuration turned = c;
  turned.body_position[0] = {1, 2, 3};
  turned.body_rotation[0] = exp_rotation({0, 0, 1.5707963267948966});
  const Vec3 local = scene.map.site(MixedScene::kPoints).local;
  CHECK(max_abs(scene.positions(turned)[MixedScene::kPoints] - Vec3{1 - local.y, 2 + local.x, 3 + local.z}) <
        1e-15);
}

TEST_CASE("prescribed sites are those that no unknown moves") {
  const MixedScene scene(1);
  for (int32_t i = 0; i < scene.map.site_count(); ++i) {
    const Site& site = scene.map.site(i);
    const bool expected =
        (site.kind == SiteKind::Point && site.index >= MixedScene::kFreePoints) ||
        ((site.kind == SiteKind::RigidPoint || site.kind == SiteKind::RigidDirection) && site.index == 2) ||
        i == scene.first_barycentric + 2;
    CHECK(scene.map.is_prescribed(i) == expected);
    CHECK(scene.map.jacobian(i, scene.configuration).is_zero() == expected);
  }
}

TEST_CASE("blocks of a site are those of its Jacobian") {
  const MixedScene scene(2);
  for (int32_t i = 0; i < scene.map.site_count(); ++i) {
    std::vector<int32_t> blocks;
    scene.map.append_blocks(i, blocks);
    const SiteJacobian jacobian = scene.map.jacobian(i, scene.configuration);
    if (jacobian.is_embedded()) {
      std::vector<int32_t> of_support(jacobian.support_blocks.begin(), jacobian.support_blocks.end());
      std::erase(of_support, kNoBlock);
      CHECK(blocks == of_support);
      continue;
    }
    REQUIRE(static_cast<int>(blocks.size()) == jacobian.term_count);
    for (int k = 0; k < jacobian.term_count; ++k) CHECK(jacobian.terms[k].block == blocks[k]);
  }
}

TEST_CASE("Jacobians agree with differences of the retraction for every kind of site") {
  const MixedScene scene(3);
  const int n = scene.dof_count();
  for (int32_t site = 0; site < scene.map.site_count(); ++site) {
    CAPTURE(site);
    const std::vector<double> J = dense_jacobian(scene, site);
    for (int i = 0; i < n; ++i) {
      std::vector<double> direction(n, 0.0);
      direction[i] = 1.0;
      const std::vector<double> column = differentiate(
          [&](double t) {
            const Vec3 x = scene.positions(scene.along(direction, t))[site];
            return std::vector<double>{x.x, x.y, x.z};
          },
          0.2);
      for (int r = 0; r < 3; ++r) CHECK(std::fabs(column[r] - J[r * n + i]) < 1e-11);
    }
  }
}

TEST_CASE("points that are embedded sites follow the points of their support") {
  EmbeddedPoints embedded;
  embedded.add_row(embedded.add_support(std::array{0, 1, 2}), std::array{0.5, 0.75, -0.25});
  std::vector<Site> sites(4);
  for (int32_t p = 0; p < 3; ++p) sites[p].index = p;
  sites[3].kind = SiteKind::Embedded;
  const KinematicMap map(DofLayout::build({false, false, true, true}, {}), sites, embedded);
  CHECK_FALSE(map.is_prescribed(3));
  std::vector<Vec3> values{{1, 0, 0}, {0, 2, 0}, {0, 0, 4}, {7, 7, 7}};
  map.follow(values);
  CHECK(values[3] == Vec3{0.5, 1.5, -1.0});
  Configuration start{values, {}, {}}, moved;
  map.retract(start, std::vector<double>{1, 1, 1, 0, 0, 8}, 0.5, KinematicMap::Way::Straight, moved);
  CHECK(moved.point_position[3] == Vec3{0.75, 1.75, 2.25});
  std::vector<Vec3> x(4);
  map.positions(moved, x);
  CHECK(x[3] == moved.point_position[3]);
}

TEST_CASE("curvature of the map: the sum of force moments predicts the second derivative along rotations") {
  // For constant forces g the energy is g . x(dw); its second derivative along d is d^T K d, K = sym(M) -
  // tr(M) I.
  const MixedScene scene(4);
  RandomPoints random(5);
  const int n = scene.dof_count();
  for (int trial = 0; trial < 10; ++trial) {
    std::vector<Vec3> g(scene.map.site_count());
    for (Vec3& force : g) force = random.point();
    const std::vector<Vec3> x0 = scene.positions(scene.configuration);
    std::vector<Mat3> M(MixedScene::kBodies);
    for (int32_t i = 0; i < scene.map.site_count(); ++i) {
      const SiteJacobian jacobian = scene.map.jacobian(i, scene.configuration);
      if (jacobian.body >= 0) M[jacobian.body] += outer(g[i], jacobian.lever);
    }
    std::vector<double> direction(n);
    for (double& d : direction) d = random.uniform();
    double predicted = 0.0;
    for (int b = 0; b < MixedScene::kBodies; ++b) {
      const int32_t block = scene.map.layout().body_block[b];
      if (block == kNoBlock) continue;
      const Vec3 w{direction[3 * block + 3], direction[3 * block + 4], direction[3 * block + 5]};
      const Mat3 K = (M[b] + transpose(M[b])) * 0.5 - Mat3::identity() * trace(M[b]);
      predicted += dot(w, K * w);
    }
    const auto energy = [&](double t) {
      const std::vector<Vec3> x = scene.positions(scene.along(direction, t));
      double sum = 0.0;
      for (size_t i = 0; i < x.size(); ++i) sum += dot(g[i], x[i]);
      return sum;
    };
    const double second = differentiate_scalar(
        [&](double s) { return differentiate_scalar([&](double t) { return energy(s + t); }, 0.1); }, 0.1);
    CHECK(std::fabs(second - predicted) < 1e-7 * (1.0 + std::fabs(predicted)));
  }
}

TEST_CASE("retraction moves free parts only and keeps rotations orthogonal") {
  const MixedScene scene(6);
  std::vector<double> direction(scene.dof_count(), 0.7);
  const Configuration moved = scene.along(direction, 0.5);
  for (int p = 0; p < MixedScene::kPoints; ++p) {
    const Vec3 step = moved.point_position[p] - scene.configuration.point_position[p];
    CHECK(max_abs(step - (p < MixedScene::kFreePoints ? Vec3{0.35, 0.35, 0.35} : Vec3{})) < 1e-15);
  }
  CHECK(moved.body_position[2] == scene.configuration.body_position[2]);
  CHECK(moved.body_rotation[2] == scene.configuration.body_rotation[2]);
  for (int b = 0; b < 2; ++b) {
    const Mat3 turn = moved.body_rotation[b] * transpose(scene.configuration.body_rotation[b]);
    CHECK(max_abs(log_rotation(turn) - Vec3{0.35, 0.35, 0.35}) < 1e-14);
  }
}

TEST_CASE("positions of many sites are the same on several threads") {
  RandomPoints random(4);
  Configuration configuration;
  std::vector<Site> sites;
  const auto add = [&](SiteKind kind, int32_t index) {
    sites.push_back({.kind = kind, .index = index, .local = random.point(), .points = {}, .weights = {}});
  };
  for (int32_t p = 0; p < 9000; ++p) {
    configuration.point_position.push_back(random.point());
    add(SiteKind::Point, p);
  }
  for (int32_t b = 0; b < 3; ++b) {
    configuration.body_position.push_back(random.point());
    configuration.body_rotation.push_back(exp_rotation(random.point()));
    for (int k = 0; k < 5000; ++k) add(SiteKind::RigidPoint, b);
    for (int k = 0; k < 700; ++k) add(SiteKind::RigidDirection, b);
    for (int k = 0; k < 900; ++k) add(SiteKind::World, 0);
  }
  const KinematicMap map(DofLayout::build(std::vector<bool>(9000, false), {false, false, false}), sites);
  std::vector<Vec3> alone(sites.size()), shared(sites.size());
  map.positions(configuration, alone);
  ThreadPool pool(3);
  map.positions(configuration, shared, &pool);
  CHECK(shared == alone);
  CHECK(alone[8999] == configuration.point_position[8999]);
  CHECK(alone[13999] == configuration.body_position[0] + configuration.body_rotation[0] * sites[13999].local);
  CHECK(alone.back() == sites.back().local);
}
