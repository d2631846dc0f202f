// Effective stiffness of pairs: masses in series, weights of closest points, rigid bodies with levers,
// prescribed sides.
#include <doctest/doctest.h>

#include <stark/base/rotation.h>
#include <stark/contact/stiffness.h>
#include <support/contact_potentials.h>
#include <support/finite_differences.h>
#include <support/random_points.h>

using namespace stark;
using namespace stark::test;

namespace {

constexpr double kRegularised = 1e-5;  ///< the inverse blocks carry a relative shift of 3e-6

/// Points 0, 1, 2 free and 3 prescribed; rigid bodies 0 free and 1 fixed with a site each (4, 5) and a second
/// one (6) on body 0.
struct Bench {
  Bench() {
    RandomPoints random(1);
    for (int p = 0; p < 4; ++p) {
      configuration.point_position.push_back(random.point());
      sites.push_back({.kind = SiteKind::Point, .index = p, .local = {}, .points = {}, .weights = {}});
    }
    for (int b = 0; b < 2; ++b) {
      configuration.body_position.push_back(random.point());
      configuration.body_rotation.push_back(exp_rotation(random.point()));
      sites.push_back(
          {.kind = SiteKind::RigidPoint, .index = b, .local = random.point(), .points = {}, .weights = {}});
    }
    sites.push_back(
        {.kind = SiteKind::RigidPoint, .index = 0, .local = random.point(), .points = {}, .weights = {}});
    map = KinematicMap(DofLayout::build({false, false, false, true}, {false, true}), sites);
    x.resize(map.site_count());
    map.positions(configuration, x);
    for (int p = 0; p < 3; ++p) diagonal.push_back(Mat3::identity() * k[p]);
    diagonal.push_back(Mat3::identity() * k_body);
    diagonal.push_back(J_body);
  }
  Contact pair(std::vector<int32_t> s, std::vector<double> w) const {
    Contact contact;
    contact.key = {3, s[0], s[1]};
    contact.point_count = static_cast<int8_t>(s.size());
    std::copy(s.begin(), s.end(), contact.sites.begin());
    std::copy(w.begin(), w.end(), contact.weights.begin());
    contact.contact_distance = 0.01;
    return contact;
  }

  double k[3] = {2.0, 3.0, 7.0}, k_body = 5.0;  ///< m / h^2 [N/m]
  Mat3 J_body = {{4, 1, 0, 1, 3, 0.5, 0, 0.5, 2}};
  std::vector<Site> sites;
  KinematicMap map;
  Configuration configuration;
  std::vector<Vec3> x;
  std::vector<Mat3> diagonal;
};

}  // namespace

TEST_CASE("two points are in series, a prescribed side is infinitely stiff") {
  const Bench bench;
  PairStiffness stiffness(bench.map);
  stiffness.begin_step(bench.configuration, bench.diagonal, 1.0);
  CHECK(stiffness.compliance(bench.pair({0, 1}, {1, -1}), bench.x) ==
        doctest::Approx(1.0 / 2 + 1.0 / 3).epsilon(kRegularised));
  CHECK(stiffness.compliance(bench.pair({0, 3}, {1, -1}), bench.x) ==
        doctest::Approx(1.0 / 2).epsilon(kRegularised));
  CHECK(stiffness.compliance(bench.pair({3, 5}, {1, -1}), bench.x) == 0.0);
}

TEST_CASE("a pair that is prescribed altogether has no barrier and asks for none") {
  const Bench bench;
  PairStiffness stiffness(bench.map);
  stiffness.begin_step(bench.configuration, bench.diagonal, 300.0, {{1}, {10.0}});
  std::vector<Contact> contacts{bench.pair({3, 5}, {1, -1})};
  contacts[0].group_b = 1;
  stiffness.assign({}, bench.x, contacts);
  CHECK(contacts[0].stiffness == 0.0);
  const LoadMemory next = stiffness.end_step(contacts, std::vector<Vec3>{{}});
  CHECK(next.factor == std::vector<double>{9.0});  // forgotten slowly, like that of any pair without a load
}

TEST_CASE("vertices of a pair that are not its nearest points keep its stiffness within bounds") {
  // A prescribed point above a prescribed corner of a triangle, whose other corners are free; then the same
  // beside the corner, where a free one has next to no weight.
  const Bench bench;
  SurfaceMesh mesh;
  mesh.triangles = {{5, 0, 1}};
  Contact corner = bench.pair({3, 5}, {1, -1}), beside = bench.pair({3, 5, 0}, {1, -1 + 1e-9, -1e-9}),
          middle = bench.pair({3, 5, 0}, {1, -0.5, -0.5});
  corner.key = beside.key = middle.key = {0, 3, 0};
  const auto stiffness_of = [&](Contact contact) {
    PairStiffness stiffness(bench.map);
    stiffness.begin_step(bench.configuration, bench.diagonal, 300.0);
    std::vector<Contact> contacts{contact};
    stiffness.assign(mesh, bench.x, contacts);
    return contacts[0].stiffness;
  };
  // 1/2 m/N is the softest vertex, and a middle has half the weight of one.
  CHECK(stiffness_of(middle) == doctest::Approx(stiffness_of(corner) * 0.01 / 0.25).epsilon(1e-3));
  CHECK(stiffness_of(beside) == doctest::Approx(stiffness_of(corner)).epsilon(1e-3));
}

