// Energies whose stencils change with the configuration. Contact implements this; mechanics knows nothing of
// contact.
#pragma once

#include <span>
#include <vector>

#include <stark/mechanics/assembler.h>
#include <stark/mechanics/site_positions.h>
#include <stark/solve/objective.h>

namespace stark {

/// Whether second derivatives are those of the energies, or, where there is something better for Newton's
/// method, those of convex functions with the same gradients.
enum class Curvature : uint8_t { Exact, Modelled };

class ActiveSet {
 public:
  virtual ~ActiveSet() = default;

  /// Rebuilds the stencils active at site positions x and remembers their energies.
  /// batches' stencils changed.
  virtual void update(const SitePositions& x) = 0;
  /// Batches with energies of the active stencils, up to a constant, and their gradients at the last
  /// update(); valid until the next call of this or of update().
  virtual std::vector<const PotentialBatch*> batches(Curvature curvature) = 0;

  /// Makes sure that no pair is missed while sites move from x0 to x1 and returns the largest safe fraction
  /// in [0, 1] of the linear motion.
  virtual double max_step(std::span<const Vec3> x0, std::span<const Vec3> x1) = 0;

  /// Energies at x minus those at the last update(), pair by pair. x must be within the motion announced to
  /// max_step().
  virtual EnergyDifference energy_difference(const SitePositions& x) = 0;

  /// Refreshes lagged quantities at x; returns the change of force [N].
  virtual double refresh_lagged(const SitePositions& x) = 0;
  /// The same far from a solution: what is lagged is taken anew, however often.
  virtual void refresh_early(const SitePositions& x, Lagged lagged) {
    static_cast<void>(x), static_cast<void>(lagged);
  }
  /// Called where max_step() keeps steps short again and again: energies of what is in the way may change for
  /// the rest of the step. Returns whether any has.
  virtual bool relieve(const SitePositions& x) { return static_cast<void>(x), false; }
  /// The lagged quantities before the last refresh belong to a solution that may be gone back to.
  virtual void keep_lagged() = 0;
  /// Goes back to the lagged quantities that were kept last.
  virtual void restore_lagged() = 0;
};

}  // namespace stark
