#include <doctest/doctest.h>

#include <stark/base/rotation.h>
#include <stark/contact/surface_motion.h>

using namespace stark;

TEST_CASE("the material of a moving surface goes with the frame of its body") {
  const std::array<Vec3, 3> local{Vec3{1, 0, 0}, Vec3{0, 2, 0}, Vec3{0, 0, 3}};
  const SurfaceMotion motion{{0.5, -0.2, 0.1}, {0.3, 0.4, 2.0}, {0.1, 0.2, 0.3}};
  MovingSurfaces surfaces({{.group = 3, .sites = {0, 1, 2}, .local = local, .motion = motion}});
  const Mat3 R = exp_rotation({0.7, -1.1, 0.4});
  const Vec3 t{5, 6, 7};
  std::vector<Vec3> x;
  for (const Vec3& p : local) x.push_back(t + R * p);
  const Vec3 r{0.4, 0.9, -0.3};

  const double h = 0.1;
  const Vec3 velocity = R * (motion.velocity + cross(motion.spin, r - motion.center));
  CHECK(norm(surfaces.way(3, t + R * r, x, h, false) - velocity * h) < 1e-14);
  // A chord is what the point of the material has come since, which was on the same circle then.
  const Vec3 before = exp_rotation(motion.spin * -h) * (r - motion.center) + motion.center;
  const Vec3 chord = R * (r - before + motion.velocity * h);
  CHECK(norm(surfaces.way(3, t + R * r, x, h, true) - chord) < 1e-14);
  CHECK(surfaces.turn(3, R * Vec3{0, 0, 1}, x, h) == doctest::Approx(2.0 * h));

  for (const int32_t group : {0, 2, 4}) {
    CHECK(surfaces.way(group, r, x, h, true) == Vec3{});
    CHECK(surfaces.turn(group, {0, 0, 1}, x, h) == 0.0);
  }
  const Vec3 slow{0, 0.25, 0};
  surfaces.set(std::span(&slow, 1), std::span<const Vec3>(std::array<Vec3, 1>{}));
  CHECK(norm(surfaces.way(3, t, x, h, true) - R * slow * h) < 1e-15);
  CHECK(MovingSurfaces().empty());
  CHECK_FALSE(surfaces.empty());
}
