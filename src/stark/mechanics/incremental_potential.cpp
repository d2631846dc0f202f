#include <stark/mechanics/incremental_potential.h>

#include <algorithm>
#include <atomic>
#include <cmath>

#include <stark/base/error.h>
#include <stark/mechanics/force_rounding.h>

namespace stark {

namespace {

Vec3 block_of(std::span<const double> values, int32_t block) {
  return {values[3 * block], values[3 * block + 1], values[3 * block + 2]};
}

/// Whether a point is an embedded site, which has no position of its own.
bool follows(const KinematicMap& map, int32_t point) {
  return point < map.site_count() && map.is_embedded(point);
}

/// Forces of rounding, over those of positions that are known to their last bit: sums of terms that cancel.
constexpr double kRoundingFactor = 4.0;

/// Part of a safe fraction that is used: what remains keeps the next iteration from starting in contact.
/// Motion over its limit, and turn of a body [rad], beyond which a direction says nothing of where a minimum
/// is.
constexpr double kReach = 2.0, kLargestTurn = 10.0;
constexpr double kSafeFraction = 0.95;

uint64_t next_number() {
  static std::atomic<uint64_t> last{0};
  return ++last;
}

}  // namespace

IncrementalPotential::IncrementalPotential(const KinematicMap& map, Assembler& assembler,
                                           ActiveSet* active_set, ConstraintSet* constraints,
                                           std::vector<BlockScale> scales, PhaseTimer& timer)
    : map_(map),
      assembler_(assembler),
      active_set_(active_set),
      constraints_(constraints),
      scales_(std::move(scales)),
      timer_(timer) {
  STARK_CHECK(static_cast<int32_t>(scales_.size()) == block_count());
  const DofLayout& layout = map_.layout();
  for (size_t b = 0; b < layout.rotation_block.size(); ++b) {
    if (layout.rotation_block[b] == kNoBlock) continue;
    rotation_blocks_.push_back(layout.rotation_block[b]);
    if (layout.body_block[b] == kNoBlock) pinned_bodies_.push_back(static_cast<int32_t>(b));
  }
  // Sites that nothing moves and that can be scripted.
  for (int32_t i = 0; i < map_.site_count(); ++i)
    if (map_.is_prescribed(i)) prescribed_sites_.push_back(i);
  // Points embedded between free and prescribed ones follow both, as do levers on pinned nodes of rods.
  for (int32_t i = 0; i < map_.site_count(); ++i)
    if (!map_.support(i).points.empty() && !map_.is_prescribed(i)) embedded_sites_.push_back(i);
  for (int32_t i = 0; i < map_.site_count(); ++i)
    if (map_.site(i).kind == SiteKind::RigidPoint && !map_.is_prescribed(i) &&
        layout.body_block[map_.site(i).index] == kNoBlock)
      lever_sites_.push_back(i);
  for (size_t p = 0; p < layout.point_block.size(); ++p)
    if (layout.point_block[p] == kNoBlock && !follows(map_, static_cast<int32_t>(p)))
      prescribed_points_.push_back(static_cast<int32_t>(p));
  x_.resize(map_.site_count());
  x_trial_.resize(map_.site_count());
  x_target_.resize(map_.site_count());
  resting_.assign(layout.body_block.size(), 0);
  driven_sites_ = prescribed_sites_;
  block_positions_.resize(block_count());
}

void IncrementalPotential::begin(const Configuration& start, const Configuration& target) {
  find_resting(start, target);
  start_ = start;
  iterate_ = start;
  trial_alpha_.reset();
  settled_.reset();
  target_ = target;
  map_.positions(start, x_, &assembler_.pool(), placed_);
  if (placed_ != resting_) map_.positions(start, x_trial_, &assembler_.pool(), placed_);
  if (std::isfinite(motion_limit_)) x_start_ = x_;
  if (!driven_sites_.empty()) map_.positions(target, x_target_, &assembler_.pool(), resting_);
  prescribed_start_.clear();
  prescribed_target_.clear();
  bool moves = false;
  for (const int32_t site : driven_sites_) {
    prescribed_start_.push_back(x_[site]);
    prescribed_target_.push_back(x_target_[site]);
    moves = moves || !(x_[site] == x_target_[site]);
  }
  progress_ = moves ? 0.0 : 1.0;
  const DofLayout& layout = map_.layout();
  for (size_t p = 0; p < layout.point_block.size(); ++p)
    if (layout.point_block[p] != kNoBlock) block_positions_[layout.point_block[p]] = start.point_position[p];
  for (size_t b = 0; b < layout.body_block.size(); ++b)
    for (const int32_t block : {layout.body_block[b], layout.rotation_block[b]})
      if (block != kNoBlock) block_positions_[block] = start.body_position[b];
}

// Terrain has far more sites than what moves on it.
void IncrementalPotential::find_resting(const Configuration& start, const Configuration& target) {
  const DofLayout& layout = map_.layout();
  const auto is_at_same_place = [](const Configuration& a, const Configuration& b, size_t body) {
    return a.body_position[body] == b.body_position[body] && a.body_rotation[body] == b.body_rotation[body];
  };
  const std::vector<uint8_t> before = resting_;
  placed_.assign(resting_.size(), 0);
  for (size_t b = 0; b < resting_.size(); ++b) {
    const bool is_prescribed = layout.body_block[b] == kNoBlock && layout.rotation_block[b] == kNoBlock;
    resting_[b] = is_prescribed && is_at_same_place(start, target, b);
    placed_[b] = resting_[b] != 0 && before[b] != 0 && is_at_same_place(start, start_, b);
  }
  const bool is_known = resting_ == before;
  if (!is_known) find_driven_sites();
  if (!is_known || placed_ != resting_) still_ = next_number();
}

void IncrementalPotential::find_driven_sites() {
  const auto is_still = [&](int32_t i) {
    const Site& site = map_.site(i);
    const bool is_of_body = site.kind == SiteKind::RigidPoint || site.kind == SiteKind::RigidDirection;
    return is_of_body && rests(site.index);
  };
  driven_sites_.clear();
  for (const int32_t i : prescribed_sites_)
    if (!is_still(i)) driven_sites_.push_back(i);
  moving_sites_.clear();
  for (int32_t i = 0; i < map_.site_count(); ++i) {
    if (is_still(i)) continue;
    if (moving_sites_.empty() || moving_sites_.back().end != i) moving_sites_.push_back({i, i});
    moving_sites_.back().end = i + 1;
  }
}

void IncrementalPotential::place_prescribed(double progress, std::span<Vec3> x) const {
  for (size_t k = 0; k < driven_sites_.size(); ++k)
    x[driven_sites_[k]] =
        progress >= 1.0 ? prescribed_target_[k]
                        : prescribed_start_[k] + (prescribed_target_[k] - prescribed_start_[k]) * progress;
}

void IncrementalPotential::update_active_set(Curvature curvature) {
  if (!active_set_) return;
  const PhaseTimer::Scope scope(timer_, Phase::ActiveSet);
  active_set_->update(known(x_));
  assembler_.set_dynamic_batches(active_set_->batches(curvature));
}

void IncrementalPotential::evaluate_gradient(std::span<double> out_gradient) {
  STARK_CHECK(!has_pending_motion());
  update_active_set(Curvature::Exact);
  const PhaseTimer::Scope scope(timer_, Phase::Assemble);
  assembler_.assemble_gradient(iterate_, x_, out_gradient);
}

void IncrementalPotential::linearize(bool project, std::span<double> out_gradient, BlockMatrix& out_hessian) {
  update_active_set(Curvature::Modelled);
  const PhaseTimer::Scope scope(timer_, Phase::Assemble);
  AssemblyOptions options{.project = project, .pending = {}, .pairs = ScatterPairs::All};
  if (has_pending_motion()) {
    pending_.assign(map_.site_count(), Vec3{});
    for (size_t k = 0; k < driven_sites_.size(); ++k)
      pending_[driven_sites_[k]] = prescribed_target_[k] - x_[driven_sites_[k]];
    for (const int32_t i : embedded_sites_) {
      const SiteSupport s = map_.support(i);
      for (size_t k = 0; k < s.points.size(); ++k)
        if (const int32_t p = s.points[k]; map_.layout().point_block[p] == kNoBlock)
          pending_[i] += (target_.point_position[p] - iterate_.point_position[p]) * s.weights[k];
    }
    for (const int32_t i : lever_sites_) {
      const int32_t b = map_.site(i).index;
      pending_[i] = target_.body_position[b] - iterate_.body_position[b];
    }
    options.pending = pending_;
  }
  assembler_.assemble(iterate_, x_, options, out_gradient, out_hessian);
}

Residual IncrementalPotential::residual(std::span<const double> gradient) const {
  Residual residual;
  for (int32_t block = 0; block < block_count(); ++block) {
    const double force = norm(block_of(gradient, block));
    residual.force = std::max(residual.force, force * scales_[block].inverse_length);
    residual.acceleration = std::max(residual.acceleration, force * scales_[block].inverse_inertia);
  }
  return residual;
}

Residual IncrementalPotential::residual_beyond_rounding(std::span<const double> gradient,
                                                        const BlockMatrix& hessian) const {
  const std::vector<double> rounding = force_rounding(hessian, block_positions_, map_.layout());
  Residual residual;
  for (int32_t block = 0; block < block_count(); ++block) {
    const double force = norm(block_of(gradient, block));
    if (force <= kRoundingFactor * rounding[block]) continue;
    residual.force = std::max(residual.force, force * scales_[block].inverse_length);
    residual.acceleration = std::max(residual.acceleration, force * scales_[block].inverse_inertia);
  }
  return residual;
}

double IncrementalPotential::energy_rounding(const BlockMatrix& hessian) const {
  return stark::energy_rounding(hessian, block_positions_, map_.layout());
}

double IncrementalPotential::motion(std::span<const double> direction) const {
  double motion = 0.0;
  for (int32_t block = 0; block < block_count(); ++block)
    motion = std::max(motion, norm(block_of(direction, block)) * scales_[block].reach);
  return motion;
}

void IncrementalPotential::set_trial(std::span<const double> direction, double alpha) {
  // The point whose way was bounded is the first that is tried.
  if (trial_alpha_ == alpha && std::ranges::equal(direction, trial_direction_)) return;
  trial_alpha_ = alpha;
  trial_direction_.assign(direction.begin(), direction.end());
  // Directions towards prescribed parts that turn have the chords of their turns.
  const auto way = has_pending_motion() ? KinematicMap::Way::Straight : KinematicMap::Way::Turning;
  trial_way_ = map_.retract(iterate_, direction, alpha, way, trial_);
  trial_progress_ = alpha >= 1.0 ? 1.0 : progress_ + alpha * (1.0 - progress_);
  for (const int32_t p : prescribed_points_)
    trial_.point_position[p] =
        trial_progress_ >= 1.0 ? target_.point_position[p]
                               : start_.point_position[p] +
                                     (target_.point_position[p] - start_.point_position[p]) * trial_progress_;
  if (!prescribed_points_.empty()) map_.follow(trial_.point_position);
  for (const int32_t b : pinned_bodies_)
    trial_.body_position[b] =
        trial_progress_ >= 1.0 ? target_.body_position[b]
                               : start_.body_position[b] +
                                     (target_.body_position[b] - start_.body_position[b]) * trial_progress_;
  map_.positions(trial_, x_trial_, &assembler_.pool(), resting_);
  place_prescribed(trial_progress_, x_trial_);
}

double IncrementalPotential::bound_rotation(std::span<const double> direction, double max_rotation,
                                            double longest) const {
  double alpha = longest;
  for (const int32_t block : rotation_blocks_) {
    const double angle = norm(block_of(direction, block));
    if (angle * alpha > max_rotation) alpha = max_rotation / angle;
  }
  return alpha;
}

std::vector<Vec3> IncrementalPotential::positions_along(std::span<const double> direction,
                                                        double max_rotation) {
  set_trial(direction, bound_rotation(direction, max_rotation, 1.0));
  return x_trial_;
}

double IncrementalPotential::bound_step(std::span<const double> direction, double max_rotation,
                                        double longest) {
  double alpha = bound_rotation(direction, max_rotation, longest);
  certified_alpha_ = alpha;
  if (!active_set_) return alpha;
  // Linear vertex paths are certified. Where bodies turn, the pose at a smaller alpha is off the path to the
  // larger one, so a shortened step is tested again until it is safe as a whole.
  set_trial(direction, alpha);
  is_bound_straight_ = rotation_blocks_.empty() && trial_way_ == KinematicMap::Way::Straight;
  while (alpha > 0.0) {
    const double fraction = active_set_->max_step(x_, x_trial_);
    if (fraction >= 1.0) break;
    alpha *= kSafeFraction * fraction;
    if (is_bound_straight_ || alpha < 1e-14) break;
    set_trial(direction, alpha);
  }
  certified_alpha_ = alpha;
  return alpha;
}

TrialEnergy IncrementalPotential::try_step(std::span<const double> direction, double alpha) {
  set_trial(direction, alpha);
  TrialEnergy trial;
  // Where nothing turns a smaller step lies on the certified path; else it has a path of its own.
  if (active_set_ && !is_bound_straight_ && alpha != certified_alpha_ &&
      active_set_->max_step(x_, x_trial_) < 1.0)
    return trial;
  const EnergyDifference fixed = assembler_.static_energy_difference(x_trial_);
  trial.difference = fixed.difference;
  trial.magnitude = fixed.magnitude;
  if (active_set_) {
    const EnergyDifference active = active_set_->energy_difference(known(x_trial_));
    trial.contact = active.difference;
    trial.difference += active.difference;
    trial.magnitude += active.magnitude;
  }
  trial.feasible = std::isfinite(trial.difference);
  return trial;
}

void IncrementalPotential::accept_trial() {
  std::swap(iterate_, trial_);
  std::swap(x_, x_trial_);
  trial_alpha_.reset();
  progress_ = trial_progress_;
  if (progress_ >= 1.0) {
    // Prescribed parts have arrived: from here on the configuration holds their exact target.
    const DofLayout& layout = map_.layout();
    for (size_t b = 0; b < layout.body_block.size(); ++b) {
      if (layout.body_block[b] == kNoBlock) iterate_.body_position[b] = target_.body_position[b];
      if (layout.rotation_block[b] == kNoBlock) iterate_.body_rotation[b] = target_.body_rotation[b];
    }
  }
}

bool IncrementalPotential::take_back() {
  std::swap(iterate_, trial_);
  std::swap(x_, x_trial_);
  trial_alpha_.reset();
  if (active_set_) active_set_->update(known(x_));
  return true;
}

double IncrementalPotential::refresh_lagged(int round) {
  const PhaseTimer::Scope scope(timer_, Phase::Friction);
  const ConstraintSet::Inputs inputs = constraints_ ? constraints_->inputs() : ConstraintSet::Inputs{};
  const double violation = update_constraints();
  const double change =
      active_set_ && round < active_set_updates_ ? active_set_->refresh_lagged(known(x_)) : 0.0;
  // Joints that are within their tolerances are held enough if the updates beyond them lead nowhere.
  const bool is_held = violation == 0.0 || constraints_->worst(x_).ratio <= 1.0;
  const bool goes_on = active_set_ ? change > 0.0 && round > 0 : violation > 0.0;
  if (is_held && goes_on) settle(inputs);
  return std::max(change, violation);
}

void IncrementalPotential::settle(const ConstraintSet::Inputs& inputs) {
  settled_ = iterate_;
  if (constraints_) settled_inputs_ = inputs;
  if (active_set_) active_set_->keep_lagged();
}

double IncrementalPotential::update_constraints() {
  if (!constraints_) return 0.0;
  if (!self_stress_) return constraints_->update(x_);
  return constraints_->update(
      x_, [&](std::span<const double> residuals) { return self_stress_->held(iterate_, x_, residuals); });
}

SelfStress::End IncrementalPotential::end_constraints() const { return self_stress_->end(iterate_, x_); }

void IncrementalPotential::refresh_early(Lagged lagged) {
  const PhaseTimer::Scope scope(timer_, Phase::Friction);
  if (active_set_) active_set_->refresh_early(known(x_), lagged);
}

void IncrementalPotential::relieve() {
  if (active_set_ && active_set_->relieve(known(x_))) settled_.reset();  // of other energies
}

bool IncrementalPotential::restore_settled() {
  if (!settled_) return false;
  iterate_ = *settled_;
  trial_alpha_.reset();
  settled_.reset();
  map_.positions(iterate_, x_, nullptr, resting_);
  place_prescribed(1.0, x_);
  if (constraints_) constraints_->set_inputs(*settled_inputs_);
  if (active_set_) {
    active_set_->restore_lagged();
    active_set_->update(known(x_));
  }
  return true;
}

// As far as has_run_away() and farther, so that what nothing holds gets there at once.
bool IncrementalPotential::is_within_reach(std::span<const double> direction) const {
  if (!std::isfinite(motion_limit_)) return true;
  return motion(direction) <= kReach * motion_limit_ && bound_rotation(direction, kLargestTurn, 1.0) == 1.0;
}

bool IncrementalPotential::has_run_away() const {
  if (!std::isfinite(motion_limit_)) return false;
  for (size_t i = 0; i < x_.size(); ++i) {
    const bool is_place = map_.site(static_cast<int32_t>(i)).kind != SiteKind::RigidDirection;
    if (is_place && squared_norm(x_[i] - x_start_[i]) > motion_limit_ * motion_limit_) return true;
  }
  return false;
}

}  // namespace stark
