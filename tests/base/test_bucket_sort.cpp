#include <doctest/doctest.h>

#include <algorithm>
#include <cstdint>
#include <random>
#include <vector>

#include <stark/base/bucket_sort.h>

using namespace stark;

namespace {

struct Item {
  int32_t number, rank;
  bool operator==(const Item&) const = default;
};

std::vector<Item> random_items(int count, int32_t least, int32_t most) {
  std::mt19937 engine(7);
  std::uniform_int_distribution<int32_t> number(least, most), rank(0, 9);
  std::vector<Item> items;
  for (int i = 0; i < count; ++i) items.push_back({number(engine), rank(engine)});
  return items;
}

void check_sorted_as_by_comparison(std::vector<Item> items) {
  std::vector<Item> expected = items;
  std::sort(expected.begin(), expected.end(), [](const Item& a, const Item& b) {
    return a.number != b.number ? a.number < b.number : a.rank < b.rank;
  });
  bucket_sort(
      items, [](const Item& i) { return i.number; },
      [](const Item& a, const Item& b) { return a.rank < b.rank; });
  CHECK(items == expected);
}

}  // namespace

TEST_CASE("Buckets sort as a comparison does") {
  check_sorted_as_by_comparison({});
  check_sorted_as_by_comparison({{5, 1}});
  check_sorted_as_by_comparison(random_items(1000, 0, 300));
  check_sorted_as_by_comparison(random_items(1000, -1, 5000));
  check_sorted_as_by_comparison(random_items(1000, 40, 40));
}

TEST_CASE("Numbers far apart need no bucket for each between them") {
  check_sorted_as_by_comparison(random_items(1000, INT32_MIN, INT32_MAX));
}
