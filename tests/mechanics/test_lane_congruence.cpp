// Hessians mapped lane by lane at once against the chain rule of single elements.
#include <doctest/doctest.h>

#include <stark/mechanics/congruence.h>
#include <stark/mechanics/lane_congruence.h>
#include <support/mixed_scene.h>

using namespace stark;
using namespace stark::test;
using symbolic::kLanes;

namespace {

/// Outputs of a kernel for a block of lanes, random, and sites of every lane.
struct RandomBlock {
  RandomBlock(const MixedScene& scene, int point_count, int lane_count, std::span<const int32_t> allowed,
              RandomPoints& random)
      : points(point_count), lanes(lane_count), n(3 * point_count) {
    out.resize(static_cast<size_t>(1 + n + n * (n + 1) / 2) * kLanes);
    for (double& value : out) value = random.uniform();
    for (int k = 0; k < lanes * points; ++k)
      sites.push_back(allowed[random.integer(0, static_cast<int>(allowed.size()) - 1)]);
    find_jacobians(scene);
  }

  void find_jacobians(const MixedScene& scene) {
    jacobians.assign(static_cast<size_t>(kLanes) * points, {});
    for (size_t k = 0; k < sites.size(); ++k)
      jacobians[k] = scene.map.jacobian(sites[k], scene.configuration);
  }
  const double* upper() const { return out.data() + (1 + n) * kLanes; }

  int points, lanes, n;
  AlignedVector<double> out;
  std::vector<int32_t> sites;
  std::vector<SiteJacobian> jacobians;
};

BlockMatrix empty_matrix(const MixedScene& scene) {
  const int blocks = scene.dof_count() / 3;
  std::vector<std::pair<int32_t, int32_t>> pairs;
  for (int i = 0; i < blocks; ++i)
    for (int j = i; j < blocks; ++j) pairs.emplace_back(i, j);
  BlockMatrix matrix;
  matrix.pattern = BlockPattern::from_pairs(blocks, pairs);
  matrix.set_zero();
  return matrix;
}

BlockMatrix one_by_one(const MixedScene& scene, const RandomBlock& block) {
  BlockMatrix matrix = empty_matrix(scene);
  SitePairs none;
  for (int lane = 0; lane < block.lanes; ++lane) {
    const size_t first = static_cast<size_t>(lane) * block.points;
    add_mapped_hessian({block.out.data(), block.n, lane}, std::span(block.sites).subspan(first, block.points),
                       std::span(block.jacobians).subspan(first, block.points), matrix, none);
  }
  return matrix;
}

double largest_difference(const BlockMatrix& a, const BlockMatrix& b) {
  double worst = 0.0;
  for (size_t k = 0; k < a.values.size(); ++k) worst = std::max(worst, std::fabs(a.values[k] - b.values[k]));
  return worst;
}

/// Sites that points or bodies move, prescribed ones included.
std::vector<int32_t> plain_sites(const MixedScene& scene) {
  std::vector<int32_t> sites;
  for (int32_t i = 0; i < scene.map.site_count(); ++i)
    if (scene.map.site(i).kind != SiteKind::Barycentric && !scene.map.is_embedded(i)) sites.push_back(i);
  return sites;
}

}  // namespace

TEST_CASE("lanes of mapped Hessians are those of single elements, whatever moves their sites") {
  const MixedScene scene(11);
  RandomPoints random(12);
  const std::vector<int32_t> allowed = plain_sites(scene);
  LaneCongruence congruence;
  for (int trial = 0; trial < 200; ++trial) {
    const RandomBlock block(scene, random.integer(1, 8), random.integer(1, kLanes), allowed, random);
    BlockMatrix matrix = empty_matrix(scene);
    REQUIRE(congruence.begin(block.jacobians, block.points, block.lanes));
    congruence.multiply(block.upper());
    for (int lane = 0; lane < block.lanes; ++lane) congruence.scatter(lane, matrix, ScatterPairs::All);
    CHECK(largest_difference(matrix, one_by_one(scene, block)) < 1e-13);
  }
}

TEST_CASE("lanes of joints, whose sites are on the same two bodies in every lane") {
  const MixedScene scene(13);
  RandomPoints random(14);
  std::vector<int32_t> of_first, of_second;
  for (const int32_t i : plain_sites(scene)) {
    const Site& site = scene.map.site(i);
    if (site.kind != SiteKind::RigidPoint && site.kind != SiteKind::RigidDirection) continue;
    if (site.index == 0) of_first.push_back(i);
    if (site.index == 1) of_second.push_back(i);
  }
  LaneCongruence congruence;
  for (int trial = 0; trial < 50; ++trial) {
    RandomBlock block(scene, 8, random.integer(1, kLanes), of_first, random);
    for (size_t k = 0; k < block.sites.size(); ++k)
      if (k % 8 >= 4) block.sites[k] = of_second[k % of_second.size()];
    block.find_jacobians(scene);
    BlockMatrix matrix = empty_matrix(scene), diagonal = empty_matrix(scene);
    REQUIRE(congruence.begin(block.jacobians, block.points, block.lanes));
    congruence.multiply(block.upper());
    for (int lane = 0; lane < block.lanes; ++lane) {
      congruence.scatter(lane, matrix, ScatterPairs::All);
      congruence.scatter(lane, diagonal, ScatterPairs::Diagonal);
    }
    const BlockMatrix expected = one_by_one(scene, block);
    CHECK(largest_difference(matrix, expected) < 1e-13);
    const BlockPattern& pattern = expected.pattern;
    for (int32_t b = 0; b < pattern.block_count; ++b)
      for (int64_t slot = pattern.row_start[b]; slot < pattern.row_start[b + 1]; ++slot)
        for (int c = 0; c < 9; ++c) {
          const double wanted = pattern.column[slot] == b ? expected.values[9 * slot + c] : 0.0;
          CHECK(std::fabs(diagonal.values[9 * slot + c] - wanted) < 1e-13);
        }
  }
}

TEST_CASE("sites that follow several points are not for lanes") {
  const MixedScene scene(15);
  LaneCongruence congruence;
  int refused = 0;
  for (int32_t i = 0; i < scene.map.site_count(); ++i) {
    const SiteJacobian jacobian = scene.map.jacobian(i, scene.configuration);
    const bool follows_several = jacobian.is_embedded() || scene.map.site(i).kind == SiteKind::Barycentric;
    const bool is_refused = !congruence.begin({&jacobian, 1}, 1, 1);
    if (is_refused) CHECK(follows_several);
    refused += is_refused ? 1 : 0;
  }
  CHECK(refused > 0);
}
