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

TEST_CASE("What is known not to have changed is neither compared nor copied, and nothing else is left out") {
  ThreadPool pool(2);
  const size_t count = 40000;
  std::vector<Vec3> x(count, Vec3{1.0, 2.0, 3.0});
  const std::vector<SiteRange> moving = {{100, 200}, {30000, 39999}};
  const auto known = [&](uint64_t still) { return SitePositions(x, moving, still); };
  HeldPositions held, other;
  held.hold(x, pool);
  // Nothing is known of what was held without a number.
  x[5].x = 9.0;
  CHECK(!held.are(known(7), pool));
  held.hold(known(7), pool);
  CHECK(held.get()[5].x == 9.0);
  CHECK(held.are(known(7), pool));
  for (const size_t i : {size_t{100}, size_t{199}, size_t{30000}, size_t{39998}}) {
    x[i].y = -1.0;
    CHECK(!held.are(known(7), pool));
    held.hold(known(7), pool);
    CHECK(held.get()[i].y == -1.0);
    CHECK(held.are(known(7), pool));
  }
  // The number goes where the positions go.
  other.swap(held);
  CHECK(other.are(known(7), pool));
  x[99].z = 0.5;
  CHECK(other.are(known(7), pool));   // as was claimed
  CHECK(!other.are(known(8), pool));  // another number claims nothing
  CHECK(!other.are(known(0), pool));
  CHECK(!other.are(x, pool));
  other.hold(known(8), pool);
  CHECK(other.get()[99].z == 0.5);
}
