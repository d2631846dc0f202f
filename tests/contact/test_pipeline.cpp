// The contact pipeline against brute force over all pairs while bodies move at random, and certified steps
// against dense sampling of the motion.
#include <doctest/doctest.h>

#include <algorithm>

#include <stark/base/rotation.h>
#include <stark/collision/intersection.h>
#include <stark/geometry/distance.h>
#include <stark/geometry/shapes.h>
#include <support/collision_scenes.h>
#include <support/contact_potentials.h>
#include <support/random_points.h>

using namespace stark;
using namespace stark::test;

namespace {

constexpr double kStickDisplacement = 1e-5;  // [m]

/// Two balls, a sheet and some particles; every vertex is a free point.
struct Bench {
  explicit Bench(int threads = 1) : pool(threads) {
    const int32_t ball = builder.add_mesh(make_icosphere(0.1, 1), {0, 0, 0.13});
    builder.add_mesh(make_icosphere(0.08, 1), {0.2, 0.02, 0.1});
    builder.add_mesh(make_grid(0.5, 0.5, 8, 8));
    builder.add_particles({{-0.1, -0.1, 0.05}, {-0.12, -0.1, 0.05}, {0.1, 0.15, -0.04}});
    filter = PairFilter(builder.group_count);
    filter.set(ball, ball, false);
    distance = {0.01, 0.02, 0.015, 0.03};
    std::vector<Site> sites;
    for (int32_t v = 0; v < builder.surface.vertex_count; ++v)
      sites.push_back({.kind = SiteKind::Point, .index = v, .local = {}, .points = {}, .weights = {}});
    map = KinematicMap(DofLayout::build(std::vector<bool>(sites.size(), false), {}), sites);
    pipeline = std::make_unique<ContactPipeline>(
        ContactSurfaces{builder.surface, filter, distance, builder.x, [](int32_t, int32_t) { return 0.3; }},
        contact_potentials(), ContactSettings{}, kStickDisplacement, map, pool, timer);
    geometry = {.mesh = &builder.surface, .group_distance = distance, .edge_squared_length = {}};
    geometry.edge_ranges =
        std::make_shared<const EdgeRanges>(pipeline->law().areas().edge_ranges(builder.surface));
    cells = SurfaceCells(builder.surface, {});
    for (const Index2& e : builder.surface.edges)
      geometry.edge_squared_length.push_back(squared_norm(builder.x[e[1]] - builder.x[e[0]]));
  }

  void begin_step(std::span<const Vec3> x) {
    pipeline->begin_step(x, {.positions = x, .duration = 0.01, .step = 0.01}, {});
  }

  /// Contacts among all pairs of primitives, found without any broad phase.
  std::vector<Contact> brute_force(std::span<const Vec3> x) {
    const SurfaceMesh& mesh = builder.surface;
    CandidateList all;
    const auto shared = [](const auto& a, const auto& b) {
      for (const int32_t i : a)
        for (const int32_t j : b)
          if (i == j) return true;
      return false;
    };
    const int32_t first_particle = mesh.points.front();
    for (int32_t p = 0; p < mesh.vertex_count; ++p)
      for (int32_t t = 0; t < static_cast<int32_t>(mesh.triangles.size()); ++t)
        if (filter.allowed(mesh.vertex_group[p], mesh.triangle_group[t]) &&
            !shared(std::array{p}, mesh.triangles[t]))
          all[PairKind::PointTriangle].push_back({p, t});
    for (int32_t a = 0; a < static_cast<int32_t>(mesh.edges.size()); ++a)
      for (int32_t b = a + 1; b < static_cast<int32_t>(mesh.edges.size()); ++b)
        if (filter.allowed(mesh.edge_group[a], mesh.edge_group[b]) && !shared(mesh.edges[a], mesh.edges[b]))
          all[PairKind::EdgeEdge].push_back({a, b});
    for (int32_t a = first_particle; a < mesh.vertex_count; ++a)
      for (int32_t b = a + 1; b < mesh.vertex_count; ++b) all[PairKind::PointPoint].push_back({a, b});
    std::vector<Contact> contacts;
    find_contacts(geometry, all, x, pool, contacts);
    contacts = merge_by_feature(geometry, cells, pipeline->names(), x, contacts, pool);
    ContactLaw law = pipeline->law();
    law.assign(builder.surface, x, pool, contacts);
    merge_equal_stencils(x, contacts);
    return contacts;
  }

