// Sum of element Hessians into the block matrix against entry-by-entry sums.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <numeric>
#include <random>

#include <stark/mechanics/element_scatter.h>
#include <stark/mechanics/element_view.h>

using namespace stark;
using symbolic::kLanes;

namespace {

constexpr int32_t kPoints = 9;
constexpr int32_t kPinned = 4;

KinematicMap point_map() {
  std::vector<bool> pinned(kPoints, false);
  pinned[kPinned] = true;
  std::vector<Site> sites;
  for (int32_t v = 0; v < kPoints; ++v)
    sites.push_back({.kind = SiteKind::Point, .index = v, .local = {}, .points = {}, .weights = {}});
  return {DofLayout::build(pinned, {}), sites};
}

/// Random stencils of distinct points, in any order, so that blocks are transposed, too.
std::vector<int32_t> random_stencils(int nodes, int64_t count, std::mt19937& random) {
  std::vector<int32_t> stencils;
  std::array<int32_t, kPoints> points;
  for (int32_t v = 0; v < kPoints; ++v) points[v] = v;
  for (int64_t e = 0; e < count; ++e) {
    std::shuffle(points.begin(), points.end(), random);
    stencils.insert(stencils.end(), points.begin(), points.begin() + nodes);
  }
  return stencils;
}

/// Random stencils in which a point may be there several times.
std::vector<int32_t> repeated_stencils(int nodes, int64_t count, std::mt19937& random) {
  std::vector<int32_t> stencils(nodes * count);
  for (int32_t& point : stencils) point = std::uniform_int_distribution<int32_t>(0, kPoints - 1)(random);
  return stencils;
}

/// Every free point with every other.
BlockPattern full_pattern() {
  std::vector<std::pair<int32_t, int32_t>> all;
  for (int32_t a = 0; a < kPoints - 1; ++a)
    for (int32_t b = a + 1; b < kPoints - 1; ++b) all.emplace_back(a, b);
  return BlockPattern::from_pairs(kPoints - 1, all);
}

/// Each slot where it is.
std::vector<int64_t> own_slots(const BlockPattern& pattern) {
  std::vector<int64_t> slot_of(pattern.slot_count());
  std::iota(slot_of.begin(), slot_of.end(), int64_t{0});
  return slot_of;
}

}  // namespace

TEST_CASE("scatter adds what the entries of each lane are") {
  std::mt19937 random(7);
  const KinematicMap map = point_map();
  const BlockPattern pattern = full_pattern();
  const std::vector<int64_t> slot_of = own_slots(pattern);

  for (int nodes = 1; nodes <= 8; ++nodes)
    for (const int64_t count : {int64_t{1}, int64_t{3}, int64_t{4}, int64_t{5}, int64_t{kLanes}}) {
      const int n = 3 * nodes;
      const std::vector<int32_t> stencils = random_stencils(nodes, count, random);
      std::vector<double> out((1 + n + n * (n + 1) / 2) * kLanes);
      for (double& value : out) value = std::uniform_real_distribution<double>(-1.0, 1.0)(random);

      BlockMatrix matrix;
      matrix.pattern = pattern;
      matrix.set_zero();
      scatter_hessians(out.data() + (1 + n) * kLanes, nodes, count,
                       find_pair_places(map, stencils, nodes, pattern).data(), slot_of, matrix);

      BlockMatrix expected;
      expected.pattern = pattern;
      expected.set_zero();
      for (int64_t l = 0; l < count; ++l) {
        const ElementView element(out.data(), n, static_cast<int>(l));
        for (int p = 0; p < nodes; ++p)
          for (int q = p; q < nodes; ++q) {
            const int32_t a = map.point_block(stencils[l * nodes + p]),
                          b = map.point_block(stencils[l * nodes + q]);
            if (a == kNoBlock || b == kNoBlock) continue;
            const Mat3 H = a <= b ? element.point_hessian(p, q) : transpose(element.point_hessian(p, q));
            for (int c = 0; c < 9; ++c)
              expected.values[9 * pattern.slot(std::min(a, b), std::max(a, b)) + c] += H.m[c];
          }
      }
      for (size_t k = 0; k < expected.values.size(); ++k)
        CHECK(matrix.values[k] == doctest::Approx(expected.values[k]).epsilon(1e-14));
    }
}

