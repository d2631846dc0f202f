// When friction counts as settled: limits by place, of all and between each two bodies.
#include <doctest/doctest.h>

#include <stark/contact/friction_limits.h>

using namespace stark;

namespace {

constexpr Vec3 kUp{0, 0, 1}, kDown{0, 0, -1};

FrictionLimit of_point(int32_t triangle, double limit, const Vec3& normal = kUp, int32_t group_b = 1) {
  const Contact contact{.key = {PairKind::PointTriangle, 3, triangle}, .group_a = 0, .group_b = group_b};
  return limit_of(contact, normal, limit);
}

/// Edge 2, of the points 10 and 11, with another, at a part of each.
FrictionLimit of_edges(int32_t second, double limit, double at_first = 0.5, double at_second = 0.5,
                       const Vec3& normal = kUp) {
  const Contact contact{.key = {PairKind::EdgeEdge, 2, second},
                        .point_count = 4,
                        .side_a_count = 2,
                        .group_a = 0,
                        .group_b = 1,
                        .sites = {10, 11, 20 + second, 21 + second},
                        .weights = {1.0 - at_first, at_first, at_second - 1.0, -at_second}};
  return limit_of(contact, normal, limit);
}

}  // namespace

TEST_CASE("a contact that a valley splits has the limit that it had") {
  const LimitComparison split({of_point(7, 5.0)}, {of_point(7, 3.0), of_point(8, 2.0)});
  CHECK(split.total().largest_change == 0.0);
  CHECK(split.total().largest_limit == 5.0);
  CHECK(split.is_settled());
  // As is one that slides to the next triangle; not one that goes to another body or another edge.
  CHECK(LimitComparison({of_point(7, 5.0)}, {of_point(8, 5.0)}).is_settled());
  CHECK_FALSE(LimitComparison({of_point(7, 5.0)}, {of_point(8, 5.0, kUp, 2)}).is_settled());
  CHECK_FALSE(LimitComparison({of_edges(7, 5.0)}, {of_edges(8, 5.0)}).is_settled());
}

TEST_CASE("a contact at the end of an edge is one of the point there") {
  // Edges 7 and 8 share the point 28, where edge 2 crosses them.
  CHECK(LimitComparison({of_edges(7, 5.0, 0.4, 0.9999)}, {of_edges(8, 5.0, 0.4, 1e-6)}).is_settled());
  CHECK(
      LimitComparison({of_edges(7, 5.0, 0.4, 1.0)}, {of_edges(7, 2.0, 0.4, 1.0), of_edges(8, 3.0, 0.4, 0.0)})
          .is_settled());
  CHECK_FALSE(LimitComparison({of_edges(7, 5.0, 0.4, 0.98)}, {of_edges(8, 5.0, 0.4, 0.02)}).is_settled());
  // Seen from the point, whichever side of the contact it is on: above are 5 N, below 2 N.
  const Contact point{.key = {PairKind::PointTriangle, 28, 3}, .group_a = 1, .group_b = 0};
  CHECK(LimitComparison({limit_of(point, kDown, 5.0), limit_of(point, kUp, 2.0)},
                        {of_edges(7, 5.0, 0.4, 1.0), of_edges(8, 2.0, 0.4, 0.0, kDown)})
            .is_settled());
  // Where both end, contacts of either point are there: 5 N before, 2 + 3 N after.
  CHECK(
      LimitComparison({of_edges(7, 5.0, 1.0, 1.0)}, {of_edges(9, 2.0, 1.0, 0.3), limit_of(point, kDown, 3.0)})
          .is_settled());
  CHECK(damped_limits({of_edges(7, 5.0, 1.0, 1.0)},
                      {of_edges(9, 2.0, 1.0, 0.3), limit_of(point, kDown, 2.0)}) ==
        std::vector<double>{2.0 * 4.5 / 4.0, 2.0 * 4.5 / 4.0});
}

TEST_CASE("places meet in the middle, however their contacts share them") {
  // 3 + 2 N after 5 N go on as they are, 4 N after 6 N as 5 N, and what is new stays.
  const std::vector<FrictionLimit> before{of_point(7, 5.0), of_edges(7, 6.0)};
  const std::vector<FrictionLimit> now{of_point(7, 3.0), of_point(8, 2.0), of_edges(7, 4.0),
                                       of_edges(8, 1.0)};
  CHECK(damped_limits(before, now) == std::vector<double>{3.0, 2.0, 5.0, 1.0});
}

