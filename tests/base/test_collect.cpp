#include <doctest/doctest.h>

#include <memory>
#include <vector>

#include <stark/base/collect.h>

using namespace stark;

TEST_CASE("Lists of ranges are joined in their order on any number of threads") {
  for (const int threads : {1, 2, 5}) {
    ThreadPool pool(threads);
    for (const int64_t count : {0, 1, 7, 8, 1000}) {
      const std::vector<int64_t> odd =
          collect_ranges<int64_t>(pool, count, 4, [](int64_t begin, int64_t end, std::vector<int64_t>& out) {
            for (int64_t i = begin; i < end; ++i)
              if (i % 2 == 1) out.push_back(i);
          });
      REQUIRE(odd.size() == static_cast<size_t>(count / 2));
      for (size_t k = 0; k < odd.size(); ++k) CHECK(odd[k] == 2 * static_cast<int64_t>(k) + 1);
    }
  }
}

TEST_CASE("An empty range is asked once, and items are moved") {
  ThreadPool pool(2);
  const auto items =
      collect_ranges<std::unique_ptr<int>>(pool, 0, 16, [](int64_t begin, int64_t end, auto& out) {
        CHECK(begin == end);
        out.push_back(std::make_unique<int>(3));
      });
  REQUIRE(items.size() == 1);
  CHECK(*items[0] == 3);
}
