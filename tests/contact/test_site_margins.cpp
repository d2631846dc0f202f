// Margins of sites, against the same rules site by site.
#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <numeric>

#include <stark/base/rotation.h>
#include <stark/contact/site_margins.h>
#include <stark/geometry/shapes.h>
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

TEST_CASE("places are those of the base but for marked sites, whose groups get new bounds") {
  const SiteMargins margins(scattered_mesh());
  RandomPoints random(3);
  std::vector<Vec3> first, x;
  for (int32_t i = 0; i < kSites; ++i) first.push_back(random.point()), x.push_back(random.point());
  std::vector<uint8_t> marked(kSites, 1);
  const std::vector<Bounds> no_bounds(2);
  SitePlaces base{.bounds = no_bounds}, out{.bounds = no_bounds};
  margins.place({}, marked, first, 1, base);
  std::ranges::fill(marked, 0);
  marked[kSites - 3] = 1;
  margins.place(base, marked, x, 2, out);
  margins.place(out, marked, x, 2, out);
  Bounds bounds[2];
  for (int32_t i = 0; i < kSites; ++i) {
    if (!is_on_surface(i)) continue;
    const Vec3 expected = i == kSites - 3 ? x[i] : first[i];
    CHECK(out.x[i] == expected);
    bounds[i < kSites / 2 ? 0 : 1].add(expected);
  }
  for (int group = 0; group < 2; ++group) {
    CHECK(out.bounds[group].low == bounds[group].low);
    CHECK(out.bounds[group].high == bounds[group].high);
  }
}

TEST_CASE("pieces are placed as a whole, whatever they were placed at before") {
  SurfaceMesh mesh;
  const TriangleMesh ball = make_icosphere(1.0, 3);
  std::vector<Vec3> start;
  std::vector<std::vector<int32_t>> sites(5);
  for (int32_t group = 0; group < 5; ++group) {
    for (const Vec3& v : ball.vertices) {
      sites[group].push_back(mesh.vertex_count);
      mesh.points.push_back(mesh.vertex_count++);
      mesh.vertex_group.push_back(group);
      start.push_back(v + Vec3{3.0 * group, 0.0, 0.0});
    }
    mesh.frames.push_back(find_frame(sites[group], start));
    REQUIRE(mesh.frames.back().has_value());
  }
  const SiteMargins margins(mesh);
  RandomPoints random(5);
  SitePlaces lists[2];
  std::vector<Vec3> where[2];
  const std::vector<Vec3>* x = &start;
  std::vector<uint8_t> marked(start.size(), 1);
  std::vector<Vec3> next;
  for (uint64_t version = 1; version < 60; ++version) {
    // From the list or from the other one, as trial points come and go.
    const size_t to = random.uniform(0.0, 1.0) < 0.5 ? 0 : 1;
    const size_t from = version == 1 || random.uniform(0.0, 1.0) < 0.5 ? to : 1 - to;
    if (where[from].empty()) std::ranges::fill(marked, 1);
    next.clear();
    for (const Vec3& v : *x) next.push_back(v + random.point() * 0.01);
    lists[to].bounds.resize(5);
    where[to] = where[from].empty() ? next : where[from];
    for (size_t i = 0; i < next.size(); ++i)
      if (marked[i] != 0) where[to][i] = next[i];
    margins.place(lists[from], marked, next, version, lists[to]);
    CHECK(lists[to].x == where[to]);
    for (int32_t group = 0; group < 5; ++group) {
      Bounds expected;
      for (const int32_t site : sites[group]) expected.add(where[to][site]);
      CHECK(lists[to].bounds[group].low == expected.low);
      CHECK(lists[to].bounds[group].high == expected.high);
      const uint8_t is_marked = random.uniform(0.0, 1.0) < 0.4 ? 1 : 0;
      for (const int32_t site : sites[group]) marked[site] = is_marked;
    }
  }
}

TEST_CASE("what moves as one piece is marked as a whole, before one of its sites leaves its margin") {
  SurfaceMesh mesh;
  std::vector<Vec3> base;
  const TriangleMesh ball = make_icosphere(0.1, 2);
  for (int32_t g = 0; g < 2; ++g) {
    const auto first = static_cast<int32_t>(base.size());
    for (const Index3& t : ball.triangles) {
      mesh.triangles.push_back({first + t[0], first + t[1], first + t[2]});
      mesh.triangle_group.push_back(g);
    }
    for (const Vec3& p : ball.vertices) base.push_back(p + Vec3{0.3 * g, 0.0, 0.0});
    mesh.vertex_group.resize(base.size(), g);
  }
  mesh.vertex_count = static_cast<int32_t>(base.size());
  const auto half = static_cast<int32_t>(base.size() / 2);
  std::vector<int32_t> sites(half);
  std::iota(sites.begin(), sites.end(), 0);
  mesh.frames = {find_frame(sites, base), std::nullopt};
  const std::vector<double> margin{0.01, 0.01};
  const SiteMargins margins(mesh);
  CHECK(margins.site_count() == 2 * half);
  // Both turn about their lowest points, by as much.
  const auto turned = [&](double angle) {
    std::vector<Vec3> x = base;
    for (int32_t i = 0; i < 2 * half; ++i) {
      const Vec3 foot{i < half ? 0.0 : 0.3, 0.0, -0.1};
      x[i] = foot + exp_rotation({0.0, angle, 0.0}) * (base[i] - foot);
    }
    return x;
  };
  std::vector<uint8_t> marks;
  for (const double angle : {0.01, 0.03, 0.049, 0.06, 0.2}) {
    const std::vector<Vec3> x = turned(angle);
    const int64_t count = margins.mark_beyond(1.0, margin, base, x, marks);
    CHECK(count == std::ranges::count(marks, 1));
    const auto in_piece = std::count(marks.begin(), marks.begin() + half, 1);
    const auto alone = std::count(marks.begin() + half, marks.end(), 1);
    CHECK((in_piece == 0 || in_piece == half));
    if (alone > 0) CHECK(in_piece == half);
    CHECK(margins.cover(margin, base, x) == (in_piece == 0 && alone == 0));
    std::vector<uint8_t> leaving, more(base.size(), 0);
    CHECK(margins.mark_leaving(margin, base, base, x, leaving) == count);
    CHECK(margins.mark_leaving(margin, base, x, base, leaving) == count);
    CHECK(leaving == marks);
    CHECK(margins.mark_more(margin, base, x, more) == count);
    CHECK(margins.mark_more(margin, base, x, more) == 0);
    CHECK(more == marks);
  }
}
