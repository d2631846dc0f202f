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
  const SiteMargins margins(scattered_mesh(), std::vector<double>{0.1, 0.2});
  CHECK(margins.site_count() == 1000);
  CHECK(margins(0) == 0.1);
  CHECK(margins(kSites - 3) == 0.2);
  RandomPoints random(1);
  std::vector<Vec3> base;
  for (int32_t i = 0; i < kSites; ++i) base.push_back(random.point());
  std::vector<Vec3> x = base;
  CHECK(margins.cover(base, x));
  for (const int32_t site : {0, 1, 2, 511, 512, 749, 750, 1023, kSites - 2, kSites - 1}) {
    const double margin = site < kSites / 2 ? 0.1 : 0.2;
    const Vec3 at = x[site];
    x[site] = at + Vec3{0.0, 0.999 * margin, 0.0};
    CHECK(margins.cover(base, x));
    x[site] = at + Vec3{0.0, 0.0, 1.001 * margin};
    CHECK(margins.cover(base, x) == !is_on_surface(site));
    x[site] = {std::numeric_limits<double>::quiet_NaN(), 0.0, 0.0};
    CHECK(margins.cover(base, x) == !is_on_surface(site));
    x[site] = at;
  }
}

TEST_CASE("marked are the sites beyond a part of their margin, and those that leave it on a way") {
  const std::vector<double> margin{0.1, 0.2};
  const SiteMargins margins(scattered_mesh(), margin);
  RandomPoints random(2);
  std::vector<Vec3> base, x0, x1;
  for (int32_t i = 0; i < kSites; ++i) {
    base.push_back(random.point());
    x0.push_back(base.back() + random.point() * 0.15);
    x1.push_back(base.back() + random.point() * 0.15);
  }
  std::vector<uint8_t> beyond, leaving;
  const int64_t beyond_count = margins.mark_beyond(0.5, base, x0, beyond);
  const int64_t leaving_count = margins.mark_leaving(base, x0, x1, leaving);
  int64_t expected_beyond = 0, expected_leaving = 0;
  for (int32_t i = 0; i < kSites; ++i) {
    const double most = margin[i < kSites / 2 ? 0 : 1];
    const double first = norm(x0[i] - base[i]), second = norm(x1[i] - base[i]);
    const bool is_beyond = is_on_surface(i) && first > 0.5 * most;
    const bool leaves = is_on_surface(i) && (first > most || second > most);
    CHECK(beyond[i] == (is_beyond ? 1 : 0));
    CHECK(leaving[i] == (leaves ? 1 : 0));
    expected_beyond += is_beyond ? 1 : 0;
    expected_leaving += leaves ? 1 : 0;
  }
  CHECK(beyond_count == expected_beyond);
  CHECK(leaving_count == expected_leaving);
  CHECK(beyond_count > 100);
  CHECK(leaving_count < margins.site_count());
}
