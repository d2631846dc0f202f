// Pairs within reach, four at a time, against their distances one by one.
#include <doctest/doctest.h>

#include <stark/collision/broad_phase.h>
#include <stark/collision/distant_pairs.h>
#include <stark/geometry/shapes.h>
#include <support/collision_scenes.h>
#include <support/random_points.h>

using namespace stark;
using namespace stark::test;

TEST_CASE("candidates within reach stay, those beyond it go") {
  RandomPoints random(36);
  SceneBuilder scene;
  scene.add_mesh(make_grid(1.0, 1.0, 9, 9));
  scene.add_mesh(make_icosphere(0.2, 2), {0.1, 0.2, 0.22});
  scene.add_mesh(make_box({0.2, 0.2, 0.2}), {-0.3, 0.1, 0.13});
  std::vector<Vec3> rod, particles;
  for (int k = 0; k < 20; ++k) rod.push_back(random.point() * 0.2);
  for (int k = 0; k < 40; ++k) particles.push_back(random.point() * 0.15);
  scene.add_rod(rod);
  scene.add_particles(particles);
  const SurfaceMesh& mesh = scene.surface;
  BroadPhase broad_phase;
  broad_phase.reset(mesh, PairFilter(scene.group_count));
  const std::vector<double> reach = {0.03, 0.02, 0.04, 0.05, 0.06};
  ThreadPool pool(2);
  int64_t all = 0, kept = 0;
  for (int round = 0; round < 6; ++round) {
    std::vector<Vec3> x = scene.x;
    // On a lattice many are parallel, coplanar, or at the rim to the last bit.
    for (Vec3& v : x) v += round < 3 ? random.point() * 0.02 : random.lattice(1) * 0.01;
    CandidateList list, expected;
    broad_phase.find(x, reach, pool, list);
    all += list.size();
    for_each_pair_kind([&](auto kind) {
      using Row = PairRow<kind.value>;
      for (const PrimitivePair& pair : list[kind]) {
        const PrimitivePair groups = Row::groups(mesh, pair);
        const double limit = reach[groups.first] + reach[groups.second];
        if (Row::squared_distance(Row::positions(mesh, pair, x)) <= limit * limit)
          expected[kind].push_back(pair);
      }
      CHECK(expected[kind].size() > 0);
    });
    remove_distant(mesh, reach, x, pool, list);
    CHECK(list == expected);
    kept += list.size();
  }
  CHECK(2 * kept < all);
}