  /// Every group moved as a whole, plus noise of its vertices.
  std::vector<Vec3> moved(std::span<const Vec3> x, RandomPoints& random, double shift, double noise) const {
    std::vector<Vec3> shifts, y(x.begin(), x.end());
    for (int g = 0; g < builder.group_count; ++g) shifts.push_back(random.point() * shift);
    for (size_t v = 0; v < y.size(); ++v)
      y[v] += shifts[builder.surface.vertex_group[v]] + random.point() * noise;
    return y;
  }

  SceneBuilder builder;
  PairFilter filter;
  std::vector<double> distance;
  ThreadPool pool;
  PhaseTimer timer;
  KinematicMap map;
  ContactGeometry geometry;
  SurfaceCells cells;
  std::unique_ptr<ContactPipeline> pipeline;
};

bool same_contacts(const std::vector<Contact>& a, const std::vector<Contact>& b) {
  if (a.size() != b.size()) return false;
  for (size_t k = 0; k < a.size(); ++k)
    if (a[k].key != b[k].key || a[k].kind != b[k].kind || a[k].distance != b[k].distance ||
        !std::equal(a[k].sites.begin(), a[k].sites.begin() + a[k].point_count, b[k].sites.begin()))
      return false;
  return true;
}

double smallest_distance(const std::vector<Contact>& contacts) {
  double smallest = std::numeric_limits<double>::infinity();
  for (const Contact& contact : contacts) smallest = std::min(smallest, contact.distance);
  return smallest;
}

}  // namespace

TEST_CASE("no contact is missed while bodies move, whether the candidate list is reused or built anew") {
  Bench bench;
  RandomPoints random(1);
  bench.begin_step(bench.builder.x);
  std::vector<Vec3> x = bench.builder.x;
  size_t most = 0;
  int updates = 0;
  for (const double size : {2e-4, 1e-3, 5e-3, 3e-2})
    for (int n = 0; n < 12; ++n, ++updates) {
      x = bench.moved(x, random, size, 0.3 * size);
      bench.pipeline->update(x);
      const std::vector<Contact> expected = bench.brute_force(x);
      REQUIRE(same_contacts(bench.pipeline->contacts(), expected));
      CHECK(bench.pipeline->nearness(x).distance == smallest_distance(expected));
      most = std::max(most, expected.size());
      if (n % 4 == 3) x = bench.builder.x;  // back, so that the bodies stay close
    }
  CHECK(most > 50);
  CHECK(bench.pipeline->counters().candidate_builds < updates - 12);  // small motions reused the list
}

TEST_CASE("a list is built anew as soon as its motion budget is used up") {
  // Two particles with a contact distance of 0.06 m and a budget of 0.015 m each: lists hold pairs within
  // 0.09 m.
  Bench bench;
  std::vector<Vec3> x = bench.builder.x;
  const int32_t a = bench.builder.surface.points[0], b = bench.builder.surface.points[1];
  x[a] = {0, 0, 2.0};
  x[b] = {0, 0, 2.1};
  bench.begin_step(x);
  bench.pipeline->update(x);
  REQUIRE(bench.pipeline->contacts().size() == bench.brute_force(x).size());
  const std::vector<Vec3> start = x;
  x[a].z += 0.022;
  x[b].z -= 0.022;
  SUBCASE("by an update") { bench.pipeline->update(x); }
  SUBCASE("by a step") {
    bench.pipeline->max_step(start, x);
    bench.pipeline->update(x);
  }
  CHECK(same_contacts(bench.pipeline->contacts(), bench.brute_force(x)));
  CHECK(std::any_of(bench.pipeline->contacts().begin(), bench.pipeline->contacts().end(),
                    [&](const Contact& contact) {
                      return contact.key == PairKey{PairKind::PointPoint, std::min(a, b), std::max(a, b)};
                    }));
}

TEST_CASE("energy differences of trial points agree with brute force, near and far from the iterate") {
  Bench bench;
  RandomPoints random(2);
  ContactSet set_a(contact_potentials().barriers, bench.pool),
      set_b(contact_potentials().barriers, bench.pool);
  for (const double size : {1e-4, 3e-3, 2e-2}) {
    const std::vector<Vec3> a = bench.moved(bench.builder.x, random, 1e-3, 1e-4),
                            b = bench.moved(a, random, size, 0.1 * size);
    bench.begin_step(a);
    bench.pipeline->update(a);
    const auto fill = [&](ContactSet& set, std::span<const Vec3> x) {
      set.reset(bench.brute_force(x));
      set.evaluate_energies(x);
    };
    fill(set_a, a);
    const EnergyDifference found = bench.pipeline->energy_difference(b);
    fill(set_b, b);  // with the areas that the pipeline saw first
    const EnergyDifference expected = energy_difference(set_a, set_b);
    // Friction, lagged at a, adds its own part; its elements are the last batches.
    FrictionSet friction(contact_potentials().friction, kStickDisplacement, bench.pool);
    std::vector<Vec3> forces;
    set_a.evaluate_forces(a, forces);
    for (size_t c = 0; c < forces.size(); ++c)
      if (set_a.contacts()[c].multiplicity < 0) forces[c] = {};  // without friction
    friction.begin_step(bench.pipeline->mesh(), {}, a, {a, 1.0});
    friction.reset(set_a.contacts(), forces, [](int32_t, int32_t) { return 0.3; }, a);
    friction.remember(a);
    const EnergyDifference slip = friction.energy_difference(b);
    CHECK(found.difference == doctest::Approx(expected.difference + slip.difference).epsilon(1e-9));
    CHECK(found.magnitude == doctest::Approx(expected.magnitude + slip.magnitude).epsilon(1e-9));
    CHECK(expected.difference != 0.0);
  }
}

