// Contacts that many ask for are found once, and anew after whatever changes them.
#include <doctest/doctest.h>

#include <stark/geometry/shapes.h>
#include <stark/sim/simulation.h>

using namespace stark;

namespace {

/// Boxes of 10 cm in a row on a floor.
Scene row_of_boxes(int count) {
  Scene scene;
  scene.add_rigid({.name = "floor", .mesh = make_grid(4.0, 1.0, 2, 2), .motion = Motion::Fixed});
  for (int k = 0; k < count; ++k)
    scene.add_rigid({.name = "box " + std::to_string(k),
                     .mesh = make_box({0.1, 0.1, 0.1}),
                     .mass = 1.0 + k,
                     .position = {0.2 * k - 1.0, 0.0, 0.0501}});
  return scene;
}

/// Sums over all contacts, as for a scene of two bodies.
Vec3 force_on(const std::vector<ContactForce>& contacts, int32_t body) {
  Vec3 sum;
  for (const ContactForce& c : contacts) {
    if (c.contact.group_a == body) sum += c.normal_force + c.friction;
    if (c.contact.group_b == body) sum -= c.normal_force + c.friction;
  }
  return sum;
}

}  // namespace

TEST_CASE("forces on bodies are those of all contacts, whoever has asked before") {
  Simulation sim(row_of_boxes(6)), asked(row_of_boxes(6));
  CHECK(sim.contacts().empty());
  for (int n = 0; n < 20; ++n) {
    for (Simulation* s : {&sim, &asked}) {
      s->step();
      if (n == 7) s->push(BodyId{3}, {0.5, 0.0, 0.0}, {});
      if (n == 12) s->place(BodyId{4}, {1.5, 0.2, 0.05005}, Mat3::identity());
    }
    for (int32_t b = 0; b < 7; ++b) static_cast<void>(asked.contact_force(BodyId{b}));
    const std::vector<ContactForce> fresh = sim.contacts();
    for (int32_t b = 0; b < 7; ++b) {
      CHECK(asked.contact_force(BodyId{b}) == force_on(fresh, b));
      Vec3 of_vertices;
      for (const Vec3& f : asked.vertex_contact_forces(BodyId{b})) of_vertices += f;
      CHECK(norm(of_vertices - force_on(fresh, b)) < 1e-9);
    }
    // Steps are the same, asked or not.
    CHECK(sim.state().body_position == asked.state().body_position);
  }
  CHECK(asked.contact_force(BodyId{1}).z == doctest::Approx(9.81).epsilon(1e-3));
}

TEST_CASE("forces follow a step in which nothing moves, and a state that is put back has none") {
  Simulation sim(row_of_boxes(1));
  for (int n = 0; n < 50; ++n) sim.step();
  const State before = sim.state();
  const Vec3 first = sim.contact_force(BodyId{1});
  CHECK(first.z == doctest::Approx(9.81).epsilon(1e-3));
  sim.push(BodyId{1}, {0.0, 0.0, -0.01}, {});  // pressed down: an impact
  sim.step();
  CHECK(sim.contact_force(BodyId{1}).z > 1.05 * first.z);
  sim.set_state(before);
  CHECK(sim.contacts().empty());
  CHECK(sim.contact_force(BodyId{1}) == Vec3{});
  sim.step();
  CHECK(sim.contact_force(BodyId{1}).z == doctest::Approx(9.81).epsilon(1e-3));
}
