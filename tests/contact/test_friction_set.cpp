// Friction of contacts: Coulomb's force in slip, none at rest, against the motion, independent of normal
// motion.
#include <doctest/doctest.h>

#include <cmath>

#include <support/contact_potentials.h>
#include <support/random_points.h>

using namespace stark;
using namespace stark::test;
using symbolic::kLanes;

namespace {

constexpr double kMu = 0.4, kStick = 5e-4;  ///< [1], [m]

/// A contact of 2, 3 or 4 points with normal force `force` on side A.
Contact contact_of(int points) {
  Contact contact;
  contact.key = {PairKind::PointTriangle, 0, points};
  contact.key = {PairKind::PointTriangle, points, 0};
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

ThreadPool pool{2};

FrictionSet make_set() { return {contact_potentials().friction, kStick, pool}; }

/// The first point is against the triangle of the others, or a part of it.
const SurfaceMesh& mesh() {
  static const SurfaceMesh mesh{.vertex_count = 4, .triangles = {{1, 2, 3}}};
  return mesh;
}

void begin(FrictionSet& set, const std::vector<Vec3>& start, FrictionMemory memory = {}) {
  set.begin_step(mesh(), std::move(memory), start, {start, 1.0});
}

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
  // Rods and edges that deform: the closest points as they are.
  const auto contact_of = [](int points) {
    Contact contact = ::contact_of(points);
    contact.key.kind = PairKind::PointPoint;
    return contact;
  };
  for (int points = 2; points <= 4; ++points)
    for (int trial = 0; trial < 20; ++trial) {
      CAPTURE(points);
      std::vector<Vec3> start;
      for (int p = 0; p < 4; ++p) start.push_back(random.point());
      const Vec3 n = normalized(random.point()), force = n * random.uniform(1.0, 20.0);
      const double limit = kMu * norm(force);
      FrictionSet set = make_set();
      CHECK(set.empty());
      begin(set, start);
      set.reset({contact_of(points)}, std::vector<Vec3>{force}, coefficient, start);
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
      // Sticking: y of the stick displacement; force (2 y - y^2) of the limit [Li et al. 2020, eq.
      // 18].
      x = start;
      const double y = random.uniform(0.05, 0.95);
      x[0] += t * (y * kStick);
      g = gradients(set, x);
      CHECK(norm(g[0] - t * (limit * (2.0 * y - y * y))) < 1e-9 * limit);
    }
}

TEST_CASE("friction reports how much its strengths changed") {
  FrictionSet set = make_set();
  const std::vector<Vec3> start{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  const std::vector<Contact> one{contact_of(2)}, two{contact_of(2), contact_of(3)};
  const auto reset = [&](const std::vector<Contact>& contacts, std::vector<Vec3> forces) {
    return set.reset(contacts, forces, coefficient, start);
  };
  begin(set, start);
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
  begin(set, start);
  set.reset({contact_of(2)}, std::vector<Vec3>{{0, 0, 0}}, coefficient, start);
  CHECK(set.empty());
  set.reset({contact_of(2)}, std::vector<Vec3>{{0, 0, 1}}, [](int32_t, int32_t) { return 0.0; }, start);
  CHECK(set.empty());
}

TEST_CASE("energy differences are those since the last remember()") {
  FrictionSet set = make_set();
  const std::vector<Vec3> start{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  begin(set, start);
  set.reset({contact_of(2), contact_of(4)}, std::vector<Vec3>{{0, 0, 10}, {0, 0, 5}}, coefficient, start);
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

TEST_CASE("a bent bristle holds its load without moving, and gives way at the limit") {
  RandomPoints random(5);
  const std::vector<Vec3> start{{0.3, 0.3, 0.1}, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  const std::vector<Contact> contacts{contact_of(4)};
  const std::vector<Vec3> force{{0, 0, 10}};
  FrictionSet set = make_set();
  begin(set, start);
  set.reset(contacts, force, coefficient, start);
  std::vector<Vec3> x = start;
  x[0] += {0.3 * kStick, 0.2 * kStick, 0.0};
  const Vec3 held = set.motions(x).at(contacts[0].key).force;
  const FrictionMemory memory = set.end_step(x);
  CHECK(memory.force == std::vector<double>{10.0});
  // The next step starts with the force that the last one ended with.
  begin(set, x, memory);
  set.reset(contacts, force, coefficient, x);
  CHECK(norm(set.motions(x).at(contacts[0].key).force - held) < 1e-12 * norm(held));
  // Sliding on, the deflection stays at its limit and points back along the slip.
  std::vector<Vec3> far = x;
  far[0] += {0.0, 50.0 * kStick, 0.0};
  const FrictionMemory slid = set.end_step(far);
  CHECK(norm(slid.deflection[0]) == doctest::Approx(kStick).epsilon(1e-12));
  CHECK(slid.deflection[0].y > 0.999 * kStick);
}

TEST_CASE("friction gives back what bristles stored at the start of the step, and no more") {
  RandomPoints random(6);
  const std::vector<Vec3> start{{0.3, 0.3, 0.1}, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  const std::vector<Contact> contacts{contact_of(4)};
  const std::vector<Vec3> force{{0, 0, 10}};
  const double limit = 10.0 * kMu;
  for (const double y : {0.0, 0.3, 1.0}) {
    FrictionMemory memory;
    memory.append(contacts[0].key, Vec3{y * kStick, 0, 0}, 10.0);
    FrictionSet set = make_set();
    begin(set, start, memory);
    set.reset(contacts, force, coefficient, start);
    // f0(y) - f0(0) of [Li et al. 2020, eq. 17].
    const double stored = limit * kStick * (y * y - y * y * y / 3.0);
    CHECK(set.energy_at_start() == doctest::Approx(stored).epsilon(1e-12));
    for (int k = 0; k < 200; ++k) {
      std::vector<Vec3> x = start;
      x[0] += random.point() * (2.0 * kStick);
      const double work = dot(gradients(set, x)[0], x[0] - start[0]);
      CHECK(work >= -stored);
    }
  }
  // Displacements that are measured as 1.5 times the motion: the energy is that of the batches.
  FrictionMemory memory;
  memory.append(contacts[0].key, Vec3{0.4 * kStick, 0, 0}, 10.0);
  FrictionSet set = make_set();
  set.begin_step(mesh(), memory, start, {start, 1.5});
  set.reset(contacts, force, coefficient, start);
  AlignedVector<double> energy(kLanes);
  set.batches()[0]->evaluate(symbolic::Order::Energy, start, 0, 1, energy.data());
  CHECK(energy[0] - limit * kStick / 4.5 == doctest::Approx(set.energy_at_start()).epsilon(1e-9));
}

TEST_CASE("deflections turn with the surface") {
  const std::vector<Vec3> start{{0.3, 0.5, 0.1}, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  const std::vector<Contact> contacts{contact_of(4)};
  FrictionSet set = make_set();
  FrictionMemory bent;
  bent.append(contacts[0].key, {0.4 * kStick, 0, 0}, 10.0);
  begin(set, start, bent);
  set.reset(contacts, std::vector<Vec3>{{0, 0, 10}}, coefficient, start);
  std::vector<Vec3> x;  // all turn by 90 degrees about the normal through the contact
  const Vec3 pivot = start[1] * 0.2 + start[2] * 0.3 + start[3] * 0.5;
  for (const Vec3& p : start) {
    const Vec3 r = p - pivot;
    x.push_back(pivot + Vec3{-r.y, r.x, r.z});
  }
  const FrictionMemory memory = set.end_step(x);
  CHECK(norm(memory.deflection[0] - Vec3{0, 0.4 * kStick, 0}) < 1e-9 * kStick);
}

TEST_CASE("sticking contact holds by the static coefficient, sliding contact by the kinetic one") {
  const auto coefficients = [](int32_t, int32_t) { return FrictionCoefficient(0.5, 0.3); };
  const std::vector<Vec3> start{{0.3, 0.3, 0.1}, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  const std::vector<Contact> contacts{contact_of(4)};
  const std::vector<Vec3> force{{0, 0, 10}};
  FrictionSet set = make_set();
  begin(set, start);
  set.reset(contacts, force, coefficients, start);
  std::vector<Vec3> x = start;
  x[0].x += 10.0 * kStick;
  CHECK(norm(set.motions(x).at(contacts[0].key).force) == doctest::Approx(5.0).epsilon(1e-12));
  CHECK(set.reset(contacts, force, coefficients, x) == doctest::Approx(2.0));  // it slides
  CHECK(norm(set.motions(x).at(contacts[0].key).force) == doctest::Approx(3.0).epsilon(1e-12));
  const FrictionMemory sliding = set.end_step(x);
  begin(set, x, sliding);
  set.reset(contacts, force, coefficients, x);
  CHECK(set.residual(contacts, force, coefficients).total().largest_change == 0.0);
  // It comes to rest: the bristle relaxes below the limit.
  std::vector<Vec3> back = x;
  back[0].x -= 0.5 * kStick;
  set.reset(contacts, force, coefficients, back);
  const LimitComparison left = set.residual(contacts, {{{0, 0, 8}}}, coefficients);
  CHECK(left.total().largest_change == doctest::Approx(1.0));
  CHECK_FALSE(left.is_settled());
}

namespace {

/// Curvature of a batch of one element along a motion of its first point [N/m], by differences.
double curvature_along(const PotentialBatch& batch, std::span<const Vec3> x, const Vec3& t) {
  constexpr double h = 1e-3 * kStick;
  std::vector<Vec3> ahead(x.begin(), x.end()), behind = ahead;
  ahead[0] += t * h;
  behind[0] += t * -h;
  return (batch.energies(ahead)[0] - 2.0 * batch.energies(x)[0] + batch.energies(behind)[0]) / (h * h);
}

void check_gradients(const PotentialBatch& model, const PotentialBatch& friction, std::span<const Vec3> x) {
  const std::vector<double> a = model.evaluate(symbolic::Order::Gradient, x),
                            b = friction.evaluate(symbolic::Order::Gradient, x);
  for (size_t i = 1; i < a.size(); ++i) CHECK(std::fabs(a[i] - b[i]) < 1e-6 * kMu * 10.0);
}

}  // namespace

TEST_CASE("models have the gradients of the energies, and at rest in a point their curvature") {
  const std::vector<Vec3> start{{0.3, 0.3, 0.1}, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  const std::vector<Vec3> axes{{1, 0, 0}, {0, 1, 0}, normalized(Vec3{1, 1, 0})};
  for (const double slip : {0.3, 0.9, 1.1, 20.0}) {
    FrictionSet set = make_set();
    begin(set, start);
    set.reset({contact_of(4)}, std::vector<Vec3>{{0, 0, 10}}, coefficient, start);
    std::vector<Vec3> x = start;
    x[0] += Vec3{0.6, 0.8, 0.0} * (slip * kStick);
    // Without a force the model is the parabola above the energy ...
    const PotentialBatch& friction = *set.batches().front();
    check_gradients(*set.models(x).front(), friction, x);
    const double largest = curvature_along(friction, x, {-0.8, 0.6, 0.0});
    for (const Vec3& t : axes)
      CHECK(curvature_along(*set.models(x).front(), x, t) == doctest::Approx(largest).epsilon(1e-6));
    // ... and with iterates that come closer to each other it becomes the energy's own.
    double way = 1e-3;
    for (int k = 0; k < 6; ++k, way *= 0.01) {
      std::vector<Vec3> y = x;
      y[0] += Vec3{0.7, -0.2, 0.0} * (way * kStick);
      check_gradients(*set.models(y).front(), friction, y);
      x = y;
    }
    for (const Vec3& t : axes)
      CHECK(curvature_along(*set.models(x).front(), x, t) ==
            doctest::Approx(curvature_along(friction, x, t)).epsilon(1e-5).scale(largest));
  }
}

TEST_CASE("models are convex on any way") {
  const std::vector<Vec3> start{{0.3, 0.3, 0.1}, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  FrictionSet set = make_set();
  begin(set, start);
  set.reset({contact_of(4)}, std::vector<Vec3>{{0, 0, 10}}, coefficient, start);
  RandomPoints random(5);
  for (int k = 0; k < 200; ++k) {
    std::vector<Vec3> x = start;
    const Vec3 away = random.point() * std::pow(10.0, k % 5 - 2.0);
    x[0] += Vec3{away.x, away.y, 0.0} * kStick;
    const PotentialBatch& model = *set.models(x).front();
    const double scale = curvature_along(model, x, {1, 0, 0}) + curvature_along(model, x, {0, 1, 0});
    for (int trial = 0; trial < 8; ++trial) {
      const double angle = 0.4 * trial;
      CHECK(curvature_along(model, x, {std::cos(angle), std::sin(angle), 0.0}) >= -1e-5 * scale);
    }
  }
}

namespace {

/// Friction 0.5 along x and 0.2 along y on the triangle of the other points, which belongs to group 2.
FrictionCoefficient anisotropic(int32_t, int32_t) {
  FrictionCoefficient mu(0.5, 0.4);
  mu.across = 0.4;
  mu.frame = 2;
  return mu;
}

FrictionSet make_anisotropic_set() {
  static const SurfaceMesh grouped{
      .vertex_count = 4, .triangles = {{1, 2, 3}}, .vertex_group = {1, 2, 2, 2}, .triangle_group = {2}};
  const TangentComponents along_x = tangent_components({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 0, 0});
  FrictionSet set{contact_potentials().friction, kStick, pool, SurfaceDirections(grouped, {along_x})};
  const std::vector<Vec3> start{{0.3, 0.3, 0.1}, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  set.begin_step(grouped, {}, start, {start, 1.0});
  Contact contact = contact_of(4);
  contact.key = {PairKind::PointTriangle, 0, 0};
  set.reset({contact}, std::vector<Vec3>{{0, 0, 10}}, anisotropic, start);
  return set;
}

}  // namespace

TEST_CASE("anisotropic friction has its axes on the surface and its limits form an ellipse") {
  const FrictionSet set = make_anisotropic_set();
  const std::vector<Vec3> start{{0.3, 0.3, 0.1}, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  for (const double angle : {0.0, 0.4, 1.0, 1.5707963267948966, 2.5}) {
    std::vector<Vec3> x = start;
    const Vec3 v{std::cos(angle), std::sin(angle), 0};
    x[0] += v * (20.0 * kStick);
    const Vec3 force = set.motions(x).at({PairKind::PointTriangle, 0, 0}).force;
    // -N M^2 v / |M v| with N = 10 N.
    const Vec3 expected = Vec3{0.25 * v.x, 0.04 * v.y, 0} * (-10.0 / std::hypot(0.5 * v.x, 0.2 * v.y));
    CHECK(norm(force - expected) < 1e-9);
    CHECK(std::hypot(force.x / 5.0, force.y / 2.0) == doctest::Approx(1.0).epsilon(1e-9));
    // What is remembered is on the ellipse of deflections and points along the slip.
    const Vec3 a = set.end_step(x).deflection[0];
    CHECK(std::hypot(a.x, 0.4 * a.y) == doctest::Approx(kStick).epsilon(1e-9));
    CHECK(norm(cross(a, v)) < 1e-9 * kStick);
  }
}

TEST_CASE("models of anisotropic friction have its gradients, and its curvature once they know its force") {
  FrictionSet set = make_anisotropic_set();
  const std::vector<Vec3> start{{0.3, 0.3, 0.1}, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  for (const double slip : {0.3, 0.9, 4.0}) {
    std::vector<Vec3> x = start;
    x[0] += Vec3{0.5, -0.9, 0} * (slip * kStick);
    const PotentialBatch& friction = *set.batches().front();
    double way = 1e-2;
    for (int k = 0; k < 6; ++k, way *= 0.01) {
      check_gradients(*set.models(x).front(), friction, x);
      x[0] += Vec3{0.7, 0.2, 0.0} * (way * kStick);
    }
    const PotentialBatch& model = *set.models(x).front();
    for (const Vec3& t : {Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0.6, 0.8, 0}})
      CHECK(curvature_along(model, x, t) ==
            doctest::Approx(curvature_along(friction, x, t)).epsilon(1e-5).scale(5.0 / kStick));
  }
}

TEST_CASE("friction that was kept comes back, limits, stencils and all") {
  RandomPoints random(12);
  std::vector<Vec3> start;
  for (int p = 0; p < 4; ++p) start.push_back(random.point());
  const Vec3 n = normalized(random.point());
  FrictionSet set = make_set();
  begin(set, start);
  const std::vector<Contact> contacts{contact_of(3)};
  set.reset(contacts, std::vector<Vec3>{n * 5.0}, coefficient, start);
  std::vector<Vec3> x = start;
  x[0] += normalized(cross(n, random.point())) * 2e-3;
  const std::vector<Vec3> before = gradients(set, x);
  set.reset({}, std::vector<Vec3>{}, coefficient, start);
  CHECK(set.empty());
  set.keep();
  set.restore();
  const std::vector<Vec3> after = gradients(set, x);
  for (int p = 0; p < 4; ++p) CHECK(after[p] == before[p]);
  // Against forces of twice the size, the residual says so.
  const LimitComparison left = set.residual(contacts, std::vector<Vec3>{n * 10.0}, coefficient);
  CHECK(left.total().largest_change == doctest::Approx(kMu * 5.0));
}

TEST_CASE("friction is settled between each two bodies, not only where limits are large") {
  const Vec3 up{0, 0, 1};
  const std::vector<Vec3> start{{0, 0, 0}, {0.1, 0, 0}, {0.2, 0, 0}, {0.3, 0, 0}};
  const auto mu = [](int32_t, int32_t) { return kMu; };
  FrictionSet set = make_set();
  begin(set, start);
  Contact press = contact_of(2), box = contact_of(2), dust = contact_of(2);
  box.key.first = 3;
  box.group_b = 3;
  dust.key.first = 4;
  dust.group_b = 4;
  const std::vector<Contact> contacts{press, box, dust};
  const auto forces = [&](double of_box, double of_dust) {
    return std::vector<Vec3>{up * 1e6, up * of_box, up * of_dust};
  };
  CHECK(set.reset(contacts, forces(10.0, 0.1), mu, start) > 0.0);
  CHECK(set.reset(contacts, forces(10.0, 0.1), mu, start) == 0.0);
  // Two parts in a hundred of the box, a millionth of the press.
  CHECK(set.reset(contacts, forces(10.2, 0.1), mu, start) == doctest::Approx(0.2 * kMu));
  CHECK(set.reset(contacts, forces(10.21, 0.1), mu, start) == 0.0);
  CHECK(set.reset(contacts, forces(10.21, 0.5), mu, start) == 0.0);
}

TEST_CASE(
    "a point that slides to the next triangle takes its bristles along, unless it goes round a corner") {
  for (const bool is_corner : {false, true}) {
    CAPTURE(is_corner);
    const SurfaceMesh surface{.vertex_count = 5, .triangles = {{1, 2, 3}, {2, 1, 4}}};
    const std::vector<Vec3> start{
        {0.5, 0, 0.01}, {0, 0, 0}, {1, 0, 0}, {0.5, 1, 0}, is_corner ? Vec3{0.5, 0, 1} : Vec3{0.5, -1, 0}};
    Contact contact = contact_of(4);
    contact.key = {PairKind::PointTriangle, 0, 1};
    contact.sites = {0, 2, 1, 4};
    FrictionMemory memory;
    const Vec3 bent{0.5 * kStick, 0, 0};
    memory.append({PairKind::PointTriangle, 0, 0}, bent, 1.0);
    FrictionSet set = make_set();
    set.begin_step(surface, memory, start, {start, 1.0});
    set.reset({contact}, std::vector<Vec3>{{0, 0, 2.0}}, coefficient, start);
    const FrictionMemory after = set.end_step(start);
    CHECK(after.pair == std::vector<int64_t>{pack(contact.key)});
    CHECK(norm(after.deflection[0] - (is_corner ? Vec3{} : bent)) < 1e-15);
    CHECK(after.force[0] == 2.0);
  }
}
