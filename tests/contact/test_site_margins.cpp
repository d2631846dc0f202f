// Margins of sites, against the same rules site by site.
#include <doctest/doctest.h>

#include <cmath>
#include <limits>

#include <stark/contact/site_margins.h>
#include <support/random_points.h>

using namespace stark;
using namespace stark::test;

namespace {

constexpr int32_t kSites = 1500;  ///< more than are looked at at once

/// Every third site is of no surface; those of the second group have twice the margin.
SurfaceMesh scattered_mesh() {
  SurfaceMesh mesh;
  mesh.vertex_count = kSites;
  for (int32_t i = 0; i < kSites; ++i) {
    mesh.vertex_group.push_back(i < kSites / 2 ? 0 : 1);
    if (i % 3 != 2) mesh.points.push_back(i);
  }
  return mesh;
}

bool is_on_surface(int32_t site) { return site % 3 != 2; }

}  // namespace

TEST_CASE("sites are within their margins, or one of them is not") {
  const std::vector<double> margins_of_groups{0.1, 0.2};
  const SiteMargins margins(scattered_mesh());
  CHECK(margins.site_count() == 1000);
  RandomPoints random(1);
  std::vector<Vec3> base;
  for (int32_t i = 0; i < kSites; ++i) base.push_back(random.point());
  std::vector<Vec3> x = base;
  CHECK(margins.cover(margins_of_groups, base, x));
  for (const int32_t site : {0, 1, 2, 511, 512, 749, 750, 1023, kSites - 2, kSites - 1}) {
    const double margin = site < kSites / 2 ? 0.1 : 0.2;
    const Vec3 at = x[site];
    x[site] = at + Vec3{0.0, 0.999 * margin, 0.0};
    CHECK(margins.cover(margins_of_groups, base, x));
    x[site] = at + Vec3{0.6 * margin, 0.6 * margin, -0.6 * margin};
    CHECK(margins.cover(margins_of_groups, base, x) == !is_on_surface(site));
    x[site] = at + Vec3{0.0, 0.0, 1.001 * margin};
    CHECK(margins.cover(margins_of_groups, base, x) == !is_on_surface(site));
    x[site] = {std::numeric_limits<double>::quiet_NaN(), 0.0, 0.0};
    CHECK(margins.cover(margins_of_groups, base, x) == !is_on_surface(site));
    x[site] = at;
  }
}

TEST_CASE("marked are the sites beyond a part of their margin, and those that leave it on a way") {
  const std::vector<double> margin{0.1, 0.2};
  const SiteMargins margins(scattered_mesh());
  RandomPoints random(2);
  std::vector<Vec3> base, x0, x1;
  for (int32_t i = 0; i < kSites; ++i) {
    base.push_back(random.point());
    x0.push_back(base.back() + random.point() * 0.15);
    x1.push_back(base.back() + random.point() * 0.15);
  }
  std::vector<uint8_t> beyond, leaving, more(kSites, 0);
  more[0] = more[1] = 1;
  const int64_t beyond_count = margins.mark_beyond(0.5, margin, base, x0, beyond);
  const int64_t leaving_count = margins.mark_leaving(margin, base, x0, x1, leaving);
  const int64_t more_count = margins.mark_more(margin, base, x1, more);
  int64_t expected_beyond = 0, expected_leaving = 0, expected_more = 0;
  for (int32_t i = 0; i < kSites; ++i) {
    const double most = margin[i < kSites / 2 ? 0 : 1];
    const double first = norm(x0[i] - base[i]), second = norm(x1[i] - base[i]);
    const bool is_beyond = is_on_surface(i) && first > 0.5 * most;
    const bool leaves = is_on_surface(i) && (first > most || second > most);
    const bool is_more = is_on_surface(i) && second > most;
    CHECK(beyond[i] == (is_beyond ? 1 : 0));
    CHECK(leaving[i] == (leaves ? 1 : 0));
    CHECK(more[i] == (is_more || i < 2 ? 1 : 0));
    expected_beyond += is_beyond ? 1 : 0;
    expected_leaving += leaves ? 1 : 0;
    expected_more += is_more && i >= 2 ? 1 : 0;
  }
  CHECK(leaving_count == expected_leaving);
  CHECK(beyond_count == expected_beyond);
  CHECK(more_count == expected_more);
  CHECK(beyond_count > 100);
  CHECK(leaving_count < margins.site_count());
}

TEST_CASE("bounds are those of the groups with a marked site, and others stay as they are") {
  const SiteMargins margins(scattered_mesh());
  RandomPoints random(3);
  std::vector<Vec3> x;
  for (int32_t i = 0; i < kSites; ++i) x.push_back(random.point());
  const Bounds before{.low = {7.0, 7.0, 7.0}, .high = {8.0, 8.0, 8.0}};
  std::vector<Bounds> bounds{before, before}, expected{before, {}};
  for (int32_t i = kSites / 2; i < kSites; ++i)
    if (is_on_surface(i)) expected[1].add(x[i]);
  std::vector<uint8_t> marked(kSites, 0);
  marked[kSites - 3] = 1;
  margins.bound(x, marked, bounds);
  for (int group = 0; group < 2; ++group) {
    CHECK(bounds[group].low == expected[group].low);
    CHECK(bounds[group].high == expected[group].high);
  }
}
