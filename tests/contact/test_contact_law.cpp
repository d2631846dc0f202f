// Pressure against gap: the law itself, bodies in series, factors of lasting loads.
#include <doctest/doctest.h>

#include <cmath>
#include <limits>

#include <stark/geometry/shapes.h>
#include <support/collision_scenes.h>
#include <support/contact_potentials.h>

using namespace stark;
using namespace stark::test;

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Two sheets of 1 m by 1 m with cells of 0.25 m, parallel to each other.
struct Sheets {
  explicit Sheets(std::vector<BodyStiffness> bodies) {
    builder.add_mesh(make_grid(1.0, 1.0, 4, 4));
    builder.add_mesh(make_grid(1.0, 1.0, 4, 4), {0, 0, 0.1});
    law = {AreaWeights(builder.surface, builder.x, {}, std::vector<uint8_t>{1, 1}, distance), bodies,
           distance};
  }
  /// Vertex 12 in the middle of the lower sheet against the vertex above.
  Contact middle(double gap) {
    Contact contact;
    contact.key = {PairKind::PointTriangle, 12, 0};
    contact.sites = {12, 37, 0, 0};
    contact.weights = {1.0, -1.0, 0.0, 0.0};
    contact.group_b = 1;
    contact.distance = gap;
    contact.contact_distance = distance[0] + distance[1];
    return contact;
  }
  SceneBuilder builder;
  std::vector<double> distance{0.01, 0.03};
  ContactLaw law;
  ThreadPool pool{1};
};

double pressure(const BodyStiffness& a, const BodyStiffness& b) { return Sheets({a, b}).law.pressure(0, 1); }

}  // namespace

TEST_CASE("relative pressure is the slope of the barrier, 1 at half of the contact distance") {
  CHECK(relative_pressure(0.5) == doctest::Approx(1.0));
  CHECK(relative_pressure(1.0) == 0.0);
  CHECK(relative_pressure(2.0) == 0.0);
  for (const double r : {1e-6, 0.1, 0.3, 0.9})
    CHECK(relative_pressure(r) == doctest::Approx(barrier_slope(r, 1.0) / barrier_slope(0.5, 1.0)));
  CHECK(barrier_slope(0.5, 1.0) == doctest::Approx(-(std::log(2.0) + 0.5)).epsilon(1e-12));
}

TEST_CASE("bodies are in series, by their parts of the contact distance") {
  CHECK(pressure({100.0}, {100.0}) == doctest::Approx(100.0));
  CHECK(pressure({100.0}, {300.0}) == doctest::Approx(0.04 / (0.01 / 100.0 + 0.03 / 300.0)));
  CHECK(pressure({100.0}, {kInfinity}) == doctest::Approx(400.0));
}

TEST_CASE("where one side was given, the other does not give way") {
  CHECK(pressure({100.0, true}, {1.0}) == doctest::Approx(400.0));
  CHECK(pressure({1.0}, {300.0, true}) == doctest::Approx(400.0));
  CHECK(pressure({100.0, true}, {300.0, true}) == doctest::Approx(0.04 / (0.01 / 100.0 + 0.03 / 300.0)));
}

TEST_CASE("the force of a contact is the pressure on its area") {
  Sheets sheets({{100.0}, {100.0}});
  for (const double gap : {0.004, 0.02, 0.035}) {
    sheets.builder.x[37].z = gap;
    std::vector<Contact> contacts{sheets.middle(gap)};
    sheets.law.begin_step();
    sheets.law.assign(sheets.builder.surface, sheets.builder.x, sheets.pool, contacts);
    // Both sheets are alike, so each integrates half of it.
    CHECK(contacts[0].stiffness * -barrier_slope(gap, 0.04) ==
          doctest::Approx(100.0 * relative_pressure(gap / 0.04) * 0.5 * 0.0625));
  }
}

