// Joints of a time step as augmented Lagrangians: E = sum_k lambda_k C_k + rho_k/2 C_k^2 [Nocedal & Wright
// 2006, sec. 17.3]. rho follows from the stiffness and inertia of what the joint connects, lambda is carried
// over from step to step and is the force of the joint, so that a step usually needs no update at all. While
// some residual is beyond its tolerance when Newton's method has converged, lambda += rho C, and rho grows
// where C did not fall enough. Nothing needs to be tuned. [theory eq. 24, 25]
#pragma once

#include <cmath>
#include <functional>
#include <memory>
#include <numbers>
#include <span>
#include <string>
#include <vector>

#include <stark/base/math.h>
#include <stark/mechanics/joint.h>
#include <stark/mechanics/potential_batch.h>

namespace stark {

/// An angle without its full turns, in [-pi, pi].
inline double shortest_turn(double angle) { return std::remainder(angle, 2.0 * std::numbers::pi); }

/// How far residuals may be from zero in an accepted step.
struct ConstraintTolerance {
  double length = 1e-6;  ///< [m]
  double angle = 1e-5;   ///< [rad]

  double of(ResidualUnit unit) const { return unit == ResidualUnit::Length ? length : angle; }
};

/// Stiffness by which one side of a joint resists, against translation [N/m] and rotation [N m].
struct SideStiffness {
  double translation = 0.0, rotation = 0.0;
  bool is_placed = false,
       is_turned = false;  ///< where it is, how it is turned is prescribed: no force moves it
};

/// All joints of one definition between the same kinds of frames.
struct ConstraintGroup {
  std::shared_ptr<const Joint> joint;
  PotentialBatch batch;
  std::vector<int32_t> joints;  ///< number of the joint of each element
};

class ConstraintSet {
 public:
  explicit ConstraintSet(std::vector<ConstraintGroup> groups);

  std::vector<ConstraintGroup>& groups() { return groups_; }
  const std::vector<ConstraintGroup>& groups() const { return groups_; }
  /// Numbers of residuals and of coordinates of all joints together, in the order of groups and elements.
  int64_t residual_count() const { return static_cast<int64_t>(multipliers_.size()); }
  int64_t coordinate_count() const { return coordinate_count_; }
  int64_t joint_count() const { return joint_count_; }

  /// Starts a step with the multipliers of the last one. `sides`: two for each joint; `enabled`: by joint;
  /// `wanted`: tolerances to go on to, no larger, as long as updates bring something.
  void begin_step(std::span<const double> multipliers, std::span<const SideStiffness> sides,
                  std::span<const double> enabled, const ConstraintTolerance& tolerance,
                  const ConstraintTolerance& wanted);
  void begin_step(std::span<const double> multipliers, std::span<const SideStiffness> sides,
                  std::span<const double> enabled, const ConstraintTolerance& tolerance) {
    begin_step(multipliers, sides, enabled, tolerance, tolerance);
  }
  /// Between steps: the joints pull with these forces, whatever their residuals. What reactions are read from
  /// when the multipliers come with a state instead of a step.
  void set_forces(std::span<const double> forces);
  /// Updates multipliers and penalties where residuals at x are beyond the wanted tolerances. Returns the
  /// largest change of a multiplier [N, N m], 0 when everything is held as wanted, or within the tolerances
  /// and a series of updates brought nothing; infinity when that is beyond them, or no side of what is apart
  /// has unknowns. What counts are the parts of the residuals that `held` returns, if there is one: less what
  /// constraints in loops do to each other, unless that alone is beyond the tolerances; nothing: all of them.
  using Relief = std::function<std::vector<double>(std::span<const double> residuals)>;
  double update(std::span<const Vec3> x, const Relief& held = {});
  /// Forces that hold the residuals: the multipliers of the next step.
  std::vector<double> next_multipliers(std::span<const double> residuals) const;

  /// Forces lambda + rho C that act, by residual: those on what carries frame a are minus these times the
  /// gradient of the residual.
  std::vector<double> reactions(std::span<const double> residuals) const;
  /// Those of so many joints from `first` on, joint by joint, with sites at x.
  std::vector<double> reactions_of(int32_t first, int32_t count, std::span<const Vec3> x) const;

  /// Multipliers [N, N m] and penalties [N/m, N m] by residual, which decide what joints pull with.
  struct Inputs {
    std::vector<double> multipliers, penalties;
  };
  Inputs inputs() const { return {multipliers_, penalties_}; }
  void set_inputs(const Inputs& inputs);
  const std::vector<double>& multipliers() const { return multipliers_; }
  const std::vector<double>& penalties() const { return penalties_; }
  /// Penalties that the step has started with.
  const std::vector<double>& first_penalties() const { return first_penalties_; }
  /// Which residuals hold at or below zero, by residual.
  std::vector<char> one_sided() const;

  /// Largest residual over its tolerance at x, and whose it is.
  struct Violation {
    double ratio = 0.0;
    int32_t joint = -1;
    double residual = 0.0;
    ResidualUnit unit = ResidualUnit::Length;
  };
  Violation worst(std::span<const Vec3> x) const { return worst(x, enabled_, tolerance_); }
  /// The same between steps, of the joints that are enabled.
  Violation worst(std::span<const Vec3> x, std::span<const double> enabled,
                  const ConstraintTolerance& tolerance) const {
    return worst_of(residuals(x), enabled, tolerance);
  }

  /// The worst of each joint of which these residuals are more than nine tenths of the tolerance, the worst
  /// first.
  std::vector<Violation> nearly_beyond(std::span<const double> residuals) const;

  /// Residuals or coordinates at x, in the order of groups and elements.
  std::vector<double> residuals(std::span<const Vec3> x) const;
  std::vector<double> coordinates(std::span<const Vec3> x) const;
  /// Residuals of so many joints from `first` on, joint by joint.
  std::vector<double> residuals_of(int32_t first, int32_t count, std::span<const Vec3> x) const;
  /// Where the residuals and the coordinates of a joint start in those arrays.
  struct Place {
    int32_t group = 0;
    int64_t element = 0, residual = 0, coordinate = 0;
  };
  const Place& place(int32_t joint) const { return places_[joint]; }

 private:
  /// Residuals of one joint become the forces that hold them.
  void turn_into_reactions(const Place& place, std::span<double> residuals) const;
  void write_inputs();
  /// What residuals have beyond those that are held; empty where that is beyond the tolerances, or nothing
  /// is.
  std::vector<double> misfits_of(std::span<const double> residuals, std::span<const double> held) const;
  Violation worst_of(std::span<const double> residuals, std::span<const double> enabled,
                     const ConstraintTolerance& tolerance) const;
  Violation worst_of_joint(std::span<const double> residuals, int32_t joint,
                           const ConstraintTolerance& tolerance) const;

  std::vector<ConstraintGroup> groups_;
  std::vector<Place> places_;  ///< by joint
  std::vector<double> multipliers_, penalties_, last_residuals_;
  std::vector<double> first_penalties_, largest_penalties_;
  std::vector<double> enabled_;  ///< by joint; penalties are zero also where both sides are prescribed
  ConstraintTolerance tolerance_, wanted_;
  double smallest_violation_ = 0.0;  ///< over the tolerance, of the updates of this step
  int idle_updates_ = 0;             ///< since it fell by half
  int64_t coordinate_count_ = 0, joint_count_ = 0;
};

}  // namespace stark
