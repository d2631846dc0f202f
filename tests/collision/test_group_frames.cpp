// Frames of bodies against all of their sites.
#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <numeric>

#include <stark/base/rotation.h>
#include <stark/collision/broad_phase.h>
#include <stark/collision/distant_pairs.h>
#include <stark/geometry/shapes.h>

#include "support/collision_scenes.h"
#include "support/random_points.h"

using namespace stark;
using test::includes;
using test::RandomPoints;
using test::SceneBuilder;

namespace {

std::vector<int32_t> all_of(std::span<const Vec3> x) {
  std::vector<int32_t> sites(x.size());
  std::iota(sites.begin(), sites.end(), 0);
  return sites;
}

std::vector<Vec3> moved(std::span<const Vec3> x, const Mat3& turn, const Vec3& by) {
  std::vector<Vec3> out;
  for (const Vec3& p : x) out.push_back(turn * p + by);
  return out;
}

bool is_within(const Bounds& inner, const Bounds& outer) {
  return outer.contains(inner.low) && outer.contains(inner.high);
}

Bounds bounds_of(std::span<const Vec3> x) {
  Bounds bounds;
  for (const Vec3& p : x) bounds.add(p);
  return bounds;
}

void set_frames(SceneBuilder& scene) {
  SurfaceMesh& mesh = scene.surface;
  mesh.frames.clear();
  for (int32_t g = 0; g < scene.group_count; ++g) {
    std::vector<int32_t> sites;
    for (int32_t v = 0; v < mesh.vertex_count; ++v)
      if (mesh.vertex_group[v] == g) sites.push_back(v);
    mesh.frames.push_back(find_frame(sites, scene.x));
  }
}

}  // namespace

TEST_CASE("a frame bounds where all sites are, how far and how they move, and hardly more") {
  RandomPoints random(71);
  for (const double far : {0.0, 1.0, 1e4}) {
    for (int round = 0; round < 30; ++round) {
      const Mat3 stretch =
          Mat3::diagonal({random.uniform(0.02, 2.0), random.uniform(0.02, 2.0), random.uniform(0.02, 2.0)});
      const Mat3 first = exp_rotation(random.point() * 3.0);
      const std::vector<Vec3> rest = moved(make_icosphere(0.3, 2).vertices, first * stretch, random.point());
      const auto frame = find_frame(all_of(rest), rest);
      REQUIRE(frame.has_value());
      const auto pose = [&](double angle) {
        return moved(rest, exp_rotation(random.point() * angle), random.point() * (angle + far));
      };
      const std::vector<Vec3> x0 = pose(3.0);
      std::vector<Vec3> x1 = x0;
      const Mat3 turn = exp_rotation(random.point() * 0.01);
      const Vec3 by = random.point() * (round % 2 == 0 ? 0.0 : 0.1);
      for (Vec3& p : x1) p = x0[0] + turn * (p - x0[0]) + by;
      std::vector<Vec3> displacements;
      double farthest = 0.0;
      for (size_t i = 0; i < x0.size(); ++i) {
        displacements.push_back(x1[i] - x0[i]);
        farthest = std::max(farthest, norm(displacements.back()));
      }
      CHECK(is_within(bounds_of(x0), frame->bound(x0)));
      CHECK(is_within(bounds_of(displacements), frame->bound_motion(x0, x1)));
      CHECK(frame->farthest(x0, x1) >= farthest);
      CHECK(frame->farthest(x0, x1) < 3.0 * farthest + 1e-12 * (1.0 + far));
      const Bounds tight = bounds_of(x0), wide = frame->bound(x0);
      CHECK(norm(wide.high - wide.low) < 2.0 * norm(tight.high - tight.low));
      std::vector<Vec3> middle = x0;  // of the straight way, where it is no rotation
      for (size_t i = 0; i < x0.size(); ++i) middle[i] = (x0[i] + x1[i]) * 0.5;
      CHECK(is_within(bounds_of(middle), frame->bound(middle)));
    }
  }
}

