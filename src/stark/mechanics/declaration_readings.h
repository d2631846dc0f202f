// What can be read of what formulas and states declare, row by row (base/reading.h).
#pragma once

#include <string>
#include <tuple>

#include <stark/base/reading.h>
#include <stark/mechanics/actuator.h>
#include <stark/mechanics/field_values.h>
#include <stark/mechanics/potential.h>
#include <stark/mechanics/state.h>

namespace stark {

/// What the value of a parameter must be: "must be > 0".
inline std::string rule_text(const ParameterDeclaration& declaration) {
  return declaration.is_direction ? "must not be zero" : declaration.rule.text();
}

template <>
struct Readings<ParameterDeclaration> {
  using P = ParameterDeclaration;
  static constexpr std::tuple kAll{reading<&P::name>("name"),      reading<&P::unit>("unit"),
                                   Reading{"rule", "", rule_text}, reading<&P::doc>("doc"),
                                   reading<&P::width>("width"),    reading<&P::is_data>("is_data")};
};

template <>
struct Readings<UniformField> {
  using F = UniformField;
  static constexpr std::tuple kAll{reading<&F::name>("name"), reading<&F::unit>("unit"),
                                   reading<&F::doc>("doc"), reading<&F::width>("width")};
};

template <>
struct Readings<ActuatorParameter> {
  using P = ActuatorParameter;
  static constexpr std::tuple kAll{reading<&P::name>("name"), reading<&P::unit>("unit"),
                                   reading<&P::rule, &FieldRule::text>("rule"), reading<&P::doc>("doc"),
                                   reading<&P::fallback>("default")};
};

template <>
struct Readings<PotentialDefinition> {
  using P = PotentialDefinition;
  static constexpr std::tuple kAll{reading<&P::name>("name"), reading<&P::point_count>("points"),
                                   reading<&P::doc>("doc")};
};

template <>
struct Readings<StateArray> {
  static constexpr std::tuple kAll{reading<&StateArray::name>("name"), reading<&StateArray::unit>("unit"),
                                   reading<&StateArray::meaning>("meaning")};
};

}  // namespace stark
