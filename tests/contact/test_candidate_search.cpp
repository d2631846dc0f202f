// Lists that are renewed where sites have moved, against a search for everything.
#include <doctest/doctest.h>

#include <algorithm>

#include <stark/collision/broad_phase.h>
#include <stark/collision/distant_pairs.h>
#include <stark/collision/max_safe_step.h>
#include <stark/contact/candidate_search.h>
#include <stark/geometry/shapes.h>
#include <support/collision_scenes.h>
#include <support/random_points.h>

using namespace stark;
using namespace stark::test;

namespace {

struct Bench {
  /// With self-contact of everything, or of the sheet alone: margins of others then follow their gaps.
  explicit Bench(bool all_self = true) {
    builder.add_mesh(make_grid(0.5, 0.5, 10, 10));
    builder.add_mesh(make_icosphere(0.1, 2), {0, 0, 0.12});
    builder.add_mesh(make_box({0.1, 0.1, 0.1}, 2), {0.2, 0.1, 0.07});
    builder.add_rod({{-0.2, -0.2, 0.02}, {-0.15, -0.2, 0.02}, {-0.1, -0.2, 0.02}, {-0.05, -0.2, 0.03}});
    builder.add_particles({{-0.1, -0.1, 0.05}, {-0.12, -0.1, 0.05}});
    filter = PairFilter(builder.group_count, true, all_self);
    filter.set(0, 0, true);
    reference.reset(builder.surface, filter);
  }

  /// All pairs within the sums of the groups' distances at x.
  CandidateList near(std::span<const Vec3> x) {
    CandidateList list;
    reference.find(x, distance, pool, list);
    remove_distant(builder.surface, distance, x, pool, list);
    return list;
  }

  /// Some bodies, or vertices of the sheet beyond a line, move; all by a little.
  void move(std::vector<Vec3>& x, RandomPoints& random, double size) const {
    const int group = random.integer(-1, builder.group_count - 1);
    const double line = random.uniform(-0.2, 0.2);
    const Vec3 shift = random.point() * size;
    for (size_t v = 0; v < x.size(); ++v) {
      const int32_t of = builder.surface.vertex_group[v];
      if (of == group || (group < 0 && of == 0 && x[v].x > line)) x[v] += shift;
      x[v] += random.point() * (0.02 * size);
    }
  }

  SceneBuilder builder;
  PairFilter filter;
  std::vector<double> distance = {0.012, 0.02, 0.01, 0.02, 0.03};
  ThreadPool pool{2};
  PhaseTimer timer;
  BroadPhase reference;
};

}  // namespace

TEST_CASE("no pair is missed while parts of a scene move, at iterates, trial points and between them") {
  for (const bool all_self : {true, false}) {
    Bench bench(all_self);
    RandomPoints random(61);
    CandidateSearch search(bench.builder.surface, bench.filter, bench.distance, bench.pool, bench.timer);
    const std::vector<double> none(bench.distance.size(), 0.0);
    std::vector<Vec3> x = bench.builder.x;
    int64_t most = 0;
    int limited = 0;
    for (const double size : {1e-3, 4e-3, 1e-2, 5e-2, 0.2})
      for (int n = 0; n < 40; ++n) {
        std::vector<Vec3> trial = x;
        bench.move(trial, random, size);
        if (n % 3 == 0) bench.move(trial, random, size);
        const CandidateList expected = bench.near(x), expected_trial = bench.near(trial);
        CHECK(includes(search.at(x), expected));
        // What limits the way is what limits it among all pairs of a search for everything.
        CandidateList swept;
        bench.reference.find_swept(x, trial, none, bench.pool, swept);
        const double step = search.max_safe_step(x, trial, {none}, {});
        CHECK(step == max_safe_step(bench.builder.surface, swept, x, trial, 0.0, bench.pool, nullptr));
        limited += step < 1.0;
        CHECK(includes(search.at_trial(trial), expected_trial));
        CHECK(includes(search.at(x), expected));  // that of a trial point leaves it as it is
        if (n % 2 == 0) x = trial;
        if (n % 10 == 9) x = bench.builder.x;
        most = std::max(most, expected.size());
      }
    CHECK(most > (all_self ? 200 : 100));
    CHECK(limited > 10);
  }
}

