// Friction above a valley: what the sides count twice is taken away once.
#include <doctest/doctest.h>

#include <cmath>

#include <stark/contact/pushing_forces.h>

using namespace stark;

namespace {

/// A contact of point 0 of group 0 with features of group 1.
Contact contact_of(PairKind kind, int32_t second, std::vector<int32_t> feature, int32_t multiplicity,
                   int32_t point = 0) {
  Contact contact{.key = {kind, point, second}, .group_a = 0, .group_b = 1, .multiplicity = multiplicity};
  contact.point_count = static_cast<int8_t>(feature.size() + 1);
  contact.sites[0] = point;
  std::copy(feature.begin(), feature.end(), contact.sites.begin() + 1);
  return contact;
}

}  // namespace

TEST_CASE("the sides of a valley share what the edge between them takes away") {
  const double angle = 0.1;
  const Vec3 left{std::sin(angle), 0, std::cos(angle)}, right{-std::sin(angle), 0, std::cos(angle)};
  // Point 5 comes between them in the order of keys, the other layer of point 0 pushes from above.
  const std::vector<Contact> contacts{contact_of(PairKind::PointTriangle, 7, {1, 2, 3}, 1),
                                      contact_of(PairKind::PointTriangle, 8, {2, 3, 4}, 1),
                                      contact_of(PairKind::PointTriangle, 9, {11, 12, 13}, 1),
                                      contact_of(PairKind::PointTriangle, 7, {1, 2, 3}, 1, 5),
                                      contact_of(PairKey::kOther, 0, {2, 3}, -1)};
  const std::vector<Vec3> forces{left * 6.0, right * 4.0, {0, 0, -3.0}, {0, 0, 2.0}, {0, 0, -4.0}};
  const std::vector<Vec3> pushing = pushing_forces(contacts, forces);
  CHECK(norm(pushing[0]) + norm(pushing[1]) == doctest::Approx(6.0 + 4.0 - 4.0));
  CHECK(norm(pushing[0] - left * 3.6) < 1e-12);
  CHECK(norm(pushing[1] - right * 2.4) < 1e-12);
  CHECK(pushing[2] == forces[2]);
  CHECK(pushing[3] == forces[3]);
  CHECK(pushing[4] == Vec3{});
}

TEST_CASE("a valley that is all but flat has the friction of a flat surface") {
  const std::vector<Contact> flat{contact_of(PairKind::PointTriangle, 7, {1, 2, 3}, 1)};
  CHECK(pushing_forces(flat, {{0, 0, 5.0}})[0] == Vec3{0, 0, 5.0});
  const std::vector<Contact> valley{flat[0], contact_of(PairKind::PointTriangle, 8, {2, 3, 4}, 1),
                                    contact_of(PairKey::kOther, 0, {2, 3}, -1)};
  const std::vector<Vec3> pushing = pushing_forces(valley, {{0, 0, 5.0}, {0, 0, 5.0}, {0, 0, -5.0}});
  CHECK(norm(pushing[0]) + norm(pushing[1]) == doctest::Approx(5.0));
}

TEST_CASE("nothing is taken where nothing is negative, and never more than there is") {
  CHECK(pushing_forces({}, {}).empty());
  const std::vector<Contact> contacts{contact_of(PairKind::PointTriangle, 7, {1, 2, 3}, 1),
                                      contact_of(PairKey::kOther, 0, {2}, -2)};
  const std::vector<Vec3> pushing = pushing_forces(contacts, {{0, 0, 1.0}, {0, 0, -3.0}});
  CHECK(pushing[0] == Vec3{});
  CHECK(pushing[1] == Vec3{});
}
