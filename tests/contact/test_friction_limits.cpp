// When friction counts as settled: limits by place, of all and between each two bodies.
#include <doctest/doctest.h>

#include <stark/contact/friction_limits.h>

using namespace stark;

namespace {

constexpr Vec3 kUp{0, 0, 1}, kDown{0, 0, -1};

FrictionLimit of_point(int32_t triangle, double limit, const Vec3& normal = kUp, int32_t group_b = 1) {
  return {{PairKind::PointTriangle, 3, triangle}, 0, group_b, normal, limit};
}

FrictionLimit of_edges(int32_t second, double limit) {
  return {{PairKind::EdgeEdge, 2, second}, 0, 1, kUp, limit};
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

TEST_CASE("the layers on both sides of a point are two places") {
  const LimitComparison moved({of_point(7, 5.0), of_point(9, 3.0, kDown)},
                              {of_point(7, 4.0), of_point(9, 4.0, kDown)});
  CHECK(moved.total().largest_change == doctest::Approx(1.0));
  CHECK_FALSE(moved.is_settled());
  CHECK(LimitComparison({of_point(7, 5.0), of_point(9, 3.0, kDown)},
                        {of_point(8, 5.0), of_point(9, 3.0, kDown)})
            .is_settled());
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
