// Classification of candidate pairs into stencils, energies and forces of contacts, and energy differences
// pair by pair.
#include <doctest/doctest.h>

#include <set>

#include <stark/geometry/distance.h>
#include <support/collision_scenes.h>
#include <support/contact_potentials.h>
#include <support/random_points.h>

using namespace stark;
using namespace stark::test;

namespace {

/// Two edges, a triangle and two particles, each a group; all pairs are candidates.
CandidateList only(PairKind kind, std::vector<PrimitivePair> pairs) {
  CandidateList list;
  list[kind] = std::move(pairs);
  return list;
}

struct Stencils {
  Stencils() {
    builder.add_rod({{}, {}});                      // vertices 0, 1: group 0, edge 0
    builder.add_rod({{}, {}});                      // vertices 2, 3: group 1, edge 1
    builder.add_particles({{}});                    // vertex 4: group 2
    builder.add_particles({{}});                    // vertex 5: group 3
    builder.add_mesh({{{}, {}, {}}, {{0, 1, 2}}});  // vertices 6, 7, 8: group 4, edges 2..4, triangle 0
    geometry.mesh = &builder.surface;
    geometry.group_distance = {0.3, 0.5, 0.4, 0.2, 0.6};
    geometry.edge_squared_length.assign(5, 1.0);
    x.resize(9);
  }

  std::vector<Contact> find(const CandidateList& list) {
    std::vector<Contact> contacts;
    find_contacts(geometry, list, x, pool, contacts);
    return contacts;
  }

  SceneBuilder builder;
  ContactGeometry geometry;
  std::vector<Vec3> x;
  ThreadPool pool{1};
};

Vec3 separation(const Contact& contact, std::span<const Vec3> x) {
  Vec3 s;
  for (int p = 0; p < contact.point_count; ++p) s += x[contact.sites[p]] * contact.weights[p];
  return s;
}

/// What every contact promises, whatever its kind.
void check_contact(const Contact& contact, std::span<const Vec3> x, const SurfaceMesh& mesh,
                   double squared_distance, double tolerance) {
  CHECK(contact.distance * contact.distance == doctest::Approx(squared_distance).epsilon(1e-9));
  CHECK(std::fabs(norm(separation(contact, x)) - contact.distance) <= tolerance);
  double side_a = 0.0, side_b = 0.0;
  for (int p = 0; p < contact.point_count; ++p) {
    const bool first = p < contact.side_a_count;
    (first ? side_a : side_b) += contact.weights[p];
    CHECK(
        (first ? contact.weights[p] >= -1e-9 : contact.weights[p] <= 1e-9));  // the closest points are inside
    CHECK(mesh.vertex_group[contact.sites[p]] == (first ? contact.group_a : contact.group_b));
  }
  CHECK(side_a == doctest::Approx(1.0));
  CHECK(side_b == doctest::Approx(-1.0));
  CHECK(contact.distance < contact.contact_distance);
}

int points_of(StencilKind kind) {
  switch (kind) {
    case StencilKind::PointPoint:
      return 2;
    case StencilKind::PointEdge:
      return 3;
    default:
      return 4;
  }
}

}  // namespace

TEST_CASE("point-triangle pairs become the stencil of the closest feature") {
  Stencils s;
  RandomPoints random(1);
  std::set<StencilKind> kinds;
  for (int trial = 0; trial < 4000; ++trial) {
    for (const int v : {4, 6, 7, 8})
      s.x[v] = trial % 2 ? random.point() : random.lattice(1) * 0.5 + random.point() * 1e-3;
    if (norm(cross(s.x[7] - s.x[6], s.x[8] - s.x[6])) < 0.1) continue;
    const double squared = point_triangle_squared_distance(s.x[4], s.x[6], s.x[7], s.x[8]);
    const std::vector<Contact> found = s.find(only(PairKind::PointTriangle, {{4, 0}}));
    REQUIRE(found.size() == (squared < 1.0 ? 1 : 0));  // contact distances 0.4 + 0.6
    if (found.empty()) continue;
    CHECK(found[0].contact_distance == doctest::Approx(1.0));
    CHECK(found[0].point_count == points_of(found[0].kind));
    check_contact(found[0], s.x, s.builder.surface, squared, 1e-9);
    CHECK(found[0].sites[0] == 4);
    kinds.insert(found[0].kind);
  }
  CHECK(kinds ==
        std::set<StencilKind>{StencilKind::PointPoint, StencilKind::PointEdge, StencilKind::PointTriangle});
}

