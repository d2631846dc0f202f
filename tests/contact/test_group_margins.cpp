// Margins of groups: what they promise about the gaps that are left, and where they are no larger than the
// least ones.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include <stark/contact/group_margins.h>
#include <support/random_points.h>

using namespace stark;
using namespace stark::test;

namespace {

Bounds cube_at(const Vec3& centre, double half) {
  return {.low = centre - Vec3{half, half, half}, .high = centre + Vec3{half, half, half}};
}

double gap_of(const Bounds& a, const Bounds& b) {
  double squared = 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    const double gap = std::max({0.0, a.low[axis] - b.high[axis], b.low[axis] - a.high[axis]});
    squared += gap * gap;
  }
  return std::sqrt(squared);
}

}  // namespace

TEST_CASE("two bodies share the gap between them, whose spare part stays") {
  const GroupMargins margins(std::vector<double>{0.001, 0.002}, std::vector<double>{0.0005, 0.001});
  const std::vector<Bounds> bounds{cube_at({0.0, 0.0, 0.0}, 0.1), cube_at({0.0, 0.0, 0.253}, 0.1)};
  const std::vector<double> wide = margins.wide(PairFilter(2, true, false), bounds);
  CHECK(wide[0] == doctest::Approx(0.05 / 1.25 / 2.0));
  CHECK(wide[1] == doctest::Approx(0.05 / 1.25 / 2.0));
}

TEST_CASE(
    "with self-contact, next to others and far from all margins are the least, shared and limited ones") {
  const std::vector<double> distance{0.001, 0.001, 0.001}, least{0.0005, 0.0005, 0.0005};
  const GroupMargins margins(distance, least);
  PairFilter filter(3, true, false);
  filter.set(0, 0, true);
  const std::vector<Bounds> near{cube_at({0.0, 0.0, 0.0}, 0.1), cube_at({0.0, 0.0, 0.201}, 0.1),
                                 cube_at({9.0, 0.0, 0.0}, 0.1)};
  const std::vector<double> wide = margins.wide(filter, near);
  CHECK(wide[0] == least[0]);
  CHECK(wide[1] == least[1]);
  CHECK(wide[2] == doctest::Approx(0.2));
  filter.set(0, 1, false);
  CHECK(margins.wide(filter, near)[1] == doctest::Approx(0.2));
}

TEST_CASE("whatever stands where, groups that use their margins up stay farther apart than they act") {
  constexpr int kGroups = 24;
  RandomPoints random(5);
  int widened = 0;
  for (int round = 0; round < 50; ++round) {
    std::vector<double> distance, least;
    std::vector<Bounds> bounds;
    PairFilter filter(kGroups, true, false);
    for (int g = 0; g < kGroups; ++g) {
      distance.push_back(random.uniform(1e-4, 2e-3));
      least.push_back(0.5 * distance.back());
      bounds.push_back(cube_at(random.point(), random.uniform(0.01, 0.2)));
      if (g % 5 == 0) filter.set(g, g, true);
      if (g > 0 && g % 3 == 0) filter.set(g, g - 1, false);
    }
    const std::vector<double> wide = GroupMargins(distance, least).wide(filter, bounds);
    for (int a = 0; a < kGroups; ++a) {
      CHECK(wide[a] >= least[a]);
      widened += wide[a] > least[a] ? 1 : 0;
      if (filter.allowed(a, a)) CHECK(wide[a] == least[a]);
      for (int b = 0; b < a; ++b) {
        // Where both are the least ones, pairs near each other are in the list.
        if (!filter.allowed(a, b) || (wide[a] == least[a] && wide[b] == least[b])) continue;
        const double left = gap_of(bounds[a], bounds[b]) - wide[a] - wide[b];
        CHECK(left >= distance[a] + distance[b] + 0.249 * (wide[a] + wide[b]));
      }
    }
  }
  CHECK(widened > 100);
}
