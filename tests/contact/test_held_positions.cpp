#include <doctest/doctest.h>

#include <cmath>
#include <vector>

#include <stark/contact/held_positions.h>

using namespace stark;

TEST_CASE("Held positions are those that were given, to the last bit of the last one") {
  for (const int threads : {1, 3}) {
    ThreadPool pool(threads);
    for (const size_t count : {size_t{0}, size_t{1}, size_t{50001}}) {
      std::vector<Vec3> x(count);
      for (size_t i = 0; i < count; ++i) x[i] = {0.1 * static_cast<double>(i), 1.0, -2.0};
      HeldPositions held, other;
      held.hold(x, pool);
      CHECK(held.are(x, pool));
      CHECK(other.are(x, pool) == x.empty());
      other.swap(held);
      CHECK(other.are(x, pool));
      for (const size_t i : {count / 2, count - 1}) {
        if (count == 0) continue;
        const double there = x[i].z;
        x[i].z = std::nextafter(there, 0.0);
        CHECK(!other.are(x, pool));
        x[i].z = there;
      }
      x.push_back({});
      CHECK(!other.are(x, pool));
    }
  }
}
