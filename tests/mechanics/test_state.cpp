// State as a value: equality, hash and first difference see every field of state_fields.inc, bit for bit.
#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <set>

#include <stark/mechanics/state.h>

using namespace stark;

namespace {

// Some value for each type of field, so that new fields are covered without a change here.
void fill(double& v) { v = 0.375; }
void fill(int64_t& v) { v = 50; }
void fill(Vec3& v) { v = {1, 2, 3}; }
void fill(Mat3& m) { m = skew({1, 2, 3}); }
template <typename T>
void fill(std::vector<T>& values) {
  values.resize(2);
  for (T& value : values) fill(value);
}

State sample() {
  State state;
#define STARK_STATE_FIELD(type, name, unit, meaning) fill(state.name);
#include <stark/mechanics/state_fields.inc>
#undef STARK_STATE_FIELD
  return state;
}

// Changes the last bit or so of a field.
void nudge(double& v) { v = std::nextafter(v, 1e9); }
void nudge(int64_t& v) { ++v; }
void nudge(Vec3& v) { nudge(v.z); }
void nudge(Mat3& m) { nudge(m.m[8]); }
template <typename T>
void nudge(std::vector<T>& values) {
  nudge(values.back());
}

// Makes an array shorter by one; other fields have no size.
template <typename T>
bool shorten(T&) {
  return false;
}
template <typename T>
bool shorten(std::vector<T>& values) {
  values.pop_back();
  return true;
}

}  // namespace

TEST_CASE("copies are equal and independent") {
  const State a = sample();
  State b = a;
  CHECK(a == b);
  CHECK(a.hash() == b.hash());
  CHECK(first_difference(a, b).empty());
  b.point_position[0].x = 9.0;
  CHECK(a.point_position[0].x == 1.0);
}

TEST_CASE("the smallest change of any field is seen by equality, hash and first difference") {
  const State a = sample();
  std::set<uint64_t> hashes{a.hash()};
  size_t fields = 0;
#define STARK_STATE_FIELD(type, name, unit, meaning)        \
  {                                                         \
    State b = a;                                            \
    nudge(b.name);                                          \
    CHECK_MESSAGE(!(a == b), #name);                        \
    CHECK_MESSAGE(hashes.insert(b.hash()).second, #name);   \
    CHECK(first_difference(a, b) == #name);                 \
    ++fields;                                               \
    State c = a;                                            \
    if (shorten(c.name)) {                                  \
      CHECK_MESSAGE(!(a == c), #name);                      \
      CHECK_MESSAGE(hashes.insert(c.hash()).second, #name); \
      CHECK(first_difference(a, c) == #name);               \
    }                                                       \
  }
#include <stark/mechanics/state_fields.inc>
#undef STARK_STATE_FIELD
  CHECK(fields >= 14);
}

TEST_CASE("the first difference is the first in the order of the fields") {
  const State a = sample();
  State b = a;
  nudge(b.pin_remaining);
  nudge(b.point_velocity);
  CHECK(first_difference(a, b) == "point_velocity");
}

TEST_CASE("moving an element from one array to its neighbour changes the hash") {
  State a = sample(), b = sample();
  a.point_position.push_back({1, 1, 1});
  b.point_velocity.insert(b.point_velocity.begin(), {1, 1, 1});
  CHECK(a.hash() != b.hash());
}

TEST_CASE(
    "equality is about bits, so that equal states have equal hashes and a state with NaN equals its copy") {
  State a = sample(), b = sample();
  a.point_velocity[0].x = 0.0;
  b.point_velocity[0].x = -0.0;
  CHECK_FALSE(a == b);
  CHECK(a.hash() != b.hash());
  CHECK(first_difference(a, b) == "point_velocity");
  a.time = std::numeric_limits<double>::quiet_NaN();
  const State c = a;
  CHECK(a == c);
}