TEST_CASE("closest points inside primitives count with their squared weights") {
  const Bench bench;
  PairStiffness stiffness(bench.map);
  stiffness.begin_step(bench.configuration, bench.diagonal, 1.0);
  CHECK(stiffness.compliance(bench.pair({0, 1, 2}, {1, -0.25, -0.75}), bench.x) ==
        doctest::Approx(1.0 / 2 + 0.0625 / 3 + 0.5625 / 7).epsilon(kRegularised));
}

TEST_CASE("a rigid body has the effective mass of a point with a lever") {
  const Bench bench;
  PairStiffness stiffness(bench.map);
  stiffness.begin_step(bench.configuration, bench.diagonal, 1.0);
  const Vec3 n = normalized(bench.x[4] - bench.x[5]);
  const Vec3 r = bench.x[4] - bench.configuration.body_position[0];
  const double expected = 1.0 / 5 + dot(cross(r, n), inverse(bench.J_body) * cross(r, n));
  CHECK(stiffness.compliance(bench.pair({4, 5}, {1, -1}), bench.x) ==
        doctest::Approx(expected).epsilon(kRegularised));
  CHECK(stiffness.compliance(bench.pair({5, 4}, {1, -1}), bench.x) ==
        doctest::Approx(expected).epsilon(kRegularised));
  // Two points of one body on one side act through its one mass: the mean lever counts.
  const Vec3 middle = 0.5 * (bench.x[4] + bench.x[6]), m = normalized(bench.x[0] - middle);
  const Vec3 lever = middle - bench.configuration.body_position[0];
  CHECK(stiffness.compliance(bench.pair({0, 4, 6}, {1, -0.5, -0.5}), bench.x) ==
        doctest::Approx(1.0 / 2 + 1.0 / 5 + dot(cross(lever, m), inverse(bench.J_body) * cross(lever, m)))
            .epsilon(kRegularised));
}

TEST_CASE("elastic stiffness counts along the normal, indefinite blocks lose their negative part") {
  Bench bench;
  bench.diagonal[0] = Mat3::diagonal({100.0, 2.0, -50.0});
  bench.x[0] = {1, 0, 0};
  bench.x[3] = {0, 0, 0};
  PairStiffness stiffness(bench.map);
  stiffness.begin_step(bench.configuration, bench.diagonal, 1.0);
  CHECK(stiffness.compliance(bench.pair({0, 3}, {1, -1}), bench.x) == doctest::Approx(0.01).epsilon(1e-4));
  bench.x[0] = {0, 1, 0};
  CHECK(stiffness.compliance(bench.pair({0, 3}, {1, -1}), bench.x) == doctest::Approx(0.5).epsilon(1e-4));
  bench.x[0] = {0, 0, 1};
  const double soft = stiffness.compliance(bench.pair({0, 3}, {1, -1}), bench.x);
  CHECK(soft > 100.0);
  CHECK(std::isfinite(soft));
}

TEST_CASE("kappa makes the curvature of the barrier at half its distance `factor` over the compliance") {
  const Bench bench;
  PairStiffness stiffness(bench.map);
  stiffness.begin_step(bench.configuration, bench.diagonal, 300.0);
  std::vector<Contact> contacts{bench.pair({0, 1}, {1, -1})};
  stiffness.assign({}, bench.x, contacts);
  const double d_hat = 0.01;
  const double curvature =
      differentiate_scalar([&](double t) { return barrier_slope(0.5 * d_hat + t, d_hat); }, 0.1 * d_hat);
  CHECK(contacts[0].stiffness * curvature ==
        doctest::Approx(300.0 / (1.0 / 2 + 1.0 / 3)).epsilon(kRegularised));
}

