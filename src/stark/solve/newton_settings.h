// Settings of the nonlinear solve; each is declared in newton_settings.inc.
#pragma once

#include <limits>

#include <stark/base/settings.h>

namespace stark {

/// Whether a step has converged when all active tolerances hold, or when any of them does.
enum class Termination : uint8_t { All, Any };
/// When element Hessians are made positive semidefinite: never; where the global matrix turned out
/// indefinite; always.
enum class Projection : uint8_t { Never, OnDemand, Always };
template <>
struct EnumNames<Termination> {
  static constexpr std::array<std::string_view, 2> kNames{"all", "any"};
};
template <>
struct EnumNames<Projection> {
  static constexpr std::array<std::string_view, 3> kNames{"never", "on_demand", "always"};
};

/// Tolerances: 0 switches one off; at least one must be on.
struct NewtonSettings {
#define STARK_SETTING(type, name, value, unit, rule, meaning) type name = value;
#include <stark/solve/newton_settings.inc>
#undef STARK_SETTING
  static const FieldTable& fields();
};

}  // namespace stark
