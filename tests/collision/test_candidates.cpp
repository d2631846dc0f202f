// The table of allowed pairs and the list of candidates.
#include <doctest/doctest.h>

#include <stark/base/error.h>
#include <stark/collision/candidates.h>

using namespace stark;

TEST_CASE("pair filter: symmetric, with and without self, bounds checked") {
  PairFilter filter(4, true, false);
  for (int32_t a = 0; a < 4; ++a) {
    for (int32_t b = 0; b < 4; ++b) CHECK(filter.allowed(a, b) == (a != b));
  }
  filter.set(3, 1, false);
  filter.set(2, 2, true);
  CHECK_FALSE(filter.allowed(1, 3));
  CHECK_FALSE(filter.allowed(3, 1));
  CHECK(filter.allowed(2, 2));
  CHECK(filter.allowed(0, 3));
  CHECK_THROWS_AS(filter.set(0, 4, true), InvalidArgument);
  CHECK_THROWS_AS(filter.set(-1, 0, true), InvalidArgument);
  CHECK_THROWS_AS(PairFilter(-1), InvalidArgument);
}

TEST_CASE("pair filter: vertices are kept from a group with all that they are part of") {
  PairFilter filter(3);
  CHECK_FALSE(filter.has_exclusions());
  filter.exclude(7, 2);
  filter.exclude(7, 2);
  CHECK(filter.has_exclusions());
  CHECK(filter.excluded(7, 2));
  CHECK_FALSE(filter.excluded(7, 1));
  CHECK_FALSE(filter.excluded(6, 2));
  CHECK_FALSE(filter.excluded(1000, 2));
  const std::array<int32_t, 3> with{5, 6, 7}, without{4, 5, 6}, other{0, 1, 2};
  CHECK(filter.excluded(with, 0, other, 2));
  CHECK(filter.excluded(other, 2, with, 0));
  CHECK_FALSE(filter.excluded(with, 0, other, 1));
  CHECK_FALSE(filter.excluded(without, 0, other, 2));
  CHECK_THROWS_AS(filter.exclude(-1, 0), InvalidArgument);
  CHECK_THROWS_AS(filter.exclude(0, 3), InvalidArgument);
}

TEST_CASE("pair filter: vertices are kept from some of their own group, with all that both are part of") {
  PairFilter filter(2);
  filter.exclude_from(7, {2, 3});
  CHECK(filter.has_exclusions());
  CHECK_FALSE(filter.excluded(7, 0));
  const std::array<int32_t, 3> with{5, 6, 7}, near{1, 2, 9}, far{0, 1, 9};
  CHECK(filter.excluded(with, 0, near, 0));
  CHECK(filter.excluded(near, 0, with, 0));
  CHECK_FALSE(filter.excluded(with, 0, far, 0));
  CHECK_FALSE(filter.excluded(far, 0, near, 0));
  CHECK_THROWS_AS(filter.exclude_from(-1, {}), InvalidArgument);
}

TEST_CASE("neighbours along a rod: points and edges are kept from the edges that end at them") {
  PairFilter filter(1);
  CHECK_FALSE(filter.are_neighbours(4, {5, 6}));
  filter.set_neighbours(4, 6);
  CHECK(filter.has_neighbours());
  CHECK_FALSE(filter.has_exclusions());
  CHECK(filter.are_neighbours(4, {5, 6}));
  CHECK(filter.are_neighbours(4, {6, 7}));
  CHECK(filter.are_neighbours(6, {3, 4}));
  CHECK_FALSE(filter.are_neighbours(4, {7, 8}));
  CHECK_FALSE(filter.are_neighbours(1000, {6, 7}));
  CHECK(filter.are_neighbours(Index2{3, 4}, Index2{6, 7}));
  CHECK(filter.are_neighbours(Index2{6, 7}, Index2{3, 4}));
  CHECK_FALSE(filter.are_neighbours(Index2{3, 4}, Index2{7, 8}));
  CHECK_THROWS_AS(filter.set_neighbours(-1, 0), InvalidArgument);
}

TEST_CASE("candidate list: size and clear") {
  CandidateList list;
  list[PairKind::PointTriangle] = {{0, 1}};
  list[PairKind::EdgeEdge] = {{0, 1}, {0, 2}};
  list[PairKind::PointEdge] = {{3, 1}};
  list[PairKind::PointPoint] = {{3, 4}};
  CHECK(list.size() == 5);
  list.clear();
  CHECK(list.size() == 0);
  CHECK(list == CandidateList{});
}
