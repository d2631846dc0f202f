// Restitution: the force that gives back has the direction and the moment of the impact, is limited by its
// impulse and energy, and impacts are told from loads that last.
#include <doctest/doctest.h>

#include <cmath>

#include <stark/contact/pipeline.h>
#include <stark/mechanics/site_gradient.h>

using namespace stark;

namespace {

constexpr double kStep = 0.01;  ///< [s]

std::shared_ptr<const Potential> restitution_potential() {
  static const auto potential =
      compile_contact_potentials(symbolic::Backend::Automatic, false, true).restitution;
  return potential;
}

/// Two bodies of three sites each, the first above the second.
std::vector<Vec3> sites() { return {{0, 0, 1}, {1, 0, 1}, {0, 1, 1.2}, {0, 0, 0}, {2, 0, 0.1}, {0, 2, 0}}; }

RestitutionSet make_set(double coefficient, const Vec3& gravity = {}) {
  return {{.coefficient = {{group_code(0, 1), coefficient}},
           .gravity = {gravity, {}},
           .frame = {{0, 1, 2}, {3, 4, 5}}},
          restitution_potential()};
}

/// Of bodies that do not turn.
RestitutionSet::Motion motion(std::span<const Vec3> positions, std::span<const Vec3> velocities) {
  static const std::vector<Vec3> no_lead(6);
  return {.turned = positions,
          .velocities = velocities,
          .references = positions,
          .lead = no_lead,
          .duration = kStep,
          .step = kStep};
}

/// An approach of 1 kg at 2 m/s that has ended: 2 N s, 2 J.
RestitutionMemory ended(const Vec3& normal, const Vec3& moment) {
  return {.bodies = {group_code(0, 1)},
          .speed = {2.0},
          .impulse = {2.0},
          .work = {2.0},
          .load = {0.0},
          .stiffness = {0.5},
          .due = {1.0},
          .rate = {0.0},
          .normal = {normal},
          .moment = {moment}};
}

}  // namespace

TEST_CASE("what is given back has the direction and the moment of the impact, on both bodies") {
  RestitutionSet set = make_set(0.5);
  const std::vector<Vec3> x = sites(), v(x.size());
  const Vec3 normal = normalized(Vec3{0.1, -0.2, 1.0}), moment = cross(Vec3{0.4, 0.3, 0.5}, normal);
  set.begin_step(ended(normal, moment), x, motion(x, v));
  std::vector<Vec3> gradient(x.size());
  for (const PotentialBatch* batch : set.batches()) add_site_gradient(*batch, x, 1.0, gradient);
  // At rest the whole speed is missing, so the limit acts: e times the impulse over the step.
  const double force = 0.5 * 2.0 / kStep;
  for (const int first : {0, 3}) {
    const double side = first == 0 ? -1.0 : 1.0;  // gradients are against the forces
    Vec3 sum, torque;
    for (int i = first; i < first + 3; ++i) {
      sum += gradient[i];
      torque += cross(x[i], gradient[i]);
    }
    CHECK(norm(sum - normal * (side * force)) < 1e-9 * force);
    CHECK(norm(torque - moment * (side * force)) < 1e-9 * force);
  }
}

TEST_CASE("the speed is given back, and no force acts where it is there") {
  RestitutionSet set = make_set(0.5);
  const std::vector<Vec3> x = sites(), v(x.size());
  set.begin_step(ended({0, 0, 1}, {}), x, motion(x, v));
  std::vector<Vec3> away = x;
  for (int i = 0; i < 3; ++i) away[i].z += 1.0 * kStep;  // e V
  CHECK(set.work(away) == doctest::Approx(0.0));
  for (int i = 0; i < 3; ++i) away[i].z += 1.0 * kStep;
  CHECK(set.work(away) < 0.0);  // held back
  CHECK(set.spent().at(group_code(0, 1)).stiffness == 0.5);
}

