// The software rasteriser against what geometry says must be seen: silhouettes, hidden surfaces, shadows,
// colours.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include <doctest/doctest.h>

#include <stark/base/error.h>
#include <stark/io/raster.h>

namespace {

using stark::Vec3;

struct Mesh {
  std::vector<Vec3> points;
  std::vector<std::array<int32_t, 3>> triangles;
};

Mesh sphere(double radius, const Vec3& center, int rings = 48) {
  Mesh mesh;
  const int slices = 2 * rings;
  for (int i = 0; i <= rings; ++i)
    for (int j = 0; j < slices; ++j) {
      const double a = std::numbers::pi * i / rings, b = 2.0 * std::numbers::pi * j / slices;
      mesh.points.push_back(center +
                            radius * Vec3{std::sin(a) * std::cos(b), std::sin(a) * std::sin(b), std::cos(a)});
    }
  for (int i = 0; i < rings; ++i)
    for (int j = 0; j < slices; ++j) {
      const int a = i * slices + j, b = i * slices + (j + 1) % slices, c = a + slices, d = b + slices;
      mesh.triangles.push_back({a, c, d});
      mesh.triangles.push_back({a, d, b});
    }
  return mesh;
}

Mesh square(double half, double z) {
  return {{{-half, -half, z}, {half, -half, z}, {half, half, z}, {-half, half, z}}, {{0, 1, 2}, {0, 2, 3}}};
}

stark::RasterMesh draw(const Mesh& mesh, const Vec3& color) {
  stark::RasterMesh out;
  out.positions = mesh.points;
  out.triangles = mesh.triangles;
  out.color = color;
  return out;
}

/// Looks along -x at the origin from `distance`; the picture is square.
stark::RasterCamera camera_on_x(double distance) {
  stark::RasterCamera camera;
  camera.eye = {distance, 0.0, 0.0};
  return camera;
}

stark::RasterSettings plain(int size) {
  stark::RasterSettings settings;
  settings.width = settings.height = size;
  settings.samples = 1;
  settings.key_lights = settings.sky_lights = 0;
  settings.ground = false;
  settings.scene_radius = 1.0;
  return settings;
}

/// Pixels that are clearly red.
int count_red(const stark::Image& image) {
  int count = 0;
  for (size_t i = 0; i < image.pixels.size(); i += 3)
    count += image.pixels[i] > image.pixels[i + 1] + 40 && image.pixels[i] > image.pixels[i + 2] + 40;
  return count;
}

std::array<int, 3> pixel(const stark::Image& image, int x, int y) {
  const uint8_t* p = &image.pixels[3 * (static_cast<size_t>(y) * image.width + x)];
  return {p[0], p[1], p[2]};
}

const Vec3 kRed{0.9, 0.1, 0.1}, kBlue{0.1, 0.1, 0.9};

}  // namespace

TEST_CASE("the silhouette of a sphere has the area of its tangent cone") {
  const Mesh ball = sphere(0.5, {});
  const double distance = 3.0;
  const stark::RasterSettings settings = plain(400);
  const auto camera = camera_on_x(distance);
  const auto image = stark::rasterise(std::vector{draw(ball, kRed)}, camera, settings);
  const double slope = 0.5 / std::sqrt(distance * distance - 0.25);  // of the cone
  const double radius = 200.0 * slope / std::tan(0.5 * camera.vertical_fov);
  // The polyhedron is inscribed: its silhouette is up to 0.3 % smaller; pixel rounding averages out over the
  // circle.
  CHECK(count_red(image) == doctest::Approx(std::numbers::pi * radius * radius).epsilon(0.01));
}

TEST_CASE("the nearer surface hides the farther one, in any order") {
  const Mesh near = sphere(0.2, {0.5, 0.0, 0.0}), far = sphere(0.4, {-0.5, 0.0, 0.0});
  const auto a =
      stark::rasterise(std::vector{draw(near, kRed), draw(far, kBlue)}, camera_on_x(3.0), plain(100));
  const auto b =
      stark::rasterise(std::vector{draw(far, kBlue), draw(near, kRed)}, camera_on_x(3.0), plain(100));
  CHECK(a.pixels == b.pixels);
  CHECK(pixel(a, 50, 50)[0] > pixel(a, 50, 50)[2] + 40);
  CHECK(count_red(a) > 50);
}

