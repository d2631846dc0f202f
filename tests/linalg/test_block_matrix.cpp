// Patterns against std::set, products against a dense matrix.
#include <stark/linalg/block_matrix.h>

#include <algorithm>
#include <cmath>
#include <set>

#include <doctest/doctest.h>
#include <stark/base/error.h>

#include "linalg/systems.h"

namespace {

using namespace stark;

std::set<std::pair<int32_t, int32_t>> entries_of(const BlockPattern& pattern) {
  std::set<std::pair<int32_t, int32_t>> entries;
  for (int32_t i = 0; i < pattern.block_count; ++i)
    for (int64_t k = pattern.row_start[i]; k < pattern.row_start[i + 1]; ++k)
      entries.emplace(i, pattern.column[k]);
  return entries;
}

std::set<std::pair<int32_t, int32_t>> expected_entries(int32_t n, const test::Pairs& pairs) {
  std::set<std::pair<int32_t, int32_t>> entries;
  for (int32_t i = 0; i < n; ++i) entries.emplace(i, i);
  for (const auto& [i, j] : pairs) entries.emplace(std::min(i, j), std::max(i, j));
  return entries;
}

void check_well_formed(const BlockPattern& pattern) {
  REQUIRE(pattern.row_start.size() == static_cast<size_t>(pattern.block_count) + 1);
  REQUIRE(pattern.row_start.back() == pattern.slot_count());
  for (int32_t i = 0; i < pattern.block_count; ++i) {
    REQUIRE(pattern.column[pattern.row_start[i]] == i);
    for (int64_t k = pattern.row_start[i] + 1; k < pattern.row_start[i + 1]; ++k)
      REQUIRE(pattern.column[k] > pattern.column[k - 1]);
  }
}

}  // namespace

TEST_CASE("block pattern: pairs in any order, with duplicates") {
  for (int32_t n : {1, 2, 7, 100}) {
    const test::Pairs pairs = test::random_pairs(n, 5 * n, 17 + n);
    const BlockPattern pattern = BlockPattern::from_pairs(n, pairs);
    check_well_formed(pattern);
    CHECK(entries_of(pattern) == expected_entries(n, pairs));
    int64_t slot = 0;
    for (const auto& [i, j] : entries_of(pattern)) CHECK(pattern.slot(i, j) == slot++);
    for (int32_t i = 0; i < n; ++i)
      for (int32_t j = i; j < n; ++j)
        if (!entries_of(pattern).contains({i, j})) REQUIRE(pattern.slot(i, j) == -1);
  }
  const BlockPattern empty = BlockPattern::from_pairs(0, {});
  CHECK(empty.slot_count() == 0);
  CHECK_THROWS_AS(BlockPattern::from_pairs(3, {{0, 3}}), InternalError);
  CHECK_THROWS_AS(BlockPattern::from_pairs(3, {{-1, 2}}), InternalError);
}

TEST_CASE("block pattern: union with pairs keeps track of the slots") {
  const int32_t n = 60;
  const test::Pairs base_pairs = test::random_pairs(n, 150, 1), more = test::random_pairs(n, 100, 2);
  const BlockPattern base = BlockPattern::from_pairs(n, base_pairs);
  std::vector<int64_t> slots;
  const BlockPattern merged = base.merged_with(more, slots);
  check_well_formed(merged);
  test::Pairs all = base_pairs;
  all.insert(all.end(), more.begin(), more.end());
  CHECK(merged == BlockPattern::from_pairs(n, all));
  REQUIRE(slots.size() == base.column.size());
  for (const auto& [i, j] : entries_of(base)) REQUIRE(slots[base.slot(i, j)] == merged.slot(i, j));
  CHECK(base.merged_with({}, slots) == base);
}

TEST_CASE("block pattern: hash follows the structure") {
  const BlockPattern a = BlockPattern::from_pairs(4, {{0, 1}, {2, 3}});
  CHECK(a.hash() == BlockPattern::from_pairs(4, {{3, 2}, {1, 0}, {0, 1}}).hash());
  std::set<uint64_t> hashes;
  int count = 0;
  for (int32_t n = 1; n < 12; ++n)
    for (int32_t i = 0; i < n; ++i)
      for (int32_t j = i + 1; j < n; ++j, ++count)
        hashes.insert(BlockPattern::from_pairs(n, {{i, j}}).hash());
  CHECK(static_cast<int>(hashes.size()) == count);
}

TEST_CASE("block matrix: product against the dense matrix, same bits on any number of threads") {
  for (int32_t n : {1, 50, 300}) {
    const BlockMatrix matrix =
        test::spd_matrix(BlockPattern::from_pairs(n, test::random_pairs(n, 4 * n, n)), 5);
    const std::vector<double> x = test::random_vector(3 * n, 6);
    const std::vector<long double> dense = test::dense_of(matrix);
    std::vector<double> y(3 * n, -1.0);
    ThreadPool pool(1);
    matrix.multiply(x.data(), y.data(), pool);
    for (int i = 0; i < 3 * n; ++i) {
      long double sum = 0, scale = 0;
      for (int j = 0; j < 3 * n; ++j) {
        sum += dense[3 * n * i + j] * x[j];
        scale += std::fabs(dense[3 * n * i + j] * x[j]);
      }
      REQUIRE(std::fabs(y[i] - sum) <= 1e-14L * scale);  // some ten additions of relative error 1e-16 each
    }
  }
  const BlockMatrix large = test::spd_matrix(BlockPattern::from_pairs(70 * 70, test::cloth_pairs(70)), 8);
  const std::vector<double> x = test::random_vector(3 * 70 * 70, 9);
  std::vector<double> one(x.size()), many(x.size());
  ThreadPool pool1(1), pool3(3);
  large.multiply(x.data(), one.data(), pool1);
  large.multiply(x.data(), many.data(), pool3);
  CHECK(one == many);
  // Symmetry: u . A x = x . A u.
  const std::vector<double> u = test::random_vector(x.size(), 10);
  large.multiply(u.data(), many.data(), pool3);
  double left = 0.0, right = 0.0;
  for (size_t k = 0; k < x.size(); ++k) left += u[k] * one[k], right += x[k] * many[k];
  CHECK(left == doctest::Approx(right).epsilon(1e-11));
}