TEST_CASE("its limits are e times the impulse and e^2 times the energy of the approach") {
  RestitutionSet set = make_set(0.5);
  const std::vector<Vec3> x = sites(), v(x.size());
  RestitutionMemory memory = ended({0, 0, 1}, {});
  memory.work = {1.0};  // half of what the speed says has been lost
  set.begin_step(memory, x, motion(x, v));
  // The target 1 m/s by a mean speed of 0.5 m/s: 0.25 J allow 50 N.
  std::vector<Vec3> gradient(x.size());
  for (const PotentialBatch* batch : set.batches()) add_site_gradient(*batch, x, 1.0, gradient);
  CHECK(norm(gradient[0] + gradient[1] + gradient[2]) == doctest::Approx(0.5 * 0.5 * 1.0 / (kStep * 0.5)));
}

TEST_CASE("what comes up since the approach is left to contact") {
  RestitutionSet set = make_set(0.5);
  const std::vector<Vec3> x = sites();
  std::vector<Vec3> v(x.size());
  for (int i = 0; i < 3; ++i) v[i].z = -10.0;  // five times the speed of the impact
  set.begin_step(ended({0, 0, 1}, {}), x, motion(x, v));
  std::vector<Vec3> gradient(x.size());
  for (const PotentialBatch* batch : set.batches()) add_site_gradient(*batch, x, 1.0, gradient);
  // Up to a twentieth of V counts, with the mass of the approach: 1 kg (0.5 * 2 + 0.1) m/s / h.
  CHECK(norm(gradient[0] + gradient[1] + gradient[2]) == doctest::Approx(1.1 / kStep));
}

TEST_CASE("an impact is an approach with a force, a load that lasts is none") {
  const Vec3 gravity{0, 0, -10};
  RestitutionSet set = make_set(0.5, gravity);
  const std::vector<Vec3> x = sites();
  const std::vector<Vec3> still(x.size());
  std::vector<Vec3> v(x.size());
  Contact contact;
  contact.group_a = 0;
  contact.group_b = 1;
  contact.sites = {0, 3, 0, 0};
  contact.weights = {1, -1, 0, 0};
  const std::vector<Vec3> force{{0, 0, 100}};
  SUBCASE("at rest") {
    set.begin_step({}, x, motion(x, v));
    const RestitutionMemory memory = set.end_step({contact}, force, x, {v, v, still});
    REQUIRE(memory.bodies.size() == 1);
    CHECK(memory.speed[0] == 0.0);
    CHECK(memory.load[0] > 0.0);
    CHECK(memory.stiffness[0] == 1.0);
  }
  SUBCASE("falling") {
    for (int i = 0; i < 3; ++i) v[i] = {0, 0, -3};
    set.begin_step({}, x, motion(x, v));
    std::vector<Vec3> slower = v;
    for (int i = 0; i < 3; ++i) slower[i] = {0, 0, -1};
    const RestitutionMemory memory = set.end_step({contact}, force, x, {v, slower, still});
    CHECK(memory.speed[0] == doctest::Approx(3.0));
    CHECK(memory.impulse[0] == doctest::Approx(100 * kStep));
    CHECK(memory.work[0] == doctest::Approx(100 * kStep * 2.0));
    CHECK(memory.due[0] == 0.0);  // still approaching
    const RestitutionMemory over = set.end_step({contact}, force, x, {v, still, still});
    CHECK(over.due[0] == 1.0);
    CHECK(norm(over.normal[0] - Vec3{0, 0, 1}) < 1e-15);
    // What is left carries the weight: 10 m/s^2 times 1 N s over 3 m/s, of 100 N.
    CHECK(over.stiffness[0] == doctest::Approx(10.0 * (1.0 / 3.0) / 100.0));
  }
  SUBCASE("driven on by another body") {
    for (int i = 0; i < 3; ++i) v[i] = {0, 0, -3};
    set.begin_step({}, x, motion(x, v));
    const RestitutionMemory memory = set.end_step({contact}, force, x, {v, v, still});
    std::vector<Vec3> faster = v;
    for (int i = 0; i < 3; ++i) faster[i] = {0, 0, -50};
    set.begin_step(memory, x, motion(x, faster));
    const RestitutionMemory driven = set.end_step({contact}, force, x, {faster, v, still});
    CHECK(driven.speed[0] == doctest::Approx(50.0));
    CHECK(driven.impulse[0] == doctest::Approx(200 * kStep));
    set.begin_step(driven, x, motion(x, v));
    CHECK(set.end_step({contact}, force, x, {v, v, still}).speed[0] == doctest::Approx(50.0));
  }
}
