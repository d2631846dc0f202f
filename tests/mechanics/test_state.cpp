// State as a value: equality, hash and first difference see every field of state_fields.inc, bit for bit.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <vector>

#include <stark/base/error.h>
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

TEST_CASE("a state is the arrays of its fields, and comes back from them in any order") {
  const State a = sample();
  std::vector<StateArray> arrays = arrays_of(a);
  CHECK(arrays.front().name == "time");
  CHECK(arrays.front().unit == "s");
  CHECK(arrays.front().shape.empty());
  const std::set<std::string> integers{"step_count",        "mark_count",           "friction_pair",
                                       "contact_bodies",    "contact_close_bodies", "contact_regained",
                                       "restitution_bodies"};
  for (const StateArray& array : arrays) {
    CHECK(array.is_integer == integers.contains(array.name));
    if (array.name == "body_rotation") CHECK(array.shape == std::vector<size_t>{2, 3, 3});
    if (array.name == "point_position") CHECK(array.shape == std::vector<size_t>{2, 3});
    if (array.name == "joint_rate") CHECK(array.shape == std::vector<size_t>{2});
  }
  std::reverse(arrays.begin(), arrays.end());
  CHECK(make_state(arrays) == a);
  const State none;
  CHECK(make_state(arrays_of(none)) == none);
}

TEST_CASE("numbers of pairs are integers: their bits are no real numbers") {
  State state = sample();
  state.contact_bodies = {0x7ff0000000000001};  // not a number, as the bits of a double
  CHECK(find_invalid_number(state).find("contact_bodies") == std::string::npos);
}

TEST_CASE("arrays that are no state are refused") {
  const State a = sample();
  const std::vector<StateArray> good = arrays_of(a);
  std::vector<StateArray> arrays = good;
  const auto find = [&](const std::string& name) -> StateArray& {
    return *std::ranges::find(arrays, name, &StateArray::name);
  };
  SUBCASE("missing") {
    std::erase_if(arrays, [](const StateArray& array) { return array.name == "pin_remaining"; });
    CHECK_THROWS_WITH_AS(make_state(arrays), doctest::Contains("'pin_remaining' is missing"),
                         InvalidArgument);
  }
  SUBCASE("optional fields may be missing") {
    std::erase_if(arrays, [](const StateArray& array) { return array.name == "internal_variable"; });
    CHECK(make_state(arrays).internal_variable.empty());
  }
  SUBCASE("unknown") {
    arrays.push_back(good[0]);
    arrays.back().name = "tim";
    CHECK_THROWS_WITH_AS(make_state(arrays), doctest::Contains("unknown field 'tim'"), InvalidArgument);
  }
  SUBCASE("type") {
    find("step_count").is_integer = false;
    CHECK_THROWS_WITH_AS(make_state(arrays), doctest::Contains("'step_count' has real numbers"),
                         InvalidArgument);
  }
  SUBCASE("number of dimensions") {
    find("time").shape = {1};
    CHECK_THROWS_WITH_AS(make_state(arrays), doctest::Contains("'time' has real numbers in 1 dimensions"),
                         InvalidArgument);
  }
  SUBCASE("last dimension") {
    find("point_position").shape = {2, 2};
    CHECK_THROWS_AS(make_state(arrays), InvalidArgument);
  }
  SUBCASE("one dimension too few") {
    find("body_rotation").shape = {2, 3};
    CHECK_THROWS_AS(make_state(arrays), InvalidArgument);
  }
}

TEST_CASE("lengths and numbers that no state can have are found") {
  State good = sample();
  good.joint_enabled = {1.0, 0.0};
  good.actuator_enabled = {0.0, 1.0};
  good.attachment_held = {1.0, -1.0};
  good.restitution_due = {1.0, 0.0};
  good.restitution_stiffness = {1.0, 1e-3};
  good.actuator_value = {std::numeric_limits<double>::infinity(), -1.0};  // no cap
  good.body_rotation = good.script_rotation =
      good.previous_body_rotation = {Mat3::identity(), Mat3::identity()};
  CHECK(find_invalid_number(good) == "");
  CHECK(first_length_difference(good, good) == "");
  State bad = good;
  shorten(bad.previous_body_angular_velocity);
  CHECK(first_length_difference(good, bad) == "previous_body_angular_velocity");
  const auto found = [&](auto change) {
    State state = good;
    change(state);
    return find_invalid_number(state);
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK(found([&](State& s) { s.body_rotation[1].m[3] = nan; }) == "body_rotation[1] = nan: must be finite");
  CHECK(found([](State& s) { s.point_position[1].z = 1.0 / 0.0; }) ==
        "point_position[1] = inf m: must be finite");
  CHECK(found([](State& s) { s.script_rotation[1].m[0] = 1.001; }) ==
        "script_rotation[1]: must be a rotation");
  CHECK(found([](State& s) { s.body_rotation[0].m[8] = -1.0; }) == "body_rotation[0]: must be a rotation");
  CHECK(found([](State& s) { s.time_step = 0.0; }) == "time_step = 0 s: must be > 0 and finite");
  CHECK(found([](State& s) { s.time = -1.0; }) == "time = -1 s: must be >= 0 and finite");
  CHECK(found([](State& s) { s.step_count = -1; }) == "step_count = -1: must be >= 0");
  CHECK(found([](State& s) { s.attachment_held[0] = 2.0; }) == "attachment_held[0] = 2: must be 1, 0 or -1");
  CHECK(found([](State& s) { s.restitution_due[1] = 0.5; }) == "restitution_due[1] = 0.5: must be 0 or 1");
  CHECK(found([](State& s) { s.restitution_stiffness[0] = 0.0; }) ==
        "restitution_stiffness[0] = 0: must be > 0 and at most 1");
  CHECK(found([&](State& s) { s.actuator_value[1] = nan; }) == "actuator_value[1] = nan: must be a number");
}
