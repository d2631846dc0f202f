// Values of parameters: declarations from formulas, checks with clear messages, values of each element.
#include <doctest/doctest.h>

#include <limits>
#include <string>

#include <stark/base/error.h>
#include <stark/mechanics/define.h>
#include <stark/mechanics/field_values.h>

using namespace stark;

namespace {

PotentialDefinition spring() {
  return define_potential("spring", 2, "", [](PotentialBuilder& b) {
    const auto k = b.parameter("stiffness", "N/m", "stiffness of the spring", positive());
    const auto along = b.direction("axis", "direction of the spring");
    const auto elongation = symbolic::dot(along, b.x(1) - b.x(0)) - b.data("length", "m", "rest length");
    return k * elongation * elongation / b.time_step();
  });
}

std::string message_of(const ParameterDeclaration& declaration, const FieldValues& values) {
  try {
    check_values("thing 'a'", declaration, values, 3);
  } catch (const InvalidArgument& error) {
    return error.what();
  }
  return "accepted";
}

}  // namespace

TEST_CASE("declarations come from the formula, clocks are not among them") {
  const auto declarations = parameters_of(spring());
  REQUIRE(declarations.size() == 3);
  CHECK(declarations[0].name == "stiffness");
  CHECK(declarations[0].unit == "N/m");
  CHECK_FALSE(declarations[0].rule.holds(0.0));
  CHECK(declarations[1].is_direction);
  CHECK(declarations[1].width == 3);
  CHECK(declarations[2].name == "length");
}

TEST_CASE("wrong values are named with element, unit and rule") {
  const auto declarations = parameters_of(spring());
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK(message_of(declarations[0], {{1.0}, false}) == "accepted");
  CHECK(message_of(declarations[0], {{1.0, 2.0, 3.0}, true}) == "accepted");
  CHECK(message_of(declarations[0], {{1.0, -2.0, 3.0}, true}).find("stiffness[1] = -2 N/m: must be > 0") !=
        std::string::npos);
  CHECK(message_of(declarations[2], {{1.0, nan, 1.0}, true}).find("length[1] = nan m: must be finite") !=
        std::string::npos);
  CHECK(message_of(declarations[2], {{1.0}, false}).find("must be given for each of the 3 elements") !=
        std::string::npos);
  CHECK(message_of(declarations[0], {{1.0, 2.0}, true}).find("must be 1 for each of the 3 elements") !=
        std::string::npos);
  CHECK(message_of(declarations[1], {{1.0}, false}).find("must be 3") != std::string::npos);
  CHECK(message_of(declarations[1], {{1, 0, 0, 0, 0, 0, 0, 1, 0}, true}).find("axis[1] = (0, 0, 0)") !=
        std::string::npos);
}

TEST_CASE("values reach the batch: of each element where given, else one for all") {
  const ParameterValues values{
      {"stiffness", {{1.0, 2.0, 3.0}, true}}, {"axis", {{0, 0, 2}, false}}, {"length", {{0.5}, false}}};
  CHECK(per_element_names(values) == std::set<std::string>{"stiffness"});
  PotentialBatch batch(
      std::make_shared<Potential>(spring(), symbolic::Backend::Interpreter, per_element_names(values)));
  const std::vector<int32_t> stencils{0, 1, 0, 1, 0, 1};
  batch.resize(stencils);
  set_values(batch, values);
  batch.set_time(1.0, 0.0);
  const std::vector<Vec3> x{{0, 0, 0}, {7, 7, 2.5}};
  AlignedVector<double> energies(symbolic::kLanes);
  batch.evaluate(symbolic::Order::Energy, x, 0, 1, energies.data());
  for (int e = 0; e < 3; ++e) CHECK(energies[e] == doctest::Approx((e + 1) * 4.0));
}