TEST_CASE("what has few sites or no thickness has no frame, and what is not finite is far away") {
  const std::vector<Vec3> cube = make_box({1, 1, 1}).vertices, flat = make_grid(1, 1, 20, 20).vertices;
  CHECK_FALSE(find_frame(all_of(cube), cube).has_value());
  CHECK_FALSE(find_frame(all_of(flat), flat).has_value());
  const std::vector<Vec3> point(100, Vec3{1, 2, 3});
  CHECK_FALSE(find_frame(all_of(point), point).has_value());
  const std::vector<Vec3> ball = make_icosphere(0.1, 2).vertices;
  const auto frame = find_frame(all_of(ball), ball);
  REQUIRE(frame.has_value());
  const std::vector<Vec3> nowhere(ball.size(), Vec3{std::numeric_limits<double>::quiet_NaN(), 0.0, 0.0});
  CHECK_FALSE(frame->farthest(ball, nowhere) <= 1e9);
}

TEST_CASE("bodies with frames have the pairs of bodies without") {
  RandomPoints random(72);
  SceneBuilder scene;
  for (int k = 0; k < 12; ++k) scene.add_mesh(make_icosphere(0.1, 2), random.point() * 0.3);
  for (int k = 0; k < 4; ++k) scene.add_mesh(make_box({0.3, 0.05, 0.05}, 4), random.point() * 0.3);
  scene.add_mesh(make_grid(0.6, 0.6, 8, 8));
  scene.add_mesh(make_box({1.0, 1.0, 0.1}), {0, 0, -0.5});
  SceneBuilder framed = scene;
  set_frames(framed);
  REQUIRE(std::ranges::count_if(framed.surface.frames, [](const auto& f) { return f.has_value(); }) == 16);

  const PairFilter filter(scene.group_count, true, false);
  const std::vector<double> reach(scene.group_count, 0.004), separation(scene.group_count, 1e-4);
  BroadPhase with, without;
  with.reset(framed.surface, filter);
  without.reset(scene.surface, filter);
  ThreadPool pool(2);
  std::vector<Vec3> x0 = scene.x;
  int64_t near = 0;
  for (int round = 0; round < 80; ++round) {
    std::vector<Vec3> x1 = x0, velocity, spin;
    std::vector<uint8_t> marks;
    for (int g = 0; g < scene.group_count; ++g) {
      const bool moves = random.uniform(0.0, 1.0) < 0.3;
      velocity.push_back(moves ? random.point() * 0.05 : Vec3{});
      spin.push_back(moves ? random.point() * 0.1 : Vec3{});
    }
    for (size_t v = 0; v < x1.size(); ++v) {
      const int32_t g = scene.surface.vertex_group[v];
      x1[v] = exp_rotation(spin[g]) * x0[v] + velocity[g];
      marks.push_back(norm(velocity[g]) > 0.0 ? 1 : 0);
    }
    const auto compare = [&](std::span<const double> within, auto&& find) {
      CandidateList list, expected;
      find(with, list);
      find(without, expected);
      for (const double t : {0.0, 0.5, 1.0}) {
        std::vector<Vec3> at(x0.size());
        for (size_t v = 0; v < at.size(); ++v) at[v] = x0[v] + (x1[v] - x0[v]) * t;
        CandidateList found = list, wanted = expected;
        remove_distant(scene.surface, within, at, pool, found);
        remove_distant(scene.surface, within, at, pool, wanted);
        CHECK(includes(list, wanted));
        CHECK(includes(expected, found));
        near += found.size();
      }
    };
    compare(separation, [&](BroadPhase& phase, CandidateList& out) {
      phase.find_swept(x0, x1, separation, pool, out, marks);
    });
    compare(reach, [&](BroadPhase& phase, CandidateList& out) {
      // Every other time all have moved.
      if (round % 2 == 0)
        phase.find(x1, reach, pool, out);
      else
        phase.find(x1, reach, pool, out, marks);
    });
    x0 = x1;
  }
  CHECK(near > 10000);
}
