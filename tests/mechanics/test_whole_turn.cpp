// What a straight motion lacks of the turn that is in it.
#include <doctest/doctest.h>

#include <random>
#include <vector>

#include <stark/base/rotation.h>
#include <stark/mechanics/dof_layout.h>
#include <stark/mechanics/whole_turn.h>

using namespace stark;

namespace {

/// A cloud of points with a block each, and the velocities that it has as a rigid body.
struct Cloud {
  std::vector<Vec3> x, to;
  std::vector<int32_t> blocks;
  std::vector<double> direction, masses;

  explicit Cloud(std::vector<Vec3> places) : x(std::move(places)), masses(x.size(), 2.0) {
    for (size_t i = 0; i < x.size(); ++i) blocks.push_back(static_cast<int32_t>(i));
    direction.assign(3 * x.size(), 0.0);
  }
  void move(const Vec3& velocity, const Vec3& spin, const Vec3& centre) {
    for (size_t i = 0; i < x.size(); ++i) {
      const Vec3 u = blocks[i] == kNoBlock ? Vec3{} : velocity + cross(spin, x[i] - centre);
      for (int a = 0; a < 3; ++a) direction[3 * i + a] = u[a];
    }
  }
  bool complete(double alpha, bool is_held = false) {
    to = x;
    for (size_t i = 0; i < x.size(); ++i)
      to[i] += Vec3{direction[3 * i], direction[3 * i + 1], direction[3 * i + 2]} * alpha;
    return complete_turn({.is_held = is_held, .masses = masses}, x, blocks, direction, alpha, to);
  }
  double largest_stretch() const {
    double largest = 0.0;
    for (size_t i = 0; i < x.size(); ++i)
      for (size_t j = 0; j < i; ++j)
        largest = std::max(largest, std::fabs(norm(to[i] - to[j]) / norm(x[i] - x[j]) - 1.0));
    return largest;
  }
};

std::vector<Vec3> random_places(int count, unsigned seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> place(-0.5, 0.5);
  std::vector<Vec3> places;
  for (int i = 0; i < count; ++i) places.push_back({3.0 + place(random), place(random), place(random)});
  return places;
}

Vec3 mean(const std::vector<Vec3>& values) {
  Vec3 sum;
  for (const Vec3& v : values) sum += v;
  return sum * (1.0 / static_cast<double>(values.size()));
}

}  // namespace

TEST_CASE("a rigid motion keeps all distances and takes the centre straight") {
  Cloud cloud(random_places(12, 1));
  const Vec3 velocity{0.3, -0.2, 0.1}, spin{0.3, 0.5, -0.4}, centre = mean(cloud.x);
  cloud.move(velocity, spin, centre);
  REQUIRE(cloud.complete(1.0));
  CHECK(cloud.largest_stretch() < 1e-8);  // the inertia is rounded up by 1e-9
  CHECK(max_abs(mean(cloud.to) - (centre + velocity)) < 1e-14);
  const Mat3 turn = exp_rotation(spin);
  for (size_t i = 0; i < cloud.x.size(); ++i)
    CHECK(max_abs(cloud.to[i] - (centre + velocity + turn * (cloud.x[i] - centre))) < 1e-8);
  REQUIRE(cloud.complete(0.5));
  CHECK(cloud.largest_stretch() < 1e-8);
}

TEST_CASE("a straight motion would stretch it by half the square of the angle") {
  Cloud cloud(random_places(12, 2));
  cloud.move({}, {0.0, 0.0, 0.4}, mean(cloud.x));
  REQUIRE(cloud.complete(1.0));
  CHECK(cloud.largest_stretch() < 1e-8);
  for (size_t i = 0; i < cloud.x.size(); ++i)
    cloud.to[i] =
        cloud.x[i] + Vec3{cloud.direction[3 * i], cloud.direction[3 * i + 1], cloud.direction[3 * i + 2]};
  CHECK(cloud.largest_stretch() > 0.05);
}

