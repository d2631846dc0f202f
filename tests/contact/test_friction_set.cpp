// Friction of contacts: Coulomb's force in slip, none at rest, against the motion, independent of normal
// motion.
#include <doctest/doctest.h>

#include <support/contact_potentials.h>
#include <support/random_points.h>

using namespace stark;
using namespace stark::test;
using symbolic::kLanes;

namespace {

constexpr double kMu = 0.4, kStickVelocity = 0.01, kStep = 0.05;  ///< [1], [m/s], [s]: sticks below 0.5 mm

/// A contact of 2, 3 or 4 points with normal force `force` on side A.
Contact contact_of(int points) {
  Contact contact;
  contact.key = {0, 0, points};
  contact.point_count = static_cast<int8_t>(points);
  contact.sites = {0, 1, 2, 3};
  contact.weights = points == 2   ? std::array<double, 4>{1, -1, 0, 0}
                    : points == 3 ? std::array<double, 4>{1, -0.3, -0.7, 0}
                                  : std::array<double, 4>{1, -0.2, -0.3, -0.5};
  contact.group_a = 1;
  contact.group_b = 2;
  return contact;
}

double coefficient(int32_t a, int32_t b) { return a == 1 && b == 2 ? kMu : 1e9; }

FrictionSet make_set() { return {contact_potentials().frictions, kStickVelocity}; }

/// Gradients of all elements, added by site [N].
std::vector<Vec3> gradients(const FrictionSet& set, std::span<const Vec3> x) {
  std::vector<Vec3> g(x.size());
  for (const PotentialBatch* batch : set.batches()) {
    const int outputs = 1 + 3 * batch->point_count();
    AlignedVector<double> out(batch->block_count() * outputs * kLanes);
    batch->evaluate(symbolic::Order::Gradient, x, 0, batch->block_count(), out.data());
    for (int64_t e = 0; e < batch->size(); ++e)
      for (int p = 0; p < batch->point_count(); ++p)
        for (int c = 0; c < 3; ++c)
          g[batch->stencil(e)[p]][c] += out[((e / kLanes) * outputs + 1 + 3 * p + c) * kLanes + e % kLanes];
  }
  return g;
}

}  // namespace

TEST_CASE("slipping contacts feel mu lambda against the slip, sticking ones less, resting ones nothing") {
  RandomPoints random(1);
  for (int points = 2; points <= 4; ++points)
    for (int trial = 0; trial < 20; ++trial) {
      CAPTURE(points);
      std::vector<Vec3> start;
      for (int p = 0; p < 4; ++p) start.push_back(random.point());
      const Vec3 n = normalized(random.point()), force = n * random.uniform(1.0, 20.0);
      const double limit = kMu * norm(force);
      FrictionSet set = make_set();
      CHECK(set.empty());
      set.reset({contact_of(points)}, std::vector<Vec3>{force}, coefficient, start, kStep);
      CHECK_FALSE(set.empty());
      const Contact contact = contact_of(points);
      // At rest.
      for (const Vec3& g : gradients(set, start)) CHECK(norm(g) < 1e-12 * limit);
      // Slip of 2 mm, with normal motion that must not matter.
      const Vec3 t = normalized(cross(n, random.point()));
      std::vector<Vec3> x = start;
      x[0] += t * 2e-3 + n * random.uniform(-0.1, 0.1);
      std::vector<Vec3> g = gradients(set, x);
      for (int p = 0; p < points; ++p) CHECK(norm(g[p] - t * (limit * contact.weights[p])) < 1e-9 * limit);
      // A common motion of all points is none.
      for (Vec3& p : x) p += {0.3, 0.2, -0.1};
      const std::vector<Vec3> same = gradients(set, x);
      for (int p = 0; p < points; ++p) CHECK(norm(same[p] - g[p]) < 1e-9 * limit);
      // Sticking: y of eps = stick velocity times step; force (2 y - y^2) of the limit [Li et al. 2020, eq.
      // 18].
      x = start;
      const double y = random.uniform(0.05, 0.95);
      x[0] += t * (y * kStickVelocity * kStep);
      g = gradients(set, x);
      CHECK(norm(g[0] - t * (limit * (2.0 * y - y * y))) < 1e-9 * limit);
    }
}

TEST_CASE("friction reports how much its strengths changed") {
  FrictionSet set = make_set();
  const std::vector<Vec3> start{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  const std::vector<Contact> one{contact_of(2)}, two{contact_of(2), contact_of(3)};
  const auto reset = [&](const std::vector<Contact>& contacts, std::vector<Vec3> forces) {
    return set.reset(contacts, forces, coefficient, start, kStep);
  };
  CHECK(reset(one, {{0, 0, 10}}) == doctest::Approx(4.0));  // mu lambda, from nothing
  CHECK(reset(one, {{0, 0, 10}}) == 0.0);
  CHECK(reset(one, {{0, 12, 0}}) == doctest::Approx(0.8));
  CHECK(reset(two, {{0, 12, 0}, {5, 0, 0}}) == doctest::Approx(2.0));
  CHECK(reset(one, {{0, 12, 0}}) == doctest::Approx(2.0));  // a pair that vanished
  CHECK(reset({}, {}) == doctest::Approx(4.8));
  CHECK(set.empty());
  CHECK(set.batches().empty());
}

TEST_CASE("contacts without force or without friction carry none") {
  FrictionSet set = make_set();
  const std::vector<Vec3> start(4);
  set.reset({contact_of(2)}, std::vector<Vec3>{{0, 0, 0}}, coefficient, start, kStep);
  CHECK(set.empty());
  set.reset(
      {contact_of(2)}, std::vector<Vec3>{{0, 0, 1}}, [](int32_t, int32_t) { return 0.0; }, start, kStep);
  CHECK(set.empty());
}

TEST_CASE("energy differences are those since the last remember()") {
  FrictionSet set = make_set();
  const std::vector<Vec3> start{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  set.reset({contact_of(2), contact_of(4)}, std::vector<Vec3>{{0, 0, 10}, {0, 0, 5}}, coefficient, start,
            kStep);
  std::vector<Vec3> a = start, b = start;
  a[0].x += 1e-3;
  b[0].x += 3e-3;
  set.remember(a);
  CHECK(set.energy_difference(a).difference == 0.0);
  // Both slip: energy grows by mu lambda times the distance.
  CHECK(set.energy_difference(b).difference == doctest::Approx(kMu * 15.0 * 2e-3).epsilon(1e-12));
  CHECK(set.energy_difference(b).magnitude ==
        doctest::Approx(kMu * 15.0 * 1e-3).epsilon(1e-12));  // f0 = y beyond sticking
}