TEST_CASE("directions: right of the camera is right in the picture, up is up") {
  const Mesh right = sphere(0.1, {0.0, 0.5, 0.0}), top = sphere(0.1, {0.0, 0.0, 0.5});
  const auto image =
      stark::rasterise(std::vector{draw(right, kRed), draw(top, kBlue)}, camera_on_x(3.0), plain(120));
  const int offset = static_cast<int>(60.0 * (0.5 / 3.0) / std::tan(0.305));
  CHECK(pixel(image, 60 + offset, 60)[0] > pixel(image, 60 + offset, 60)[2] + 40);
  CHECK(pixel(image, 60, 60 - offset)[2] > pixel(image, 60, 60 - offset)[0] + 40);
}

TEST_CASE("triangles that cross the near plane are cut, not dropped") {
  // A floor that runs from behind the camera to far ahead of it.
  const Mesh floor{{{10.0, -1e3, -0.5}, {10.0, 1e3, -0.5}, {-1e3, 1e3, -0.5}, {-1e3, -1e3, -0.5}},
                   {{0, 1, 2}, {0, 2, 3}}};
  const auto image = stark::rasterise(std::vector{draw(floor, kRed)}, camera_on_x(3.0), plain(100));
  // Everything below the horizon, which is in the middle; the last row before it is 150 m away.
  CHECK(count_red(image) == doctest::Approx(100 * 50).epsilon(0.025));
}

TEST_CASE("two sides: a surface is as bright from behind when it looks the same way to the light") {
  const Mesh front{{{0, -1, -1}, {0, 1, -1}, {0, 1, 1}, {0, -1, 1}}, {{0, 1, 2}, {0, 2, 3}}};
  Mesh back = front;
  for (auto& t : back.triangles) std::swap(t[1], t[2]);
  const auto a = stark::rasterise(std::vector{draw(front, kRed)}, camera_on_x(3.0), plain(40));
  const auto b = stark::rasterise(std::vector{draw(back, kRed)}, camera_on_x(3.0), plain(40));
  CHECK(a.pixels == b.pixels);
}

TEST_CASE("a plate darkens the floor straight below the light and nowhere else") {
  const Mesh plate = square(0.2, 0.5);
  stark::RasterSettings settings = plain(200);
  settings.light = {0.0, 0.0, 1.0};
  settings.key_lights = 16;
  settings.ground = true;
  settings.ground_height = 0.0;
  stark::RasterCamera camera;
  camera.eye = {0.0, -4.0, 1.5};
  const auto shadowed = stark::rasterise(std::vector{draw(plate, kRed)}, camera, settings);
  const auto empty = stark::rasterise(std::span<const stark::RasterMesh>{}, camera, settings);
  const auto project = [&](const Vec3& p) {
    const Vec3 forward = stark::normalized(-camera.eye), right{1.0, 0.0, 0.0},
               up = stark::cross(right, forward);
    const Vec3 d = p - camera.eye;
    const double scale = 100.0 / (std::tan(0.5 * camera.vertical_fov) * stark::dot(d, forward));
    return std::array<int, 2>{static_cast<int>(100.0 + scale * stark::dot(d, right)),
                              static_cast<int>(100.0 - scale * stark::dot(d, up))};
  };
  const auto brightness = [](const stark::Image& image, std::array<int, 2> at) {
    return pixel(image, at[0], at[1])[1];
  };
  const auto inside = project({0.0, 0.0, 0.0}), outside = project({0.35, 0.0, 0.0});
  CHECK(brightness(shadowed, inside) < brightness(empty, inside) - 30);
  CHECK(brightness(shadowed, outside) == brightness(empty, outside));
}

TEST_CASE("the sky is occluded below a roof") {
  const Mesh roof = square(0.6, 0.15);
  stark::RasterSettings settings = plain(100);
  settings.light = {0.0, 1.0, 0.02};  // nearly horizontal: the key light hardly reaches the ground
  settings.sky_lights = 64;
  settings.ground = true;
  stark::RasterCamera camera;
  camera.eye = {0.0, -4.0, 0.4};
  camera.target = {0.0, 0.0, 0.05};
  const auto roofed = stark::rasterise(std::vector{draw(roof, kRed)}, camera, settings);
  settings.sky_lights = 0;
  const auto open = stark::rasterise(std::vector{draw(roof, kRed)}, camera, settings);
  CHECK(pixel(roofed, 50, 52)[1] < pixel(open, 50, 52)[1] - 30);
}

