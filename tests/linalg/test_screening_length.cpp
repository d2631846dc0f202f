// The distance that a force is felt over: chains of springs with masses, on which it is known.
#include <stark/linalg/screening_length.h>

#include <cmath>

#include <doctest/doctest.h>

#include "linalg/systems.h"

using namespace stark;

namespace {

// A ring of springs of stiffness 1 in all directions, with `mass` on each node.
BlockMatrix ring(int32_t n, double mass) {
  test::Pairs pairs;
  for (int32_t i = 0; i < n; ++i) pairs.emplace_back(i, (i + 1) % n);
  BlockMatrix matrix;
  matrix.pattern = BlockPattern::from_pairs(n, pairs);
  matrix.set_zero();
  for (int32_t i = 0; i < n; ++i)
    for (int64_t slot = matrix.pattern.row_start[i]; slot < matrix.pattern.row_start[i + 1]; ++slot)
      for (int a = 0; a < 3; ++a)
        matrix.values[9 * slot + 4 * a] = matrix.pattern.column[slot] == i ? 2.0 + mass : -1.0;
  return matrix;
}

}  // namespace

TEST_CASE("the length of a ring of springs is that of stiffness over mass") {
  for (double mass : {0.01, 0.1, 1.0, 10.0})
    CHECK(find_screening_length(ring(20, mass)) == doctest::Approx(std::sqrt((2.0 + mass) / mass)));
}

TEST_CASE("a few stiff contacts do not change it, and what has no inertia is felt everywhere") {
  BlockMatrix matrix = ring(20, 0.1);
  for (int32_t i : {3, 8, 9}) matrix.values[9 * matrix.pattern.row_start[i]] += 1e6;
  CHECK(find_screening_length(matrix) == doctest::Approx(std::sqrt(2.1 / 0.1)));
  CHECK(find_screening_length(ring(20, 0.0)) == INFINITY);
  CHECK(find_screening_length(BlockMatrix{}) == 0.0);
}