TEST_CASE("edge-edge pairs become every kind of stencil, parallel and degenerate edges included") {
  Stencils s;
  RandomPoints random(2);
  std::set<StencilKind> kinds;
  for (int trial = 0; trial < 8000; ++trial) {
    for (int v = 0; v < 4; ++v) s.x[v] = trial % 3 ? random.lattice(2) * 0.25 : random.point();
    if (trial % 5 == 0) {  // nearly parallel
      const Vec3 shift = random.point() * 0.3;
      s.x[2] = s.x[0] + shift + random.point() * 1e-6;
      s.x[3] = s.x[1] + shift + random.point() * 1e-6;
      if (trial % 2) std::swap(s.x[2], s.x[3]);
    }
    if (trial % 7 == 0) {  // crossing each other's middle at a small angle
      const Vec3 u = normalized(random.point()), n = normalized(cross(u, random.point())),
                 b = u + 0.02 * cross(n, u);
      for (int v = 0; v < 4; ++v)
        s.x[v] = (v < 2 ? u : b) * (v % 2 ? 0.5 : -0.5) + (v < 2 ? Vec3{} : n * 0.4);
    }
    const double squared = edge_edge_squared_distance(s.x[0], s.x[1], s.x[2], s.x[3]);
    if (squared < 1e-8) continue;  // touching: contact never gets there
    if (norm(s.x[1] - s.x[0]) < 0.1 || norm(s.x[3] - s.x[2]) < 0.1) continue;
    const std::vector<Contact> found = s.find(only(PairKind::EdgeEdge, {{0, 1}}));
    REQUIRE(found.size() == (squared < 0.64 ? 1 : 0));
    if (found.empty()) continue;
    const Contact& contact = found[0];
    check_contact(contact, s.x, s.builder.surface, squared, 1e-7);
    const double c = squared_norm(cross(s.x[1] - s.x[0], s.x[3] - s.x[2]));
    CHECK(contact.parallel_threshold == doctest::Approx(1e-3));
    const bool is_mollified = contact.kind >= StencilKind::MollifiedPointPoint;
    CHECK(is_mollified == (c < 1e-3));
    if (is_mollified) {
      CHECK(contact.point_count == 4);  // all four vertices carry the force of the mollifier
      CHECK(std::set<int32_t>(contact.sites.begin(), contact.sites.end()).size() == 4);
    }
    kinds.insert(contact.kind);
  }
  using enum StencilKind;
  CHECK(kinds == std::set<StencilKind>{PointPoint, PointEdge, EdgeEdge, MollifiedPointPoint,
                                       MollifiedPointEdge, MollifiedEdgeEdge});
}

TEST_CASE("particles touch rods and each other") {
  Stencils s;
  s.x[0] = {-1, 0, 0};
  s.x[1] = {1, 0, 0};
  s.x[4] = {0.5, 0, 0.1};
  s.x[5] = {0.5, 0, 0.3};
  CandidateList list = only(PairKind::PointEdge, {{4, 0}, {5, 0}});
  list[PairKind::PointPoint] = {{4, 5}};
  std::vector<Contact> found = s.find(list);
  REQUIRE(found.size() == 3);
  CHECK(found[0].kind == StencilKind::PointEdge);
  check_contact(found[0], s.x, s.builder.surface, 0.01, 1e-15);
  CHECK(found[0].weights == std::array<double, 4>{1.0, -0.25, -0.75, 0.0});
  CHECK(found[2].kind == StencilKind::PointPoint);
  check_contact(found[2], s.x, s.builder.surface, 0.04, 1e-15);
  s.x[4] = {1.1, 0, 0.1};  // past the end
  found = s.find(only(PairKind::PointEdge, {{4, 0}}));
  REQUIRE(found.size() == 1);
  CHECK(found[0].kind == StencilKind::PointPoint);
  CHECK(found[0].sites[1] == 1);
  s.x[4] = {0.5, 0, 0.71};
  CHECK(s.find(only(PairKind::PointEdge, {{4, 0}})).empty());
}

