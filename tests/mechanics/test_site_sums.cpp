#include <doctest/doctest.h>

#include <random>
#include <vector>

#include <stark/mechanics/site_sums.h>

using namespace stark;

TEST_CASE("Sums by site start at zero each time and visit all that was added, in order") {
  std::mt19937 random(5);
  SiteSums sums;
  for (const size_t count : {size_t{3000}, size_t{3000}, size_t{1}, size_t{700}, size_t{700}}) {
    std::uniform_int_distribution<int32_t> site(0, static_cast<int32_t>(count) - 1);
    std::vector<int32_t> sites;
    for (int k = 0; k < 4; ++k) sites.push_back(site(random));
    std::vector<Vec3> expected(count);
    sums.begin(count);
    sums.use(sites);
    for (const int32_t i : sites) {
      sums.values()[i] += Vec3{1.0, 0.1 * i, -2.0};
      expected[i] += Vec3{1.0, 0.1 * i, -2.0};
    }
    std::vector<Vec3> visited(count);
    int32_t before = -1;
    size_t visits = 0;
    sums.for_each([&](int32_t i, const Vec3& value) {
      CHECK(i > before);
      before = i;
      visited[i] = value;
      ++visits;
    });
    CHECK(visited == expected);
    if (count == 3000) CHECK(visits <= 4 * 512);
  }
  sums.begin(0);
  sums.for_each([](int32_t, const Vec3&) { FAIL("there are no sites"); });
}