TEST_CASE("limits that go on in the same way go where they would add up to") {
  // Two places whose limits answer what they differ by from 60 N and 30 N with a part of it.
  const auto shares = [](double answer, int refreshes) {
    const double first = 60.0, second = 30.0;
    std::vector<FrictionLimit> before{of_point(7, 90.0), of_edges(7, 44.0)};
    RefreshShares refresh;
    std::vector<double> found;
    for (int k = 0; k < refreshes; ++k) {
      const std::vector<FrictionLimit> now{of_point(7, first + answer * (before[0].limit - first)),
                                           of_edges(7, second + answer * (before[1].limit - second))};
      found.push_back(refresh.next(before, now, k < 3));
      const std::vector<double> damped = damped_limits(before, now, found.back());
      before = {of_point(7, damped[0]), of_edges(7, damped[1])};
    }
    found.push_back(before[0].limit);
    return found;
  };
  const std::vector<double> half = shares(0.5, 4);
  CHECK(half[2] == 1.0);
  CHECK(half[3] == doctest::Approx(2.0));
  CHECK(half[4] == doctest::Approx(60.0));
  // At most four times the way; and halfway where limits go back and forth.
  const std::vector<double> most = shares(0.9, 5);
  CHECK(most[3] == 4.0);
  CHECK(most[4] == 4.0);
  CHECK(most[5] - 60.0 == doctest::Approx(30.0 * 0.9 * 0.9 * 0.9 * 0.6 * 0.6));
  const std::vector<double> back = shares(-0.8, 4);
  CHECK(back[2] == 1.0);
  CHECK(back[3] == 0.5);
}

TEST_CASE("a share of the way leaves half of what a place has now") {
  CHECK(damped_limits({of_point(7, 9.0)}, {of_point(7, 3.0)}, 2.0) == std::vector<double>{1.5});
  CHECK(damped_limits({of_point(7, 4.0)}, {of_point(7, 3.0)}, 2.0) == std::vector<double>{2.0});
}

TEST_CASE("the layers on both sides of a point are two places") {
  const LimitComparison moved({of_point(7, 5.0), of_point(9, 3.0, kDown)},
                              {of_point(7, 4.0), of_point(9, 4.0, kDown)});
  CHECK(moved.total().largest_change == doctest::Approx(1.0));
  CHECK_FALSE(moved.is_settled());
  CHECK(LimitComparison({of_point(7, 5.0), of_point(9, 3.0, kDown)},
                        {of_point(8, 5.0), of_point(9, 3.0, kDown)})
            .is_settled());
}

TEST_CASE("layers of a folded body have the sides that they have, whichever point names a contact") {
  // Points 3, 4, 5 of one body lie above each other: 2 N between the lower two, 7 N between the upper two.
  const auto of_vertices = [](int32_t upper, int32_t lower, double limit) {
    const Contact contact{.key = {PairKind::PointTriangle, upper, 100 + lower},
                          .group_a = 0,
                          .group_b = 0,
                          .sites = {upper, lower},
                          .weights = {1.0, -1.0}};
    return limit_of(contact, upper > lower ? kUp : kDown, limit);
  };
  const std::vector<FrictionLimit> before{of_vertices(4, 3, 2.0), of_vertices(5, 4, 7.0)};
  CHECK(LimitComparison(before, {of_vertices(3, 4, 2.0), of_vertices(5, 4, 7.0)}).total().largest_change ==
        0.0);
  CHECK(LimitComparison(before, {of_vertices(4, 3, 2.0), of_vertices(4, 5, 7.0)}).total().largest_change ==
        0.0);
  CHECK(LimitComparison(before, {of_vertices(3, 4, 2.0), of_vertices(4, 5, 7.0)}).total().largest_change ==
        0.0);
  CHECK(LimitComparison(before, {of_vertices(4, 3, 3.0), of_vertices(4, 5, 6.0)}).total().largest_change ==
        doctest::Approx(1.0));
  // Half of the way, whatever the name.
  const std::vector<FrictionLimit> now{of_vertices(3, 4, 4.0), of_vertices(4, 5, 5.0)};
  CHECK(damped_limits(before, now) == std::vector<double>{3.0, 6.0});
}

TEST_CASE("limits settle to 0.1 % of the largest and to 1 % of those between the same bodies") {
  const auto change = [](double of_first, double of_second) {
    return LimitComparison({of_point(7, 100.0), of_point(7, 1.0, kUp, 2)},
                           {of_point(7, 100.0 + of_first), of_point(7, 1.0 + of_second, kUp, 2)});
  };
  CHECK(change(0.09, 0.009).is_settled());
  CHECK_FALSE(change(0.11, 0.0).is_settled());
  CHECK_FALSE(change(0.0, 0.011).is_settled());
  CHECK(change(0.09, 0.009).total().largest_change == doctest::Approx(0.09));
  // Contacts that come and go.
  CHECK_FALSE(LimitComparison({}, {of_point(7, 1.0)}).is_settled());
  CHECK_FALSE(LimitComparison({of_point(7, 1.0)}, {}).is_settled());
  CHECK(LimitComparison({}, {}).is_settled());
}
