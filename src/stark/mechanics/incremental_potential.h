// The objective of one time step: static batches (inertia, elasticity, loads) plus an active set (contact),
// as a function of increments of the configuration.
//
// Prescribed sites move during the minimisation: with progress s in [0, 1] they are at (1 - s) start + s
// target, each Newton step carries s along by its step length, and the gradient anticipates the rest of the
// motion. So the path of every vertex between iterates is linear, which is what the collision detection
// certifies. [theory eq. 7]
#pragma once

#include <limits>
#include <memory>
#include <optional>

#include <stark/base/timer.h>
#include <stark/mechanics/active_set.h>
#include <stark/mechanics/assembler.h>
#include <stark/mechanics/constraint_set.h>
#include <stark/mechanics/self_stress.h>
#include <stark/mechanics/site_positions.h>
#include <stark/solve/objective.h>

namespace stark {

/// Converts forces on a block into accelerations of material: |M^-1 f| for points, and for the rotational
/// block of a body the surface acceleration |J^-1 tau| r.
struct BlockScale {
  double inverse_inertia = 0.0;  ///< [1/kg], or r / J_min [1/(kg m)]
  double inverse_length = 1.0;   ///< 1, or 1/r for torques [1/m]
  double reach = 1.0;            ///< motion of material per unit of the unknown: 1, or r [m]
};

class IncrementalPotential final : public Objective {
 public:
  /// active_set and constraints may be null. scales has one entry per block.
  IncrementalPotential(const KinematicMap& map, Assembler& assembler, ActiveSet* active_set,
                       ConstraintSet* constraints, std::vector<BlockScale> scales, PhaseTimer& timer);

  /// How often the lagged quantities of the active set (friction) are refreshed in a minimisation.
  void set_active_set_updates(int updates) { active_set_updates_ = updates; }
  /// How far a site may move within a minimisation before that counts as running away [m].
  void set_motion_limit(double limit) { motion_limit_ = limit; }

  /// What takes from joints in loops what they do to each other.
  void set_self_stress(SelfStress* self_stress) { self_stress_ = self_stress; }
  /// What constraints leave to the next step, less that.
  SelfStress::End end_constraints() const;

  /// Starts a minimisation from `start` towards the prescribed poses and points of `target` (free parts of
  /// `target` are ignored).
  void begin(const Configuration& start, const Configuration& target);

  const Configuration& configuration() const { return iterate_; }
  std::span<const Vec3> site_positions() const { return x_; }
  /// The same with those of bodies that rest in this minimisation.
  SitePositions known_positions() const { return known(x_); }
  /// Whether nothing moves a body in this minimisation.
  bool rests(int32_t body) const { return resting_[body] != 0; }
  /// Sites that no unknown moves, ascending, without those of bodies that rest.
  std::span<const int32_t> driven_sites() const { return driven_sites_; }
  /// Sites [m] at the end of a Newton step, which is shortened where it turns a body by more than
  /// `max_rotation` [rad]. The trial point moves there.
  std::vector<Vec3> positions_along(std::span<const double> direction, double max_rotation);

  int32_t block_count() const override { return map_.layout().block_count; }
  void linearize(bool project, std::span<double> out_gradient, BlockMatrix& out_hessian) override;
  const LowRank& low_rank() const override { return assembler_.low_rank(); }
  void evaluate_gradient(std::span<double> out_gradient) override;
  bool has_pending_motion() const override { return progress_ < 1.0; }
  Residual residual(std::span<const double> gradient) const override;
  Residual residual_beyond_rounding(std::span<const double> gradient,
                                    const BlockMatrix& hessian) const override;
  double energy_rounding(const BlockMatrix& hessian) const override;
  double motion(std::span<const double> direction) const override;
  double bound_step(std::span<const double> direction, double max_rotation, double longest = 1.0) override;
  TrialEnergy try_step(std::span<const double> direction, double alpha) override;
  void accept_trial() override;
  bool take_back() override;
  double refresh_lagged(int round) override;
  void refresh_early(Lagged lagged) override;
  void relieve() override;
  bool restore_settled() override;
  bool is_within_reach(std::span<const double> direction) const override;
  bool has_run_away() const override;
  std::span<const Vec3> block_positions() const override { return block_positions_; }

 private:
  double update_constraints();
  void settle(const ConstraintSet::Inputs& inputs);
  void update_active_set(Curvature curvature);
  void set_trial(std::span<const double> direction, double alpha);
  double bound_rotation(std::span<const double> direction, double max_rotation, double longest) const;
  void place_prescribed(double progress, std::span<Vec3> x) const;
  void find_resting(const Configuration& start, const Configuration& target);
  void find_driven_sites();
  SitePositions known(std::span<const Vec3> x) const { return {x, moving_sites_, still_}; }

  const KinematicMap& map_;
  Assembler& assembler_;
  ActiveSet* active_set_;
  ConstraintSet* constraints_;
  SelfStress* self_stress_ = nullptr;
  int active_set_updates_ = 1;
  std::vector<BlockScale> scales_;
  PhaseTimer& timer_;
  Configuration start_, iterate_, trial_, target_;
  std::optional<Configuration> settled_;                 ///< converged but for lagged quantities
  std::optional<ConstraintSet::Inputs> settled_inputs_;  ///< of constraints, with which it has converged
  std::vector<Vec3> x_, x_trial_;                        ///< by site [m]
  std::optional<double> trial_alpha_;                    ///< that trial_ and x_trial_ are at, while they are
  std::vector<double> trial_direction_;
  std::vector<Vec3> x_start_;  ///< of the minimisation, where motion is limited
  double motion_limit_ = std::numeric_limits<double>::infinity();
  std::vector<Vec3> prescribed_start_, prescribed_target_, pending_;
  std::vector<Vec3> x_target_;  ///< where bodies rest and where nothing is prescribed, of any time [m]
  std::vector<int32_t> prescribed_sites_, prescribed_points_, embedded_sites_;
  std::vector<SiteRange> moving_sites_;    ///< all but those of bodies that rest
  uint64_t still_ = 0;                     ///< number of the positions of these, see SitePositions
  std::vector<int32_t> driven_sites_;      ///< of prescribed_sites_, without those of bodies that rest
  std::vector<uint8_t> resting_, placed_;  ///< by body: rests; and x_ and x_trial_ have its sites
  std::vector<int32_t> pinned_bodies_;     ///< prescribed translation, free rotation
  std::vector<int32_t> lever_sites_;       ///< points on them that their rotation moves
  std::vector<int32_t> rotation_blocks_;
  std::vector<Vec3> block_positions_;
  double progress_ = 1.0, trial_progress_ = 1.0;
  double certified_alpha_ = 0.0;
  KinematicMap::Way trial_way_ = KinematicMap::Way::Straight;
  bool is_bound_straight_ = true;  ///< the whole way that the last bound_step() has looked at
};

}  // namespace stark
