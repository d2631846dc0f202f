// Descriptor tables on a struct of the test's own: every type, every rule, text, hints, all-or-nothing.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include <stark/base/error.h>
#include <stark/base/settings.h>

using namespace stark;

namespace {

enum class Shape : uint8_t { Round, Square };

}  // namespace

template <>
struct stark::EnumNames<Shape> {
  static constexpr std::array<std::string_view, 2> kNames{"round", "square"};
};

namespace {

struct Inner {
  double stiffness = 2.0;
  static const FieldTable& fields() {
    static const FieldTable table(
        "inner", TableKind::Settings,
        {field(&Inner::stiffness, "stiffness", "N/m", positive(), "stiffness of the spring")});
    return table;
  }
};

struct Outer {
  bool active = true;
  int count = 3;
  double angle = 0.5;
  Shape shape = Shape::Round;
  std::string label = "a";
  Vec3 direction{0, 0, 1};
  Inner inner;
  static const FieldTable& fields() {
    static const FieldTable table = [] {
      std::vector<Field> all = {
          field(&Outer::active, "active", "switch"),
          field(&Outer::count, "count", "1", at_least(1), "number of things"),
          field(&Outer::angle, "angle", "rad", half_open_interval(0.0, 1.5), "opening angle"),
          field(&Outer::shape, "shape", "form of the thing"),
          field(&Outer::label, "label", "title"),
          field(&Outer::direction, "direction", "m", any_number(), "direction of the thing")};
      for (const Field& f : group(&Outer::inner, "inner", Inner::fields())) all.push_back(f);
      return FieldTable("the test", TableKind::Settings, all);
    }();
    return table;
  }
};

std::string message_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const InvalidSetting& error) {
    return error.what();
  }
  return "no exception";
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

}  // namespace

TEST_CASE("rules hold exactly where they say") {
  const double inf = std::numeric_limits<double>::infinity(), nan = std::nan("");
  struct Row {
    FieldRule rule;
    std::vector<double> good, bad;
  };
  const std::vector<Row> rows = {
      {any_number(), {-1e300, 0.0, 1e300}, {inf, -inf, nan}},
      {positive(), {5e-324, 1.0}, {0.0, -0.0, -1.0, inf, nan}},
      {positive_or_infinity(), {1.0, inf}, {0.0, -inf, nan}},
      {non_negative(), {0.0, -0.0, 1.0}, {-5e-324, inf, nan}},
      {at_least(2.0), {2.0, 3.0}, {1.9999999999999998, inf, nan}},
      {open_interval(0.0, 0.5), {0.25}, {0.0, 0.5, -1.0, nan}},
      {closed_interval(0.0, 0.5), {0.0, 0.5}, {-1e-9, 0.5000001, inf, nan}},
      {half_open_interval(0.0, 0.5), {0.0, 0.4999}, {0.5, nan}},
  };
  for (const Row& row : rows) {
    CAPTURE(row.rule.text());
    for (double value : row.good) CHECK(row.rule.holds(value));
    for (double value : row.bad) CHECK_FALSE(row.rule.holds(value));
  }
}

TEST_CASE("fields are set by name from values and from text, and read back") {
  Outer object;
  const FieldTable& table = Outer::fields();
  table.set(&object, "count", int64_t{7});
  table.set(&object, "angle", int64_t{1});
  table.set(&object, "inner.stiffness", 12.5);
  table.set(&object, "direction", Vec3{1, 2, 3});
  CHECK(object.count == 7);
  CHECK(object.angle == 1.0);
  CHECK(object.inner.stiffness == 12.5);
  CHECK(object.direction == Vec3{1, 2, 3});

  table.set_from_text(&object, "active", "off");
  table.set_from_text(&object, "count", " 12 ");
  table.set_from_text(&object, "angle", "2.5e-1");
  table.set_from_text(&object, "shape", "square");
  table.set_from_text(&object, "direction", "(0, -1.5, 2)");
  CHECK_FALSE(object.active);
  CHECK(object.count == 12);
  CHECK(object.angle == 0.25);
  CHECK(object.shape == Shape::Square);
  CHECK(object.direction == Vec3{0, -1.5, 2});
  CHECK(std::get<std::string>(table.get(&object, "shape")) == "square");

  // Whole reals are integers; everything written out is read back to the same value.
  table.set(&object, "count", 4.0);
  CHECK(object.count == 4);
  object.angle = 0.1 + 0.2;
  Outer copy;
  for (const auto& [name, value] : table.to_map(&object)) table.set_from_text(&copy, name, to_text(value));
  CHECK(table.to_map(&copy) == table.to_map(&object));
}