TEST_CASE("the stiffness of a pair is frozen within a step") {
  Bench bench;
  PairStiffness stiffness(bench.map);
  stiffness.begin_step(bench.configuration, bench.diagonal, 300.0);
  std::vector<Contact> contacts{bench.pair({0, 4}, {1, -1})};
  stiffness.assign({}, bench.x, contacts);
  const double first = contacts[0].stiffness;
  std::vector<Vec3> moved = bench.x;
  moved[0] += {0.5, -0.3, 0.2};
  contacts.insert(contacts.begin(), bench.pair({1, 4}, {1, -1}));
  stiffness.assign({}, moved, contacts);
  CHECK(contacts[1].stiffness == first);
  CHECK(contacts[0].stiffness > 0.0);
  stiffness.begin_step(bench.configuration, bench.diagonal, 600.0);
  stiffness.assign({}, bench.x, contacts);
  CHECK(contacts[1].stiffness == doctest::Approx(2.0 * first));
}

namespace {

/// A step under forces on contacts of a given gap; returns what is kept and leaves the stiffness in the
/// contacts.
LoadMemory press(const Bench& bench, std::vector<Contact>& contacts, const std::vector<Vec3>& forces,
                 LoadMemory memory) {
  PairStiffness stiffness(bench.map);
  stiffness.begin_step(bench.configuration, bench.diagonal, 300.0, std::move(memory));
  stiffness.assign({}, bench.x, contacts);
  return stiffness.end_step(contacts, forces);
}

}  // namespace

TEST_CASE("a load stiffens all contacts of two bodies until it is carried at a tenth of their distance") {
  const Bench bench;
  std::vector<Contact> contacts{bench.pair({0, 3}, {1, -1}), bench.pair({1, 3}, {1, -1}),
                                bench.pair({2, 3}, {1, -1})};
  contacts[0].group_b = contacts[1].group_b = 1;
  contacts[2].group_b = 2;
  press(bench, contacts, {{}, {}, {}}, {});
  const double natural[] = {contacts[0].stiffness, contacts[1].stiffness, contacts[2].stiffness};
  const double d_hat = 0.01, at_a_tenth = -natural[0] * barrier_slope(0.1 * d_hat, d_hat);
  const std::vector<Vec3> light{{0, 0, 0.7 * at_a_tenth}, {}, {}}, heavy{{0, 0, 50.0 * at_a_tenth}, {}, {}};

  CHECK(press(bench, contacts, light, {}).bodies.empty());
  LoadMemory memory = press(bench, contacts, heavy, {});
  CHECK(memory.factor == std::vector<double>{2.0});  // no more than twice in a step
  for (int step = 0; step < 8; ++step) memory = press(bench, contacts, heavy, memory);
  REQUIRE(memory.factor.size() == 1);
  CHECK(memory.factor[0] == doctest::Approx(50.0));
  for (const int c : {0, 1}) CHECK(contacts[c].stiffness == doctest::Approx(50.0 * natural[c]));
  CHECK(contacts[2].stiffness == natural[2]);

  // A step cut short counts for its share.
  {
    PairStiffness stiffness(bench.map);
    stiffness.begin_step(bench.configuration, bench.diagonal, 300.0);
    stiffness.assign({}, bench.x, contacts);
    CHECK(stiffness.end_step(contacts, heavy, 0.5).factor[0] == doctest::Approx(std::sqrt(2.0)));
  }

  // Gone, the load is forgotten slowly, and in the end altogether.
  CHECK(press(bench, contacts, light, memory).factor[0] == doctest::Approx(45.0));
  // What is about enough stays.
  const std::vector<Vec3> a_little_less{{0, 0, 42.0 * at_a_tenth}, {}, {}};
  CHECK(press(bench, contacts, a_little_less, memory).factor[0] == memory.factor[0]);
  for (int step = 0; step < 60; ++step) memory = press(bench, contacts, light, memory);
  CHECK(memory.bodies.empty());
}

TEST_CASE("an attempt that failed raises barriers at once, by a thousand at most, and lowers none") {
  const Bench bench;
  std::vector<Contact> contacts{bench.pair({0, 3}, {1, -1})};
  press(bench, contacts, {{}}, {});
  const double at_a_tenth = -contacts[0].stiffness * barrier_slope(0.1 * 0.01, 0.01);
  const auto raised = [&](double times, LoadMemory memory) {
    PairStiffness stiffness(bench.map);
    stiffness.begin_step(bench.configuration, bench.diagonal, 300.0, std::move(memory));
    stiffness.assign({}, bench.x, contacts);
    return stiffness.raised(contacts, std::vector<Vec3>{{0, 0, times * at_a_tenth}});
  };
  CHECK(raised(0.5, {}).bodies.empty());
  const LoadMemory some = raised(50.0, {});
  REQUIRE(some.factor.size() == 1);
  CHECK(some.factor[0] == doctest::Approx(50.0));
  CHECK(raised(1e5, {}).factor[0] == doctest::Approx(1e3));
  CHECK(raised(1.0, some).factor[0] == some.factor[0]);
  CHECK(raised(1e5, raised(1e5, {})).factor[0] == doctest::Approx(1e5));
}
