// Pairs of embedded sites: which blocks they couple, and the chain rule against a dense product.
#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <set>

#include <stark/mechanics/embedded_assembly.h>
#include <support/mixed_scene.h>
#include <support/random_points.h>

using namespace stark;
using namespace stark::test;

namespace {

/// Five points, the last one prescribed; sites 5 and 6 embedded in {0, 1, 2} and {2, 3, 4}.
KinematicMap two_supports() {
  EmbeddedPoints embedded;
  embedded.add_row(embedded.add_support(std::array{0, 1, 2}), std::array{0.5, 0.25, 0.25});
  embedded.add_row(embedded.add_support(std::array{2, 3, 4}), std::array{0.2, 0.3, 0.5});
  std::vector<Site> sites(7);
  for (int32_t p = 0; p < 5; ++p) sites[p].index = p;
  for (const int32_t k : {0, 1}) {
    sites[5 + k].kind = SiteKind::Embedded;
    sites[5 + k].index = k;
  }
  return {DofLayout::build({false, false, false, false, true}, {}), sites, embedded};
}

}  // namespace

TEST_CASE("supports of a stencil couple all of their blocks, each pair once") {
  const KinematicMap map = two_supports();
  SupportPairs pairs(map);
  for (int k = 0; k < 3; ++k) pairs.add(std::array{5, 6, 3});
  std::vector<std::pair<int32_t, int32_t>> found;
  pairs.append_to(found);
  const std::set<std::pair<int32_t, int32_t>> unique(found.begin(), found.end());
  CHECK(unique == std::set<std::pair<int32_t, int32_t>>{{0, 1}, {0, 2}, {1, 2}, {0, 3}, {1, 3}, {2, 3}});
}

TEST_CASE("blocks of pairs of sites go to the points as a congruence") {
  const KinematicMap map = two_supports();
  RandomPoints random(7);
  // A symmetric matrix of the three sites 5, 6 and 3.
  std::array<std::array<double, 9>, 9> H{};
  for (int i = 0; i < 9; ++i)
    for (int j = 0; j <= i; ++j) H[i][j] = H[j][i] = random.uniform();
  const std::array<int32_t, 3> sites{5, 6, 3};
  const double W[3][4] = {{0.5, 0.25, 0.25, 0.0}, {0.0, 0.0, 0.2, 0.3}, {0.0, 0.0, 0.0, 1.0}};
  const auto block = [&](int p, int q) {
    Mat3 result;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) result(i, j) = H[3 * p + i][3 * q + j];
    return result;
  };
  SitePairs pairs;
  for (int p = 0; p < 3; ++p)
    for (int q = p; q < 3; ++q)
      if (p < 2) pairs.add(sites[p], sites[q], block(p, q));
  BlockMatrix matrix;
  matrix.pattern = BlockPattern::from_pairs(4, {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}});
  matrix.set_zero();
  pairs.scatter(map, {}, matrix);
  CHECK(pairs.empty());
  for (int a = 0; a < 4; ++a)
    for (int b = a; b < 4; ++b) {
      Mat3 expected;
      for (int p = 0; p < 3; ++p)
        for (int q = 0; q < 3; ++q)
          if (p < 2 || q < 2) expected += block(p, q) * (W[p][a] * W[q][b]);
      const double* values = matrix.values.data() + 9 * matrix.pattern.slot(a, b);
      for (int c = 0; c < 9; ++c) CHECK(std::fabs(values[c] - expected.m[c]) < 1e-15);
    }
}