TEST_CASE("a convex body casts no shadow stripes on itself") {
  const Mesh ball = sphere(0.5, {});
  stark::RasterSettings settings = plain(200);
  const auto unshadowed = stark::rasterise(std::vector{draw(ball, kRed)}, camera_on_x(3.0), settings);
  settings.key_lights = 8;
  const auto shadowed = stark::rasterise(std::vector{draw(ball, kRed)}, camera_on_x(3.0), settings);
  int darker = 0;
  for (size_t i = 0; i < shadowed.pixels.size(); i += 3)
    darker += shadowed.pixels[i] + 8 < unshadowed.pixels[i];
  // Only along the border between light and dark may the map's resolution show.
  CHECK(darker < 0.01 * count_red(unshadowed));
}

TEST_CASE("creases: a cube has flat faces, a smooth mesh does not show its facets") {
  const Mesh ball = sphere(0.5, {}, 12);
  stark::RasterMesh smooth = draw(ball, kRed), facets = smooth;
  smooth.crease_angle = std::numbers::pi;
  facets.crease_angle = 1e-3;
  const auto a = stark::rasterise(std::vector{smooth}, camera_on_x(3.0), plain(200));
  const auto b = stark::rasterise(std::vector{facets}, camera_on_x(3.0), plain(200));
  const auto largest_jump = [](const stark::Image& image) {
    int jump = 0;
    for (int x = 80; x < 120; ++x)
      jump = std::max(jump, std::abs(pixel(image, x, 95)[0] - pixel(image, x + 1, 95)[0]));
    return jump;
  };
  CHECK(largest_jump(a) <= 3);
  CHECK(largest_jump(b) >= 5);
}

TEST_CASE("the picture does not depend on the number of threads") {
  const Mesh ball = sphere(0.4, {0.0, 0.0, 0.4});
  stark::RasterSettings settings = plain(150);
  settings.samples = 2;
  settings.key_lights = 4;
  settings.sky_lights = 8;
  settings.ground = true;
  settings.grid_spacing = 0.1;
  settings.edges = true;
  stark::RasterCamera camera;
  settings.threads = 1;
  const auto one = stark::rasterise(std::vector{draw(ball, kRed)}, camera, settings);
  for (const int threads : {2, 5}) {
    settings.threads = threads;
    CHECK(stark::rasterise(std::vector{draw(ball, kRed)}, camera, settings).pixels == one.pixels);
  }
}

TEST_CASE("degenerate triangles and empty meshes are harmless") {
  const Mesh odd{{{0, 0, 0}, {0, 0, 0}, {0, 1, 0}, {0, 2, 0}}, {{0, 1, 2}, {0, 2, 3}, {0, 0, 0}}};
  const Mesh none;
  const auto image =
      stark::rasterise(std::vector{draw(odd, kRed), draw(none, kRed)}, camera_on_x(3.0), plain(50));
  CHECK(image.pixels.size() == 50u * 50u * 3u);
}

TEST_CASE("bad input is refused with what, why and where") {
  const Mesh ball = sphere(0.5, {}, 4);
  Mesh nan = ball, outside = ball;
  nan.points[3].y = std::numeric_limits<double>::quiet_NaN();
  outside.triangles[2][1] = 1000;
  const auto camera = camera_on_x(3.0);
  CHECK_THROWS_WITH_AS(stark::rasterise(std::vector{draw(nan, kRed)}, camera, plain(10)),
                       doctest::Contains("vertex 3 is not finite"), stark::InvalidArgument);
  CHECK_THROWS_WITH_AS(stark::rasterise(std::vector{draw(outside, kRed)}, camera, plain(10)),
                       doctest::Contains("triangle 2 names vertex 1000"), stark::InvalidArgument);
  const auto refuse = [&](auto change, const char* message) {
    stark::RasterSettings settings = plain(10);
    stark::RasterCamera eye = camera;
    change(settings, eye);
    CHECK_THROWS_WITH_AS(stark::rasterise(std::vector{draw(ball, kRed)}, eye, settings),
                         doctest::Contains(message), stark::InvalidArgument);
  };
  refuse([](auto& s, auto&) { s.width = 0; }, "size 0 x 10 px");
  refuse([](auto& s, auto&) { s.height = 100000; }, "must be in [1, 16384]");
  refuse([](auto& s, auto&) { s.samples = 9; }, "samples = 9");
  refuse([](auto& s, auto&) { s.scene_radius = 0.0; }, "scene radius");
  refuse([](auto&, auto& c) { c.eye = c.target; }, "eye and target are the same");
  refuse([](auto&, auto& c) { c.vertical_fov = 4.0; }, "field of view");
}