TEST_CASE("all contacts of a vertex with a body have the same part of a spent layer") {
  // One that faces another way leaves the layer to all: what counts twice is taken away by terms of opposite
  // sign, and energies with other factors would not cancel.
  Sheets sheets({{100.0}, {100.0}});
  std::vector<Vec3>& x = sheets.builder.x;
  const auto stiffness = [&](bool beside) {
    sheets.law.begin_step({}, {{group_code(0, 1), SpentLayer{0.05, {0, 0, -1}}}});
    std::vector<Contact> contacts{sheets.middle(0.02), sheets.middle(0.02)};
    contacts[1].key.second = 1;
    contacts[1].sites[1] = 38;
    x[37] = x[12] + Vec3{0, 0, 0.02};
    x[38] = x[12] + (beside ? Vec3{0.02, 0, 0} : Vec3{0.001, 0, 0.02});
    sheets.law.assign(sheets.builder.surface, x, sheets.pool, contacts);
    CHECK(contacts[0].stiffness == contacts[1].stiffness);
    return contacts[0].stiffness;
  };
  CHECK(stiffness(false) == doctest::Approx(0.05 * stiffness(true)));
}

TEST_CASE("a load that lasts makes contact stiffer, an impact does not") {
  Sheets sheets({{100.0}, {100.0}});
  const int64_t code = group_code(0, 1);
  LoadMemory memory;
  const auto step = [&](double times, double duration) {
    sheets.law.begin_step(memory);
    std::vector<Contact> contacts{sheets.middle(0.004)};
    sheets.law.assign(sheets.builder.surface, sheets.builder.x, sheets.pool, contacts);
    const double natural = contacts[0].stiffness / memory.find(code);
    const Vec3 force{0, 0, times * natural * -barrier_slope(0.004, 0.04)};
    memory = sheets.law.end_step(contacts, std::vector<Vec3>{force}, duration);
    return memory.find(code);
  };
  CHECK(step(9.0, 0.3) == 1.0);
  CHECK(step(0.0, 10.0) == 1.0);  // over: it starts anew
  CHECK(memory.bodies.empty());
  CHECK(step(9.0, 0.3) == 1.0);
  CHECK(step(9.0, 0.3) == 1.0);
  CHECK(step(9.0, 0.3) ==
        doctest::Approx(std::pow(9.0, 1.0 - std::exp(-0.9)) * std::pow(1.0 / 16.0, std::exp(-0.9))));
  for (int k = 0; k < 5; ++k) step(9.0, 12.0);  // each as far as the one before has opened the gap
  CHECK(step(9.0, 12.0) == doctest::Approx(9.0).epsilon(0.01));
  CHECK(step(3.0, 12.0) == doctest::Approx(3.0).epsilon(0.01));
  const double rests = step(3.0, 1.0);
  CHECK(step(1.005 * rests, 1.0) == rests);  // enough: what rests is to rest
  CHECK(step(0.0, 1.0) < rests);
}

TEST_CASE(
    "a law that was given stays as it is, whatever the load; a failed attempt changes it for that step") {
  Sheets sheets({{100.0, true}, {100.0}});
  std::vector<Contact> contacts{sheets.middle(0.004)};
  sheets.law.begin_step();
  sheets.law.assign(sheets.builder.surface, sheets.builder.x, sheets.pool, contacts);
  const std::vector<Vec3> forces{{0, 0, 100.0 * contacts[0].stiffness}};
  CHECK(sheets.law.end_step(contacts, forces, 100.0).bodies.empty());
  const LoadMemory raised = sheets.law.raised(contacts, forces);
  CHECK(raised.find(group_code(0, 1)) > 100.0);
  sheets.law.begin_step(raised);
  std::vector<Contact> again{sheets.middle(0.004)};
  sheets.law.assign(sheets.builder.surface, sheets.builder.x, sheets.pool, again);
  CHECK(again[0].stiffness > 100.0 * contacts[0].stiffness);
  CHECK(sheets.law.end_step(again, forces, 1.0).bodies.empty());
}

