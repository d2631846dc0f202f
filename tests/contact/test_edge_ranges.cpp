// How near pairs of edges must be to push, by how flat their surfaces are.
#include <doctest/doctest.h>

#include <cmath>
#include <vector>

#include <stark/contact/edge_ranges.h>

using namespace stark;

namespace {

const EdgeRanges::Edge kFlat{.flatness = 1.0}, kSharp{.flatness = 0.0}, kBlunt{.flatness = 0.5},
    kSheet{.flatness = 1.0, .is_sheet = true}, kBorder{.flatness = 0.5, .is_sheet = true},
    kRod{.flatness = 0.0, .is_rod = true};

double range(const EdgeRanges::Edge& a, const EdgeRanges::Edge& b) {
  const EdgeRanges ranges(std::vector<EdgeRanges::Edge>{a, b});
  CHECK(ranges(0, 1) == ranges(1, 0));
  return ranges(0, 1);
}

}  // namespace

TEST_CASE("between closed surfaces the range follows the mean flatness") {
  CHECK(range(kFlat, kFlat) == doctest::Approx(0.1));
  CHECK(range(kFlat, kSharp) == doctest::Approx(std::sqrt(0.1)));
  CHECK(range(kSharp, kSharp) == 1.0);
  CHECK(range(kBlunt, kBlunt) == doctest::Approx(std::sqrt(0.1)));
}

TEST_CASE("a sheet over a sharp edge is met from the whole contact distance on") {
  CHECK(range(kSheet, kSharp) == 1.0);
  CHECK(range(kSheet, kSheet) == doctest::Approx(0.1));
  CHECK(range(kSheet, kFlat) == doctest::Approx(0.1));
  CHECK(range(kBorder, kFlat) == doctest::Approx(std::sqrt(0.1)));
  CHECK(range(kBorder, kBorder) == doctest::Approx(std::pow(0.1, 0.25)));
}

TEST_CASE("rods have no flat sides") {
  CHECK(range(kRod, kFlat) == 1.0);
  CHECK(range(kRod, kSheet) == 1.0);
  CHECK(range(kRod, kRod) == 1.0);
}

TEST_CASE("without edges known, all pairs have the whole distance") { CHECK(EdgeRanges{}(3, 5) == 1.0); }
