// Distances of groups are used up by relative motion only, and pairs that come near are found whatever was
// learnt before.
#include <doctest/doctest.h>

#include <stark/base/rotation.h>
#include <stark/collision/broad_phase.h>
#include <stark/collision/bvh.h>
#include <stark/collision/distant_pairs.h>
#include <stark/collision/group_clearances.h>
#include <stark/geometry/shapes.h>
#include <support/collision_scenes.h>
#include <support/random_points.h>

using namespace stark;
using detail::GroupClearances;
using test::includes;
using test::RandomPoints;
using test::SceneBuilder;

namespace {

Bounds displacement(const Vec3& low, const Vec3& high) {
  Bounds bounds;
  bounds.add(low);
  bounds.add(high);
  return bounds;
}

}  // namespace

TEST_CASE("motion that groups share uses up nothing, relative motion what it is") {
  GroupClearances clearances;
  CHECK(clearances.empty());
  CHECK_FALSE(clearances.are_apart(0, 1, 0.0, {}, {}));
  clearances.set(1, 0, 0.5);
  CHECK(clearances.are_apart(0, 1, 0.499, {}, {}));
  CHECK_FALSE(clearances.are_apart(0, 1, 0.5, {}, {}));
  CHECK_FALSE(clearances.are_apart(0, 2, 0.1, {}, {}));

  const Bounds still = displacement({}, {});
  const Vec3 far{30.0, -20.0, 10.0};
  const std::vector<Bounds> none(3, still), together(3, displacement(far, far));
  CHECK(clearances.are_apart(0, 1, 0.499, none, together));
  clearances.move(together);
  CHECK(clearances.are_apart(0, 1, 0.499, {}, {}));

  // 0.36 and 0.5 apart at most, in some corner.
  const std::vector<Bounds> near = {still, displacement({0.0, -0.1, 0.0}, {0.2, 0.3, 0.0})};
  const std::vector<Bounds> nearer = {still, displacement({-0.3, -0.1, 0.0}, {0.2, 0.4, 0.0})};
  CHECK(clearances.are_apart(0, 1, 0.0, none, near));
  CHECK(clearances.are_apart(0, 1, 0.0, near, none));
  CHECK_FALSE(clearances.are_apart(0, 1, 0.0, none, nearer));
  CHECK_FALSE(clearances.are_apart(0, 1, 0.0, nearer, none));
  clearances.move(near);
  CHECK(clearances.are_apart(0, 1, 0.13, {}, {}));
  CHECK_FALSE(clearances.are_apart(0, 1, 0.15, {}, {}));
  clearances.move(nearer);
  CHECK(clearances.empty());
}

TEST_CASE("groups that were apart are found when they come near, however they move") {
  RandomPoints random(41);
  SceneBuilder scene;
  for (int k = 0; k < 6; ++k) scene.add_mesh(make_icosphere(0.1, 2), random.point() * 0.3);
  for (int k = 0; k < 3; ++k) scene.add_mesh(make_box({0.3, 0.05, 0.05}, 4), random.point() * 0.3);
  scene.add_mesh(make_grid(0.6, 0.6, 8, 8));
  scene.add_mesh(make_grid(4.0, 4.0, 1, 1), {0, 0, -0.4});
  const SurfaceMesh& mesh = scene.surface;
  PairFilter filter(scene.group_count, true, false);
  filter.set(0, 1, false);
  const std::vector<double> reach(scene.group_count, 0.004), separation(scene.group_count, 1e-4);
  BroadPhase experienced;
  experienced.reset(mesh, filter);
  ThreadPool pool(2);
  std::vector<Vec3> velocity(scene.group_count), spin(scene.group_count);
  int64_t near = 0;
  for (int round = 0; round < 120; ++round) {
    for (int g = 0; round % 20 == 0 && g < scene.group_count; ++g) {
      velocity[g] = random.point() * (g % 3 == 0 ? 0.0 : 0.02);
      spin[g] = random.point() * (g % 2 == 0 ? 0.0 : 0.05);
    }
    std::vector<Vec3> x0 = scene.x, x1 = scene.x;
    for (size_t v = 0; v < x1.size(); ++v) {
      const int32_t g = mesh.vertex_group[v];
      x1[v] = exp_rotation(spin[g]) * x0[v] + velocity[g];
    }
    const auto fresh_list = [&](auto&& find) {
      BroadPhase fresh;
      fresh.reset(mesh, filter);
      CandidateList list;
      find(fresh, list);
      return list;
    };
    CandidateList list;
    const auto find = [&](BroadPhase& phase, CandidateList& out) { phase.find(x0, reach, pool, out); };
    find(experienced, list);
    CandidateList expected = fresh_list(find);
    CHECK(includes(expected, list));
    remove_distant(mesh, reach, x0, pool, list);
    remove_distant(mesh, reach, x0, pool, expected);
    CHECK(list == expected);
    near += list.size();

    const auto sweep = [&](BroadPhase& phase, CandidateList& out) {
      phase.find_swept(x0, x1, separation, pool, out);
    };
    sweep(experienced, list);
    expected = fresh_list(sweep);
    CHECK(includes(expected, list));
    for (const double t : {0.25, 0.5, 0.75, 1.0}) {
      std::vector<Vec3> at(x0.size());
      for (size_t v = 0; v < at.size(); ++v) at[v] = x0[v] + (x1[v] - x0[v]) * t;
      CandidateList near_on_way = expected;
      remove_distant(mesh, separation, at, pool, near_on_way);
      CHECK(includes(list, near_on_way));
    }
    scene.x = x1;
  }
  CHECK(near > 1000);
}

TEST_CASE("groups whose boxes overlap are not looked at while they are known to be apart") {
  // Rods along the diagonal of the same cube, 0.14 apart.
  SceneBuilder scene;
  for (const double y : {0.0, 0.2}) {
    std::vector<Vec3> rod;
    for (int k = 0; k <= 100; ++k) rod.push_back({0.01 * k, y + 0.01 * k, 0.01 * k});
    scene.add_rod(rod);
  }
  const std::vector<double> inflation(2, 0.005);
  ThreadPool pool(2);
  detail::Bvh bvh;
  bvh.reset(scene.surface, 2);
  std::vector<Vec3> x = scene.x;
  const auto looked_at = [&](const Vec3& both, const Vec3& second, bool on_way) {
    const PairFilter filter(2, true, false);
    std::vector<Vec3> goal = x;
    for (size_t v = 0; v < goal.size(); ++v) goal[v] += both + (v > 100 ? second : Vec3{});
    const auto nothing = [](int, const detail::Cell&, const detail::Cell&, bool) {};
    if (on_way) {
      bvh.refit(x, goal, inflation, pool);
      bvh.for_each_pair<detail::MovingBox>(filter, pool, nothing);
      return bvh.looked_at();
    }
    x = goal;
    bvh.refit(x, inflation, pool);
    bvh.for_each_pair<detail::Box>(filter, pool, nothing);
    bvh.learn_clearances(pool);
    return bvh.looked_at();
  };
  CHECK(looked_at({}, {}, false) == 1);
  CHECK(looked_at({}, {}, false) == 0);
  CHECK(looked_at({7, 8, 9}, {0, 0, 0.05}, false) == 0);
  CHECK(looked_at({1, 1, 1}, {0, 0, 0.05}, true) == 0);
  CHECK(looked_at({}, {0, 0.05, 0.07}, false) == 1);  // beyond what was known
  CHECK(looked_at({}, {0, 0, 1.0}, true) == 1);
  CHECK(looked_at({}, {0, -0.01, 0}, false) == 0);
}