TEST_CASE("certified steps never lead through anything") {
  Bench bench;
  RandomPoints random(3);
  int limited = 0, free_steps = 0;
  std::vector<Vec3> x = bench.builder.x;
  bench.begin_step(x);
  for (int n = 0; n < 60; ++n) {
    const double size = std::pow(10.0, random.uniform(-4.0, 0.7));  // up to 5 m: fifty times the bodies
    const std::vector<Vec3> x1 = bench.moved(x, random, size, 0.2 * size);
    const double alpha = bench.pipeline->max_step(x, x1);
    REQUIRE(alpha >= 0.0);
    REQUIRE(alpha <= 1.0);
    (alpha < 1.0 ? limited : free_steps) += 1;
    std::vector<Vec3> y(x.size());
    for (int k = 1; k <= 20; ++k) {
      const double t = alpha * k / 20.0;
      for (size_t v = 0; v < x.size(); ++v) y[v] = x[v] + (x1[v] - x[v]) * t;
      REQUIRE(find_intersections(bench.builder.surface, y, bench.filter, bench.pool).empty());
    }
    // The next step starts somewhere on the certified path, or afresh.
    if (n % 5 == 4)
      x = bench.builder.x;
    else
      for (size_t v = 0; v < x.size(); ++v) x[v] += (x1[v] - x[v]) * (0.5 * alpha);
    bench.pipeline->update(x);
  }
  CHECK(limited > 20);
  CHECK(free_steps > 5);
  CHECK(bench.pipeline->counters().swept_builds > 0);
}

TEST_CASE("a head-on approach is stopped before the touch and not long before it") {
  Bench bench;
  bench.begin_step(bench.builder.x);
  // The first ball, 0.03 m above the sheet, moves straight down by 1 m.
  std::vector<Vec3> x1 = bench.builder.x;
  for (size_t v = 0; v < x1.size(); ++v)
    if (bench.builder.surface.vertex_group[v] == 0) x1[v].z -= 1.0;
  double lowest = 1.0;
  for (size_t v = 0; v < x1.size(); ++v)
    if (bench.builder.surface.vertex_group[v] == 0) lowest = std::min(lowest, bench.builder.x[v].z);
  const double alpha = bench.pipeline->max_step(bench.builder.x, x1);
  CHECK(alpha < lowest);
  CHECK(alpha > 0.85 * lowest);
  CHECK(bench.pipeline->limiting_pair().step == alpha);
}

TEST_CASE("the pipeline has the same bits on any number of threads and whatever came before") {
  std::vector<double> steps, differences;
  std::vector<Contact> contacts;
  for (const int threads : {1, 2, 5}) {
    Bench bench(threads);
    RandomPoints random(4);
    std::vector<Vec3> a = bench.moved(bench.builder.x, random, 1e-3, 1e-4),
                      b = bench.moved(a, random, 5e-3, 1e-3);
    bench.begin_step(a);
    bench.pipeline->update(a);
    if (threads == 2) {  // a detour: candidate lists are a matter of history, results are not
      bench.pipeline->max_step(a, bench.moved(a, random, 1.0, 0.0));
      bench.pipeline->update(bench.moved(a, random, 3e-2, 1e-3));
      bench.begin_step(a);
      bench.pipeline->update(a);
    }
    const double step = bench.pipeline->max_step(a, b),
                 difference = bench.pipeline->energy_difference(b).difference;
    if (threads == 1) {
      steps = {step};
      differences = {difference};
      contacts = bench.pipeline->contacts();
    }
    CHECK(step == steps[0]);
    CHECK(difference == differences[0]);
    CHECK(same_contacts(bench.pipeline->contacts(), contacts));
    for (size_t k = 0; k < contacts.size(); ++k)
      CHECK(bench.pipeline->contacts()[k].stiffness == contacts[k].stiffness);
  }
}
