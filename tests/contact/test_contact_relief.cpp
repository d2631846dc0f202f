#include <stark/contact/contact_relief.h>

#include <doctest/doctest.h>

#include <stark/contact/contact_law.h>

namespace stark {

namespace {

constexpr double kDistance = 1e-3;  // contact distance [m]

Contact contact_between(int32_t a, int32_t b, double stiffness) {
  Contact contact;
  contact.group_a = a;
  contact.group_b = b;
  contact.stiffness = stiffness;
  contact.contact_distance = kDistance;
  return contact;
}

/// Force of a contact whose gap is `part` of its contact distance [N].
Vec3 force_at(const Contact& contact, double part) {
  return {0.0, 0.0, contact.stiffness * contact.contact_distance * barrier_slope(part)};
}

bool always(int64_t) { return true; }

}  // namespace

TEST_CASE("what an impact presses to next to nothing is stiffened until its force keeps a tenth") {
  const std::vector<Contact> contacts{contact_between(0, 1, 2.0), contact_between(0, 1, 2.0),
                                      contact_between(0, 2, 5.0)};
  ContactRelief relief;
  relief.allow(contacts, std::vector<double>(3, 0.0), 0.0);
  const std::vector<Vec3> forces{force_at(contacts[0], 0.01), force_at(contacts[1], 0.5),
                                 force_at(contacts[2], 0.2)};
  CHECK(relief.stiffen(contacts, forces, always));

  const int64_t pressed = group_code(0, 1), other = group_code(0, 2);
  const Contact stiffer = contact_between(0, 1, 2.0 * relief.factor(pressed));
  CHECK(norm(force_at(stiffer, 0.1)) == doctest::Approx(norm(forces[0])).epsilon(1e-12));
  CHECK(relief.factor(other) == 1.0);
  CHECK(relief.added() == 0.0);

  relief.begin();
  CHECK(relief.factor(pressed) == 1.0);
  CHECK(!relief.is_allowed());
}

TEST_CASE("relief adds no more than is allowed to what contact stores at the start of a step") {
  const std::vector<Contact> contacts{contact_between(0, 1, 1.0), contact_between(0, 2, 1.0)};
  const std::vector<double> energies{3e-6, 1e-6};  // [J]
  ContactRelief relief;
  relief.allow(contacts, energies, 2e-5);
  for (int k = 0; k < 3; ++k)
    relief.stiffen(contacts, std::vector<Vec3>{force_at(contacts[0], 1e-5), force_at(contacts[1], 1e-4)},
                   always);
  const double added =
      3e-6 * (relief.factor(group_code(0, 1)) - 1.0) + 1e-6 * (relief.factor(group_code(0, 2)) - 1.0);
  CHECK(relief.added() == doctest::Approx(added).epsilon(1e-12));
  CHECK(relief.added() == doctest::Approx(2e-5).epsilon(1e-9));
}

TEST_CASE("bodies that may not give way keep their law") {
  const std::vector<Contact> contacts{contact_between(0, 1, 1.0)};
  ContactRelief relief;
  relief.allow(contacts, std::vector<double>{0.0}, 1.0);
  const std::vector<Vec3> forces{force_at(contacts[0], 1e-6)};
  CHECK(!relief.stiffen(contacts, forces, [](int64_t) { return false; }));
  CHECK(relief.factor(group_code(0, 1)) == 1.0);
}

}  // namespace stark