TEST_CASE("pairs of edges that cannot act are left out of the lists, and none that can act or meet is") {
  Bench bench;
  RandomPoints random(62);
  const SurfaceMesh& mesh = bench.builder.surface;
  std::vector<EdgeRanges::Edge> edges;
  for (const int32_t group : mesh.edge_group)
    edges.push_back({.flatness = group == 2 ? 0.3 : 1.0, .is_sheet = group == 0, .is_rod = group == 3});
  const auto ranges = std::make_shared<const EdgeRanges>(edges);
  std::vector<double> separation(bench.distance);
  for (double& s : separation) s *= 1e-3;
  CandidateSearch search(mesh, bench.filter, bench.distance, bench.pool, bench.timer);
  search.set_edges(ranges, separation);
  const std::vector<PrimitivePair>& distant = search.distant_edges()[PairKind::EdgeEdge];
  std::vector<Vec3> x = bench.builder.x;
  size_t acting = 0, left_out = 0;
  int limited = 0;
  for (int n = 0; n < 120; ++n) {
    std::vector<Vec3> trial = x;
    bench.move(trial, random, n % 2 == 0 ? 1e-3 : 5e-2);
    const CandidateList& list = search.at(x);
    CandidateList all = list, act = bench.near(x);
    CHECK(std::ranges::is_sorted(distant));
    all[PairKind::EdgeEdge].insert(all[PairKind::EdgeEdge].end(), distant.begin(), distant.end());
    std::ranges::sort(all[PairKind::EdgeEdge]);
    CHECK(includes(all, act));  // nothing is lost
    std::erase_if(act[PairKind::EdgeEdge], [&](const PrimitivePair& pair) {
      const double sum =
          bench.distance[mesh.edge_group[pair.first]] + bench.distance[mesh.edge_group[pair.second]];
      const double range = (*ranges)(pair.first, pair.second) * sum;
      return squared_distance(mesh, PairKind::EdgeEdge, pair, x) > range * range;
    });
    CHECK(includes(list, act));
    acting += act[PairKind::EdgeEdge].size();
    left_out += distant.size();
    CandidateList swept;
    bench.reference.find_swept(x, trial, separation, bench.pool, swept);
    const Separations kept{separation, {}};
    const double step = search.max_safe_step(x, trial, kept, {});
    CHECK(step == max_safe_step(mesh, swept, x, trial, kept, bench.pool, nullptr));
    limited += step < 1.0;
    x = n % 10 == 9 ? bench.builder.x : trial;
  }
  CHECK(acting > 50);
  CHECK(left_out > 4 * acting);
  CHECK(limited > 3);
}

TEST_CASE("what has not moved is not looked for again") {
  Bench bench;
  CandidateSearch search(bench.builder.surface, bench.filter, bench.distance, bench.pool, bench.timer);
  std::vector<Vec3> x = bench.builder.x;
  search.at(x);
  const auto count = static_cast<int64_t>(x.size());
  CHECK(search.counters().sites == count);
  CHECK(search.counters().candidate_builds == 1);
  search.at(x);
  CHECK(search.counters().candidate_builds == 1);
  // The two particles, alone.
  for (int n = 0; n < 5; ++n) {
    for (int32_t p : bench.builder.surface.points) x[p].z += 0.05;
    search.at_trial(x);
    search.at(x);
  }
  CHECK(search.counters().sites == count + 5 * 2);
  CHECK(search.counters().candidate_builds == 6);
}

TEST_CASE("what is on its way through empty space is looked for once in many steps") {
  Bench bench(false);
  CandidateSearch search(bench.builder.surface, bench.filter, bench.distance, bench.pool, bench.timer);
  std::vector<Vec3> x = bench.builder.x;
  for (size_t v = 0; v < x.size(); ++v)
    if (bench.builder.surface.vertex_group[v] == 1) x[v].z += 1.0;
  search.at(x);
  const std::vector<double> none(bench.distance.size(), 0.0);
  for (int step = 0; step < 20; ++step) {
    const std::vector<Vec3> start = x;
    for (size_t v = 0; v < x.size(); ++v)
      if (bench.builder.surface.vertex_group[v] == 1) x[v].z -= 0.01;
    search.max_safe_step(start, x, {none}, {});
    search.at(x);
  }
  CHECK(search.counters().candidate_builds <= 2);
  CHECK(search.counters().swept_builds <= 1);
}

TEST_CASE(
    "beyond what is near, collisions are looked for up to the first impact, of which the pair is named") {
  Bench bench(false);
  RandomPoints random(63);
  CandidateSearch search(bench.builder.surface, bench.filter, bench.distance, bench.pool, bench.timer);
  const std::vector<double> none(bench.distance.size(), 0.0);
  const std::vector<Vec3> x = bench.builder.x;
  search.at(x);
  int near = 0, beyond = 0;
  for (int n = 0; n < 400; ++n) {
    std::vector<Vec3> trial = x;
    bench.move(trial, random, 0.3);
    CandidateList swept;
    bench.reference.find_swept(x, trial, none, bench.pool, swept);
    CcdReport expected, found;
    max_safe_step(bench.builder.surface, swept, x, trial, 0.0, bench.pool, &expected);
    const double of_near = max_safe_step(bench.builder.surface, search.at(x), x, trial, 0.0, bench.pool);
    CHECK(search.max_safe_step(x, trial, {none}, {}, &found) == expected.step);
    CHECK(found.kind == expected.kind);
    CHECK(found.first == expected.first);
    CHECK(found.second == expected.second);
    if (of_near < 1.0) ++(of_near == expected.step ? near : beyond);
  }
  CHECK(near > 3);
  CHECK(beyond > 3);
}

TEST_CASE("what comes near is found where a body is, not where it was when all was far") {
  Bench bench(false);
  CandidateSearch search(bench.builder.surface, bench.filter, bench.distance, bench.pool, bench.timer);
  std::vector<Vec3> x = bench.builder.x;
  const auto move = [&](int32_t group, const Vec3& way) {
    for (size_t v = 0; v < x.size(); ++v)
      if (bench.builder.surface.vertex_group[v] == group) x[v] += way;
  };
  move(1, {0, 0, 2.0});  // the ball, with a radius of 0.1 m and its centre at 2.12 m
  move(2, {-0.2, -0.1, 4.0});
  search.at(x);
  move(1, {0, 0, 0.05});
  search.at(x);
  CHECK(search.counters().candidate_builds == 1);
  move(2, {0, 0, 2.12 + 0.05 + 0.1 + 0.05 + 0.002 - 4.07});  // the box, half as high as 0.1 m, onto the ball
  const CandidateList expected = bench.near(x);
  CHECK(expected.size() > 0);
  CHECK(includes(search.at(x), expected));
}