TEST_CASE("what is not a turn stays straight, and all of it to first order") {
  Cloud cloud(random_places(9, 3));
  std::mt19937_64 random(4);
  std::uniform_real_distribution<double> noise(-0.3, 0.3);
  for (double& v : cloud.direction) v = noise(random);
  const double h = 1e-3;
  REQUIRE(cloud.complete(h));
  for (size_t i = 0; i < cloud.x.size(); ++i) {
    const Vec3 u{cloud.direction[3 * i], cloud.direction[3 * i + 1], cloud.direction[3 * i + 2]};
    CHECK(max_abs((cloud.to[i] - cloud.x[i]) * (1.0 / h) - u) < h);
  }
  for (size_t i = 0; i < cloud.x.size(); ++i)  // all shrink towards the centre
    for (int a = 0; a < 3; ++a) cloud.direction[3 * i + a] = -0.1 * (cloud.x[i] - mean(cloud.x))[a];
  CHECK_FALSE(cloud.complete(1.0));
}

TEST_CASE("pins stay where they are, and are what the rest turns about") {
  Cloud cloud(random_places(10, 5));
  cloud.blocks[3] = kNoBlock;
  const Vec3 pin = cloud.x[3];
  cloud.move({}, {0.2, -0.3, 0.4}, pin);
  REQUIRE(cloud.complete(1.0));
  CHECK(cloud.to[3] == pin);
  CHECK(cloud.largest_stretch() < 1e-8);
}

TEST_CASE("what is held turns about the axis that stays where it is") {
  Cloud cloud(random_places(10, 8));
  const Vec3 hinge{2.0, 0.5, 0.0}, spin{0.0, 0.0, 0.6};
  cloud.move({}, spin, hinge);
  REQUIRE(cloud.complete(1.0, true));
  const Mat3 turn = exp_rotation(spin);
  for (size_t i = 0; i < cloud.x.size(); ++i)
    CHECK(max_abs(cloud.to[i] - (hinge + turn * (cloud.x[i] - hinge))) < 1e-8);
  REQUIRE(cloud.complete(0.5, true));
  CHECK(max_abs(cloud.to[0] - (hinge + exp_rotation(spin * 0.5) * (cloud.x[0] - hinge))) < 1e-8);
  // A motion along the axis is none of the turn.
  cloud.move({0.0, 0.0, 0.3}, spin, hinge);
  REQUIRE(cloud.complete(1.0, true));
  CHECK(max_abs(cloud.to[0] - (hinge + turn * (cloud.x[0] - hinge) + Vec3{0.0, 0.0, 0.3})) < 1e-8);
}

TEST_CASE("a point of next to no mass turns nothing, wherever it goes") {
  Cloud cloud(random_places(10, 9));
  cloud.masses[4] = 1e-9;
  cloud.direction[12] = 0.4;
  CHECK_FALSE(cloud.complete(1.0));
}

TEST_CASE("points on a line turn about all but that line") {
  std::vector<Vec3> line;
  for (int i = 0; i < 6; ++i) line.push_back({0.1 * i, 0.2 * i, 0.0});
  Cloud cloud(line);
  cloud.move({0, 0, 1}, {0.0, 0.0, 0.5}, mean(cloud.x));
  REQUIRE(cloud.complete(1.0));
  CHECK(cloud.largest_stretch() < 1e-8);
}

TEST_CASE("turns that are too small to matter, and those of one point, are left out") {
  Cloud cloud(random_places(8, 6));
  cloud.move({1, 2, 3}, {0.0, 9e-6, 0.0}, mean(cloud.x));
  CHECK_FALSE(cloud.complete(1.0));
  Cloud one({{1, 2, 3}});
  one.move({1, 0, 0}, {0.0, 0.3, 0.0}, one.x[0]);
  CHECK_FALSE(one.complete(1.0));
  CHECK(one.to[0] == Vec3{2, 2, 3});
}

TEST_CASE("turns beyond a radian are not completed beyond it") {
  Cloud cloud(random_places(8, 7));
  const Vec3 centre = mean(cloud.x), spin{0.0, 0.0, 3.0};
  cloud.move({}, spin, centre);
  REQUIRE(cloud.complete(1.0));
  const Mat3 turn = exp_rotation({0.0, 0.0, 1.0});
  for (size_t i = 0; i < cloud.x.size(); ++i) {
    const Vec3 r = cloud.x[i] - centre;
    CHECK(max_abs(cloud.to[i] - (centre + turn * r + cross({0.0, 0.0, 2.0}, r))) < 1e-7);
  }
}