TEST_CASE("refused values name the field, the value with its unit, the rule and the default") {
  Outer object;
  const Outer untouched;
  const FieldTable& table = Outer::fields();
  struct Row {
    std::string name;
    FieldValue value;
    std::vector<std::string> parts;
  };
  const std::vector<Row> rows = {
      {"inner.stiffness", -1.0, {"inner.stiffness = -1 N/m", "must be > 0", "the default is 2 N/m"}},
      {"inner.stiffness", std::nan(""), {"inner.stiffness = nan N/m", "must be > 0"}},
      {"angle", 1.5, {"angle = 1.5 rad", "in [0, 1.5)"}},
      {"angle", std::string("wide"), {"angle = 'wide'", "in [0, 1.5)"}},
      {"angle", true, {"angle = true"}},
      {"count", int64_t{0}, {"count = 0", "must be >= 1", "whole number"}},
      {"count", 2.5, {"count = 2.5", "whole number"}},
      {"count", int64_t{1} << 40, {"count = 1099511627776", "whole number"}},
      {"active", std::string("perhaps"), {"active = 'perhaps'", "true or false"}},
      {"active", int64_t{1}, {"active = 1", "true or false"}},
      {"shape", std::string("sqare"), {"shape = 'sqare'", "'round', 'square'", "did you mean 'square'?"}},
      {"shape", int64_t{1}, {"shape = 1", "'round', 'square'"}},
      {"direction", std::string("1 2"), {"direction = '1 2'", "three numbers"}},
      {"direction", Vec3{0, std::nan(""), 0}, {"direction = (0, nan, 0) m", "finite"}},
      {"label", 1.0, {"label = 1", "text"}},
  };
  for (const Row& row : rows) {
    const std::string message = message_of([&] { table.set(&object, row.name, row.value); });
    CAPTURE(message);
    for (const std::string& part : row.parts) CHECK_MESSAGE(contains(message, part), part);
  }
  CHECK(table.to_map(&object) == table.to_map(&untouched));
}

TEST_CASE("unknown names are refused with the nearest one, or with all of them") {
  Outer object;
  const auto unknown = [&](const char* name) {
    return message_of([&] { Outer::fields().set(&object, name, 1.0); });
  };
  CHECK(contains(unknown("inner.stifness"),
                 "unknown setting 'inner.stifness' (did you mean 'inner.stiffness'?)"));
  CHECK(contains(unknown("stiffness"), "did you mean 'inner.stiffness'?"));
  CHECK(contains(unknown("angel"), "did you mean 'angle'?"));
  CHECK(contains(unknown("something_else_entirely"), "known are 'active', 'count'"));
}

TEST_CASE("a table of parameters throws InvalidArgument and names the owner") {
  const FieldTable table("Material", TableKind::Parameters,
                         {field(&Inner::stiffness, "stiffness", "N/m", positive(), "stiffness")});
  Inner object;
  try {
    table.set(&object, "stiffness", 0.0, "material 'felt'");
    FAIL("accepted");
  } catch (const InvalidSetting&) {
    FAIL("a parameter is not a setting");
  } catch (const InvalidArgument& error) {
    CHECK(contains(error.what(), "material 'felt': stiffness = 0 N/m"));
  }
}

TEST_CASE("set_all assigns everything or nothing") {
  Outer object;
  const std::string message =
      message_of([&] { Outer::fields().set_all(&object, {{"count", int64_t{9}}, {"angle", -1.0}}); });
  CHECK(contains(message, "angle = -1 rad"));
  CHECK(object.count == 3);
  Outer::fields().set_all(&object, {{"count", int64_t{9}}, {"angle", 1.0}});
  CHECK(object.count == 9);
  const FieldMap changed = Outer::fields().changed_from_default(&object);
  REQUIRE(changed.size() == 2);
  CHECK(changed[0].first == "count");
}

TEST_CASE("validate finds values that were written past the table") {
  Outer object;
  CHECK_NOTHROW(Outer::fields().validate(&object));
  object.inner.stiffness = -3.0;
  CHECK(contains(message_of([&] { Outer::fields().validate(&object); }), "inner.stiffness = -3 N/m"));
}

TEST_CASE("the reference table has a row for each field") {
  const std::string markdown = Outer::fields().markdown();
  CHECK(contains(markdown, "| `inner.stiffness` | 2 | N/m | > 0 and finite | stiffness of the spring |"));
  CHECK(static_cast<size_t>(std::count(markdown.begin(), markdown.end(), '\n')) ==
        2 + Outer::fields().fields().size());
}

TEST_CASE("edit distance of textbook pairs") {
  CHECK(edit_distance("", "abc") == 3);
  CHECK(edit_distance("kitten", "sitting") == 3);
  CHECK(edit_distance("angle", "angel") == 1);  // one swap of neighbours
  CHECK(edit_distance("flaw", "lawn") == 2);
  CHECK(edit_distance("same", "same") == 0);
}

TEST_CASE("numbers are written as briefly as they can be read back") {
  CHECK(to_text(0.1) == "0.1");
  CHECK(quantity_text(-1.0, "N/m") == "-1 N/m");
  CHECK(quantity_text(3.0, "1") == "3");
  CHECK(to_text(std::numeric_limits<double>::infinity()) == "inf");
  CHECK(to_text(FieldValue(Vec3{0, 0, -9.81})) == "(0, 0, -9.81)");
}

TEST_CASE("settings: measured values are told with three digits, bounds never rounded up") {
  CHECK(rough_text(0.0005985528101619301, "m") == "0.000599 m");
  CHECK(rough_text(-1234567.0, "Pa") == "-1230000 Pa");
  CHECK(rough_text(0.0, "m") == "0 m");
  CHECK(rough_text(std::numeric_limits<double>::infinity(), "m") == "inf m");
  CHECK(rough_text(5e-320, "") == to_text(5e-320));
  CHECK(point_text({0.0, 0.05, 1.0123456789}) == "(0, 0.05, 1.01) m");
  CHECK(rough_below(0.00029927640508096504) == doctest::Approx(0.000299).epsilon(1e-12));
  CHECK(rough_below(0.000299999) <= 0.000299999);
}
