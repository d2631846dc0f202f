// Settings of the nonlinear solve. Their descriptor table is with all others in sim/settings.cpp.
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
  double acceleration_tolerance = 1e-2;  ///< [m/s^2] largest |M^-1 residual| of a node or body
  double residual_tolerance = 0.0;       ///< [N] largest unbalanced force of a node or body
  double step_tolerance =
      1e-3;  ///< [m/s] largest site motion of the next full Newton step, over the time step
  Termination termination = Termination::All;
  int max_iterations = 200;  ///< then the step is retried with half the length
  /// [s] by the clock on the wall, of a step with all its attempts; then it fails. Infinity: no limit. Not
  /// deterministic.
  double max_seconds = std::numeric_limits<double>::infinity();
  Projection projection = Projection::OnDemand;
  double armijo = 1e-4;       ///< demanded share of the predicted decrease of the energy
  int max_backtracks = 40;    ///< halvings of one line search
  double max_rotation = 1.0;  ///< [rad] largest rotation of a rigid body in one iteration
  static const FieldTable& fields();
};

}  // namespace stark