TEST_CASE("energies are kappa b(d) and forces push the sides apart along their separation") {
  Stencils s;
  RandomPoints random(3);
  CandidateList all;
  all[PairKind::PointTriangle] = {{4, 0}, {5, 0}};
  all[PairKind::EdgeEdge] = {{0, 1}, {0, 2}, {1, 3}};
  all[PairKind::PointEdge] = {{4, 0}, {5, 1}};
  all[PairKind::PointPoint] = {{4, 5}};
  ContactSet set(contact_potentials().barriers, s.pool);
  int regular = 0;
  for (int trial = 0; trial < 200; ++trial) {
    for (Vec3& x : s.x) x = random.point() * 0.5;
    std::vector<Contact> contacts = s.find(all);
    for (Contact& contact : contacts) contact.stiffness = random.uniform(1.0, 2.0);
    set.reset(contacts);
    const std::vector<double> energies = set.evaluate_energies(s.x);
    std::vector<Vec3> forces;
    set.evaluate_forces(s.x, forces);
    REQUIRE(energies.size() == contacts.size());
    for (size_t k = 0; k < contacts.size(); ++k) {
      const Contact& c = contacts[k];
      if (c.kind >= StencilKind::MollifiedPointPoint) continue;
      ++regular;
      CHECK(energies[k] ==
            doctest::Approx(c.stiffness * barrier(c.distance, c.contact_distance)).epsilon(1e-8));
      const Vec3 expected =
          separation(c, s.x) * (-c.stiffness * barrier_slope(c.distance, c.contact_distance) / c.distance);
      CHECK(norm(forces[k] - expected) <= 1e-7 * norm(expected));
    }
    // Balance: the gradients of all points of a contact sum to nothing.
    for (const PotentialBatch* batch : set.batches()) {
      const int outputs = 1 + 3 * batch->point_count();
      AlignedVector<double> out(batch->block_count() * outputs * symbolic::kLanes);
      batch->evaluate(symbolic::Order::Gradient, s.x, 0, batch->block_count(), out.data());
      for (int64_t e = 0; e < batch->size(); ++e) {
        Vec3 sum;
        double size = 0.0;
        for (int p = 0; p < batch->point_count(); ++p)
          for (int a = 0; a < 3; ++a) {
            const double g = out[((e / symbolic::kLanes) * outputs + 1 + 3 * p + a) * symbolic::kLanes +
                                 e % symbolic::kLanes];
            sum[a] += g;
            size += std::fabs(g);
          }
        CHECK(max_abs(sum) <= 1e-12 * size);
      }
    }
  }
  CHECK(regular > 300);
}

TEST_CASE("energy is continuous where edges become parallel and where the closest feature changes") {
  Stencils s;
  ContactSet set(contact_potentials().barriers, s.pool);
  const auto energy_at = [&](double angle, double shift) {
    const Vec3 b{std::cos(angle), std::sin(angle), 0};
    s.x[0] = {-0.5, 0, 0};
    s.x[1] = {0.5, 0, 0};
    s.x[2] = b * -0.5 + Vec3{shift, 0.01, 0.3};
    s.x[3] = b * 0.5 + Vec3{shift, 0.01, 0.3};
    std::vector<Contact> contacts = s.find(only(PairKind::EdgeEdge, {{0, 1}}));
    for (Contact& contact : contacts) contact.stiffness = 1.0;
    set.reset(contacts);
    return set.evaluate_energies(s.x).empty() ? 0.0 : set.energies()[0];
  };
  double largest = 0.0;
  for (int k = 0; k < 4000; ++k) {
    const double angle = -0.1 + 0.2 * k / 4000, step = 0.2 / 4000;
    const double jump = std::fabs(energy_at(angle + step, 0.3) - energy_at(angle, 0.3));
    largest = std::fmax(largest, energy_at(angle, 0.3));
    CHECK(jump < 0.01);  // the mollifier falls to zero over 630 steps of this size
    const double along =
        std::fabs(energy_at(0.05, 10.0 * angle + 10.0 * step) - energy_at(0.05, 10.0 * angle));
    CHECK(along < 0.01);
  }
  CHECK(largest > 0.1);
}

