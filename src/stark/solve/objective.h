// What Newton's method minimises: a function of increments on a manifold, seen through blocks of three
// unknowns. The solver knows nothing of bodies or contact; the objective owns the current iterate and a trial
// point.
#pragma once

#include <cstdint>
#include <span>

#include <stark/base/math.h>
#include <stark/linalg/block_matrix.h>
#include <stark/solve/low_rank.h>

namespace stark {

/// Size of the unbalanced forces at the iterate.
struct Residual {
  double force = 0.0;         ///< largest force on a node or body [N] (torques over the body's radius)
  double acceleration = 0.0;  ///< largest M^-1 force at a node or body surface [m/s^2]
};

/// Energy at the trial point relative to the iterate.
struct TrialEnergy {
  bool feasible = false;    ///< finite energy and, for the whole path, no intersection
  double difference = 0.0;  ///< [J], summed element by element
  double magnitude =
      0.0;  ///< sum of the elements' magnitudes [J]: rounding of `difference` is about 1e-16 of it
  double contact = 0.0;  ///< what contact has of the difference [J]
};

/// Lagged quantities: of what had some at the start, or all. What comes into being on the way, such as
/// friction of an impact, says little of the solution at first.
enum class Lagged : uint8_t { FromStart, All };

class Objective {
 public:
  virtual ~Objective() = default;

  virtual int32_t block_count() const = 0;

  /// Gradient and Hessian at the iterate. `project`: element Hessians made positive semidefinite.
  virtual void linearize(bool project, std::span<double> out_gradient, BlockMatrix& out_hessian) = 0;
  /// What the Hessian of the last linearize() has beside its blocks.
  virtual const LowRank& low_rank() const {
    static const LowRank none;
    return none;
  }
  /// Gradient alone, at a small part of the cost. Trial energies are relative to the iterate from then on, as
  /// after linearize().
  virtual void evaluate_gradient(std::span<double> out_gradient) = 0;

  /// True while prescribed parts still have to move within this minimisation. The gradient then anticipates
  /// their motion to first order, each accepted step brings them closer, and energies along a step are not
  /// comparable.
  virtual bool has_pending_motion() const = 0;

  virtual Residual residual(std::span<const double> gradient) const = 0;
  /// The same of the blocks where more is left than rounding: what no iterate can balance, because unknowns
  /// are known to their last bit only, does not count. `hessian`: at the iterate or near it.
  virtual Residual residual_beyond_rounding(std::span<const double> gradient,
                                            const BlockMatrix& hessian) const {
    return static_cast<void>(hessian), residual(gradient);
  }
  /// Rounding of energy differences that magnitudes do not show [J], of what is stiff and at rest.
  virtual double energy_rounding(const BlockMatrix& hessian) const { return static_cast<void>(hessian), 0.0; }
  /// Largest motion of a material point under the full increment [m].
  virtual double motion(std::span<const double> direction) const = 0;

  /// Largest alpha in (0, longest] for which the path from the iterate to alpha * direction is certified free
  /// of intersections and rotations are below max_rotation [rad].
  virtual double bound_step(std::span<const double> direction, double max_rotation, double longest = 1.0) = 0;

  /// Sets the trial point to alpha * direction and evaluates it.
  virtual TrialEnergy try_step(std::span<const double> direction, double alpha) = 0;
  /// The trial point becomes the iterate.
  virtual void accept_trial() = 0;
  /// Takes the last accept_trial() back. Returns false where an objective cannot.
  virtual bool take_back() { return false; }

  /// Called between iterations once the residual is small: brings lagged quantities (friction, multipliers of
  /// joints) up to date. `round` counts the calls of this minimisation. Returns the change of force it caused
  /// [N], 0 when there is nothing left to do, infinity when constraints cannot be met.
  virtual double refresh_lagged(int round) { return static_cast<void>(round), 0.0; }
  /// Called between iterations far from a solution: brings those lagged quantities up to date (friction) that
  /// have a new energy then, which the next iterations minimise.
  virtual void refresh_early(Lagged lagged) { static_cast<void>(lagged); }
  /// Called between iterations where bound_step() keeps steps short again and again: energies of what is in
  /// the way may change.
  virtual void relieve() {}
  /// Goes back to the last converged iterate at which all that was left to do was to refresh lagged
  /// quantities once more. Returns false when there is none.
  virtual bool restore_settled() { return false; }

  /// Whether a minimum could lie as far away as the end of a direction.
  virtual bool is_within_reach(std::span<const double> direction) const {
    return static_cast<void>(direction), true;
  }
  /// True when the iterate has moved beyond any scale that a minimum could have.
  virtual bool has_run_away() const { return false; }

  /// Positions of the blocks, for fill-reducing orderings; may be empty.
  virtual std::span<const Vec3> block_positions() const { return {}; }
};

}  // namespace stark