TEST_CASE("the border between light and shade of a coarse sphere is that of a round one") {
  // Triangles of 22 degrees, whose corner normals are those of the sphere. What is interpolated differs by up
  // to 12 of 255 levels; shadows that end at edges of triangles are off by more in one of 100 pixels.
  stark::RasterSettings settings = plain(240);
  settings.light = {0.1, 1.0, 0.2};  // from the right: the border is in the middle of the picture
  settings.key_lights = 24;
  const auto camera = camera_on_x(3.0);
  const auto coarse = stark::rasterise(std::vector{draw(sphere(0.5, {}, 8), kRed)}, camera, settings);
  const auto round = stark::rasterise(std::vector{draw(sphere(0.5, {}, 200), kRed)}, camera, settings);
  const double radius =
      120.0 * (0.5 / 3.0) / std::tan(0.5 * camera.vertical_fov);  // of the silhouette, about
  int compared = 0, off = 0;
  for (int y = 0; y < 240; ++y)
    for (int x = 0; x < 240; ++x) {
      if (std::hypot(x - 119.5, y - 119.5) > 0.85 * radius) continue;
      ++compared;
      off += std::abs(pixel(coarse, x, y)[0] - pixel(round, x, y)[0]) > 12;
    }
  CHECK(compared > 5000);
  CHECK(off < compared / 1000);
}

TEST_CASE("the lines of the ground are as fine as samples make them, its light is that of the pixel") {
  stark::RasterSettings fine = plain(240);
  fine.ground = true;
  fine.ground_height = -0.5;
  fine.grid_spacing = 0.1;
  fine.sky_lights = 8;
  stark::RasterSettings few = fine;
  few.width = few.height = 80;
  few.samples = 3;
  const auto large = stark::rasterise({}, camera_on_x(3.0), fine);
  const auto small = stark::rasterise({}, camera_on_x(3.0), few);
  // Lines are wider in the smaller picture, so only the means of blocks of pixels are the same, within a
  // level.
  double sum_large = 0.0, sum_small = 0.0;
  for (size_t i = 0; i < large.pixels.size(); ++i) sum_large += large.pixels[i];
  for (size_t i = 0; i < small.pixels.size(); ++i) sum_small += small.pixels[i];
  CHECK(sum_small / static_cast<double>(small.pixels.size()) ==
        doctest::Approx(sum_large / static_cast<double>(large.pixels.size())).epsilon(0.01));
}

TEST_CASE("a picture that is wanted no more ends between its parts, on any number of threads") {
  const Mesh ball = sphere(0.5, {}, 24);
  const std::vector meshes{draw(ball, kRed)};
  for (const int threads : {1, 3}) {
    stark::RasterSettings settings = plain(200);
    settings.threads = threads;
    int asked = 0;
    const auto go_on = [&] { return ++asked, false; };
    CHECK(stark::rasterise(meshes, camera_on_x(3.0), settings, go_on).pixels ==
          stark::rasterise(meshes, camera_on_x(3.0), settings).pixels);
    CHECK(asked >= 1);
    CHECK(stark::rasterise(meshes, camera_on_x(3.0), settings, [] { return true; }).pixels.empty());
  }
  int asked = 0;
  const auto third = [&] { return ++asked == 3; };
  CHECK(stark::rasterise(meshes, camera_on_x(3.0), plain(200), third).width == 0);
  CHECK(asked == 3);  // of some 25 bands of rows
}