TEST_CASE("the torque of nearly parallel edges goes to zero with their angle, without a jump") {
  // The energy grows with the square of the angle. Pairs that are left out as parallel already at 1e-6 rad
  // lose a torque a thousand times what Newton's method is to resolve.
  Stencils s;
  ContactSet set(contact_potentials().barriers, s.pool);
  const auto energy_at = [&](double angle) {
    const Vec3 b{std::cos(angle), std::sin(angle), 0};
    s.x[0] = {-0.5, 0, 0};
    s.x[1] = {0.5, 0, 0};
    s.x[2] = b * -0.5 + Vec3{0.3, 0.01, 0.3};
    s.x[3] = b * 0.5 + Vec3{0.3, 0.01, 0.3};
    std::vector<Contact> contacts = s.find(only(PairKind::EdgeEdge, {{0, 1}}));
    for (Contact& contact : contacts) contact.stiffness = 1.0;
    merge_equal_stencils(s.x, contacts);
    set.reset(contacts);
    return set.evaluate_energies(s.x).empty() ? 0.0 : set.energies()[0];
  };
  const double curvature = energy_at(1e-4) / 1e-8;
  CHECK(curvature > 0.0);
  for (const double angle : {1e-5, 1e-6, 1e-7, 1e-8, 1e-9})
    CHECK(energy_at(angle) / (angle * angle) == doctest::Approx(curvature).epsilon(1e-3));
  CHECK(energy_at(0.0) == 0.0);
}

TEST_CASE("contacts come in the order of the lists, whatever the number of threads") {
  Stencils s;
  RandomPoints random(4);
  SceneBuilder cloud;
  std::vector<Vec3> points;
  for (int k = 0; k < 200; ++k) points.push_back(random.point());
  const int32_t group = cloud.add_particles(points);
  ContactGeometry geometry{&cloud.surface, {}, {}};
  geometry.group_distance.assign(group + 1, 0.1);
  CandidateList list;
  for (int32_t a = 0; a < 200; ++a)
    for (int32_t b = a + 1; b < 200; ++b) list[PairKind::PointPoint].push_back({a, b});
  std::vector<Contact> one, five;
  ThreadPool pool(5);
  find_contacts(geometry, list, cloud.x, s.pool, one);
  find_contacts(geometry, list, cloud.x, pool, five);
  REQUIRE(one.size() == five.size());
  CHECK(one.size() > 20);
  for (size_t k = 0; k < one.size(); ++k) {
    CHECK(one[k].key == five[k].key);
    if (k > 0) CHECK(one[k - 1].key < one[k].key);
  }
}

TEST_CASE("energy differences match pairs by identity; pairs that appear or vanish count from zero") {
  Stencils s;
  const auto contact = [](int32_t first, double kappa) {
    Contact c;
    c.key = {PairKind::PointPoint, first, first + 1};
    c.sites = {first, first + 1, 0, 0};
    c.weights = {1, -1, 0, 0};
    c.contact_distance = 1.0;
    c.stiffness = kappa;
    return c;
  };
  std::vector<Vec3> xa, xb;
  for (int k = 0; k < 8; ++k) {
    xa.push_back({0.2 * k, 0, 0});
    xb.push_back({0.3 * k, 0, 0});
  }
  ContactSet a(contact_potentials().barriers, s.pool), b(contact_potentials().barriers, s.pool);
  a.reset({contact(0, 1.0), contact(1, 2.0), contact(4, 3.0)});
  b.reset({contact(1, 2.0), contact(2, 5.0), contact(4, 3.0), contact(6, 7.0)});
  a.evaluate_energies(xa);
  b.evaluate_energies(xb);
  const double Ea = barrier(0.2, 1.0), Eb = barrier(0.3, 1.0);
  const EnergyDifference difference = energy_difference(a, b);
  CHECK(difference.difference ==
        doctest::Approx((2.0 + 5.0 + 3.0 + 7.0) * Eb - (1.0 + 2.0 + 3.0) * Ea).epsilon(1e-12));
  CHECK(difference.magnitude == doctest::Approx(6.0 * Ea).epsilon(1e-12));
  CHECK(energy_difference(a, a).difference == 0.0);
}