TEST_CASE("a sheet that two bodies press on each other through gets stiffer until it carries them alone") {
  // Three sheets of which the first counts as one between the other two.
  ContactLaw law({}, {{100.0}, {100.0}, {100.0}}, {0.01, 0.02, 0.02});
  const double natural = 1.0, own = 0.04 / (0.04 + 0.02), gap = own + 0.1;
  const auto contact = [&](int32_t a, int32_t b) {
    Contact c;
    c.group_a = a;
    c.group_b = b;
    c.contact_distance = 0.03;
    c.stiffness = natural;
    return c;
  };
  const std::vector<Contact> contacts{contact(0, 1), contact(0, 2), contact(1, 2)};
  const double force = 0.03 * natural * barrier_slope(0.5);
  const std::vector<Vec3> forces{{0, 0, force}, {0, 0, -force}, {0, 0, 3.0 * force}};
  const std::vector<PressedSheet> pressed{{0, 1, 2}};
  law.begin_step();
  CHECK(law.end_step(contacts, forces, 100.0).find(group_code(0, 1)) == 1.0);
  const LoadMemory memory = law.end_step(contacts, forces, 100.0, pressed);
  // The first trial reaches what is asked for: all of the force at the wider gap.
  const double asked = 4.0 * barrier_slope(0.5) / barrier_slope(gap);
  CHECK(memory.find(group_code(0, 1)) == doctest::Approx(asked).epsilon(0.01));
  CHECK(memory.find(group_code(0, 2)) == doctest::Approx(asked).epsilon(0.01));
  CHECK(memory.find(group_code(1, 2)) == 1.0);
}

TEST_CASE("a layer that an impact has spent is raised to what is asked of it as it is left") {
  Sheets sheets({{100.0}, {100.0}});
  const int64_t code = group_code(0, 1);
  constexpr double kLeft = 1e-3;
  const auto stiffness = [&](const LoadMemory& memory) {
    std::vector<Contact> contacts{sheets.middle(0.004)};
    sheets.law.begin_step(
        memory,
        {{code, {kLeft, gap_vector(contacts[0], sheets.builder.x) * side_of_first(contacts[0], code)}}});
    sheets.law.assign(sheets.builder.surface, sheets.builder.x, sheets.pool, contacts);
    return contacts;
  };
  const std::vector<Contact> spent = stiffness({});
  const std::vector<Vec3> forces{{0, 0, 500.0 * spent[0].stiffness * spent[0].contact_distance}};
  // A load that lasts counts by what the layer is once it has recovered.
  CHECK(sheets.law.end_step(spent, forces, 100.0).find(code) == 1.0);
  // What it stores as it is left is a thousandth of what it stored before.
  const auto most = sheets.law.highest_factors(spent, {0.1}, {}, kInfinity);
  CHECK(most.at(code) == doctest::Approx(1e3 / kLeft));
  const LoadMemory raised = sheets.law.raised(spent, forces, most);
  CHECK(raised.find(code) > 30.0);
  CHECK(stiffness(raised)[0].stiffness == doctest::Approx(raised.find(code) * spent[0].stiffness));
}

TEST_CASE("raised contact stores no more than a thousand times what all contact did before the step") {
  Sheets sheets({{100.0}, {100.0}});
  const int64_t code = group_code(0, 1);
  std::vector<Contact> contacts{sheets.middle(0.004)};
  LoadMemory before, now;
  before.add(code, 2.0);
  now.add(code, 8.0);  // raised once already
  sheets.law.begin_step(now);
  sheets.law.assign(sheets.builder.surface, sheets.builder.x, sheets.pool, contacts);
  const std::vector<Vec3> forces{{0, 0, 1e6 * contacts[0].stiffness}};
  const auto most = sheets.law.highest_factors(contacts, {0.4}, before, kInfinity);
  CHECK(most.at(code) == doctest::Approx(2e3));  // 0.1 J before the step, 100 J with it
  CHECK(sheets.law.raised(contacts, forces, most).find(code) == doctest::Approx(2e3));
  CHECK(sheets.law.raised(contacts, forces).find(code) == doctest::Approx(8e3));
  // Nor more than a tenth of what moves has, from ten times on.
  CHECK(sheets.law.highest_factors(contacts, {0.4}, before, 50.0).at(code) == doctest::Approx(1e2));
  CHECK(sheets.law.highest_factors(contacts, {0.4}, before, 2.0).at(code) == doctest::Approx(20.0));
  CHECK(sheets.law.highest_factors(contacts, {0.4}, before, 5e3).at(code) == doctest::Approx(2e3));
  // Nothing is stored: nothing comes out of nothing.
  CHECK(sheets.law.highest_factors(contacts, {0.0}, before, kInfinity).empty());
}