TEST_CASE("gradients of lanes are added to their blocks, those of prescribed nodes are left out") {
  std::mt19937 random(8);
  const KinematicMap map = point_map();
  for (int nodes = 1; nodes <= 8; ++nodes)
    for (const int64_t count : {int64_t{1}, int64_t{3}, int64_t{4}, int64_t{5}, int64_t{kLanes}}) {
      const std::vector<int32_t> stencils = random_stencils(nodes, count, random);
      std::vector<double> lanes(3 * nodes * kLanes);
      for (double& value : lanes) value = std::uniform_real_distribution<double>(-1.0, 1.0)(random);
      std::vector<double> padded(4 * (kPoints - 1), 1.0), expected = padded;
      scatter_gradients(lanes.data(), nodes, count, find_node_blocks(map, stencils).data(), padded.data());
      for (int p = 0; p < nodes; ++p)
        for (int64_t l = 0; l < count; ++l)
          if (const int32_t block = map.point_block(stencils[l * nodes + p]); block != kNoBlock)
            for (int c = 0; c < 3; ++c) expected[4 * block + c] += lanes[(3 * p + c) * kLanes + l];
      CHECK(padded == expected);
    }
}

TEST_CASE("a point that an element has twice gets both orders of the pair") {
  // The energy of two points at one place is a function of that place: v.H v of the sum is what H says of
  // the same displacement of both. One order was left out, so that Newton's method had a wrong stiffness.
  std::mt19937 random(11);
  const KinematicMap map = point_map();
  const BlockPattern pattern = full_pattern();
  const std::vector<int64_t> slot_of = own_slots(pattern);
  for (int nodes = 2; nodes <= 8; ++nodes) {
    const int n = 3 * nodes;
    const std::vector<int32_t> stencils = repeated_stencils(nodes, kLanes, random);
    std::vector<double> out((1 + n + n * (n + 1) / 2) * kLanes);
    for (double& value : out) value = std::uniform_real_distribution<double>(-1.0, 1.0)(random);
    const std::vector<PairPlace> places = find_pair_places(map, stencils, nodes, pattern);
    BlockMatrix full, diagonal, expected;
    for (BlockMatrix* matrix : {&full, &diagonal, &expected}) {
      matrix->pattern = pattern;
      matrix->set_zero();
    }
    for (BlockMatrix* matrix : {&full, &diagonal})
      scatter_hessians(out.data() + (1 + n) * kLanes, nodes, kLanes, places.data(), slot_of, *matrix,
                       matrix == &full ? ScatterPairs::All : ScatterPairs::Diagonal);
    for (int64_t l = 0; l < kLanes; ++l) {
      const ElementView element(out.data(), n, static_cast<int>(l));
      for (int p = 0; p < nodes; ++p)
        for (int q = 0; q < nodes; ++q) {
          const int32_t a = map.point_block(stencils[l * nodes + p]),
                        b = map.point_block(stencils[l * nodes + q]);
          if (a == kNoBlock || b == kNoBlock || a > b) continue;
          for (int c = 0; c < 9; ++c)
            expected.values[9 * pattern.slot(a, b) + c] += element.point_hessian(p, q).m[c];
        }
    }
    for (int32_t i = 0; i < kPoints - 1; ++i)
      for (int64_t slot = pattern.row_start[i]; slot < pattern.row_start[i + 1]; ++slot)
        for (int k = 0; k < 9; ++k) {
          const double exact = expected.values[9 * slot + k];
          CHECK(full.values[9 * slot + k] == doctest::Approx(exact).epsilon(1e-13));
          CHECK(diagonal.values[9 * slot + k] ==
                doctest::Approx(pattern.column[slot] == i ? exact : 0.0).epsilon(1e-13));
        }
  }
}

TEST_CASE("of pairs on the diagonal nothing else is added") {
  std::mt19937 random(9);
  const KinematicMap map = point_map();
  const std::vector<int32_t> stencils = random_stencils(4, kLanes, random);
  const BlockPattern pattern = full_pattern();
  const std::vector<int64_t> slot_of = own_slots(pattern);
  std::vector<double> upper(12 * 13 / 2 * kLanes);
  for (double& value : upper) value = std::uniform_real_distribution<double>(-1.0, 1.0)(random);
  const std::vector<PairPlace> places = find_pair_places(map, stencils, 4, pattern);
  BlockMatrix full, diagonal;
  for (BlockMatrix* matrix : {&full, &diagonal}) {
    matrix->pattern = pattern;
    matrix->set_zero();
    scatter_hessians(upper.data(), 4, kLanes, places.data(), slot_of, *matrix,
                     matrix == &full ? ScatterPairs::All : ScatterPairs::Diagonal);
  }
  for (int32_t i = 0; i < kPoints - 1; ++i)
    for (int64_t slot = pattern.row_start[i]; slot < pattern.row_start[i + 1]; ++slot)
      for (int k = 0; k < 9; ++k)
        CHECK(diagonal.values[9 * slot + k] == (pattern.column[slot] == i ? full.values[9 * slot + k] : 0.0));
}
