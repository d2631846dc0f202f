#include <stark/mechanics/constraint_set.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <limits>

namespace stark {

namespace {

/// rho over the stiffness of what is connected. The residual that a step leaves before any update is the
/// change of the force over rho; factorisations stand many orders more.
constexpr double kPenaltyFactor = 1e4;
/// A residual has to fall by this factor in an update, or its penalty grows by as much.
constexpr double kFall = 4.0;
constexpr double kLargestPenaltyFactor = 1e8;
/// Residuals below this part of the tolerance leave multipliers alone. Without it the multipliers of
/// redundant joints that contradict each other by rounding would grow without end.
constexpr double kDeadZone = 0.01;
/// Updates in a row after which joints that come no closer count as contradicting.
constexpr int kIdleUpdateLimit = 8;
/// The same in loops whose misfits are beyond the dead zone: a little is left there that hardly moves
/// anything. Their penalties do not grow: others than those that the multipliers were made for would turn
/// misfits into forces that move.
constexpr int kIdleLoopLimit = 2;

/// Part of the tolerance from which on misfits are nearly beyond it.
constexpr double kNearly = 0.9;

double beyond(double value, double zone) {
  return std::copysign(std::max(0.0, std::fabs(value) - zone), value);
}

/// Multiplier after an update. A limit lets go of all that its gap does not justify.
double updated(double multiplier, double penalty, double residual, double zone, bool one_sided) {
  if (one_sided && residual < 0.0) return std::max(0.0, multiplier + penalty * residual);
  return multiplier + penalty * beyond(residual, zone);
}

/// Norm of what counts as violation in the rows of a hold; `one_sided`: of each of them.
double norm_of_rows(std::span<const double> values, int64_t first, std::span<const char> one_sided) {
  double squared = 0.0;
  for (size_t k = 0; k < one_sided.size(); ++k) {
    const double value = values[first + static_cast<int64_t>(k)];
    const double off = one_sided[k] != 0 ? std::max(0.0, value) : value;
    squared += off * off;
  }
  return std::sqrt(squared);
}

/// Stiffness of two sides in series.
double in_series(double a, bool a_is_rigid, double b, bool b_is_rigid) {
  if (a_is_rigid) return b_is_rigid ? 0.0 : b;
  if (b_is_rigid) return a;
  return a + b > 0.0 ? a * b / (a + b) : 0.0;
}

}  // namespace

ConstraintSet::ConstraintSet(std::vector<ConstraintGroup> groups) : groups_(std::move(groups)) {
  int64_t residuals = 0;
  for (const ConstraintGroup& group : groups_) joint_count_ += group.batch.size();
  places_.resize(joint_count_);
  for (size_t g = 0; g < groups_.size(); ++g)
    for (int64_t e = 0; e < groups_[g].batch.size(); ++e) {
      places_[groups_[g].joints[e]] = {static_cast<int32_t>(g), e, residuals, coordinate_count_};
      residuals += static_cast<int64_t>(groups_[g].joint->units().size());
      coordinate_count_ += static_cast<int64_t>(groups_[g].joint->coordinates().size());
    }
  multipliers_.assign(residuals, 0.0);
  penalties_.assign(residuals, 0.0);
  enabled_.assign(joint_count_, 0.0);
}

void ConstraintSet::begin_step(std::span<const double> multipliers, std::span<const SideStiffness> sides,
                               std::span<const double> enabled, const ConstraintTolerance& tolerance,
                               const ConstraintTolerance& wanted) {
  tolerance_ = tolerance;
  wanted_ = wanted;
  multipliers_.assign(multipliers.begin(), multipliers.end());
  enabled_.assign(enabled.begin(), enabled.end());
  last_residuals_.clear();
  smallest_violation_ = std::numeric_limits<double>::infinity();
  idle_updates_ = 0;
  largest_penalties_.assign(multipliers_.size(), 0.0);
  for (int32_t j = 0; j < joint_count_; ++j) {
    const SideStiffness &a = sides[2 * j], &b = sides[2 * j + 1];
    const auto& units = groups_[places_[j].group].joint->units();
    for (size_t k = 0; k < units.size(); ++k) {
      const int64_t r = places_[j].residual + static_cast<int64_t>(k);
      const double stiffness = units[k] == ResidualUnit::Length
                                   ? in_series(a.translation, a.is_placed, b.translation, b.is_placed)
                                   : in_series(a.rotation, a.is_turned, b.rotation, b.is_turned);
      penalties_[r] = enabled[j] != 0.0 ? kPenaltyFactor * stiffness : 0.0;
      largest_penalties_[r] = kLargestPenaltyFactor * stiffness;
      if (penalties_[r] == 0.0) multipliers_[r] = 0.0;
    }
  }
  first_penalties_ = penalties_;
  write_inputs();
}

void ConstraintSet::set_forces(std::span<const double> forces) {
  multipliers_.assign(forces.begin(), forces.end());
  std::fill(penalties_.begin(), penalties_.end(), 0.0);
  write_inputs();
}

void ConstraintSet::set_inputs(const Inputs& inputs) {
  multipliers_ = inputs.multipliers;
  penalties_ = inputs.penalties;
  write_inputs();
}

std::vector<char> ConstraintSet::one_sided() const {
  std::vector<char> result(multipliers_.size());
  for (const Place& place : places_)
    std::ranges::copy(groups_[place.group].joint->one_sided(), result.begin() + place.residual);
  return result;
}

void ConstraintSet::write_inputs() {
  for (ConstraintGroup& group : groups_) {
    const size_t count = group.joint->units().size();
    if (count == 0) continue;
    const int lambda = group.batch.field_index("multiplier"), rho = group.batch.field_index("penalty");
    for (int64_t e = 0; e < group.batch.size(); ++e) {
      const int64_t r = places_[group.joints[e]].residual;
      group.batch.set(lambda, e, std::span<const double>(multipliers_).subspan(r, count));
      group.batch.set(rho, e, std::span<const double>(penalties_).subspan(r, count));
    }
    group.batch.set_resting([&](int64_t e) {
      const int64_t r = places_[group.joints[e]].residual;
      const auto is_zero = [](double value) { return value == 0.0; };
      return std::ranges::all_of(std::span(multipliers_).subspan(r, count), is_zero) &&
             std::ranges::all_of(std::span(penalties_).subspan(r, count), is_zero);
    });
  }
}

std::vector<double> ConstraintSet::misfits_of(std::span<const double> residuals,
                                              std::span<const double> held) const {
  std::vector<double> misfits(held.size());
  if (held.empty()) return misfits;
  for (size_t r = 0; r < held.size(); ++r) misfits[r] = residuals[r] - held[r];
  if (worst_of(misfits, enabled_, tolerance_).ratio > 1.0) misfits.clear();
  return misfits;
}

double ConstraintSet::update(std::span<const Vec3> x, const Relief& held) {
  std::vector<double> C = residuals(x);
  double violation = worst_of(C, enabled_, wanted_).ratio;
  if (!(violation > 1.0)) return 0.0;
  const bool holds = worst_of(C, enabled_, tolerance_).ratio <= 1.0;
  const auto give_up = [&] { return holds ? 0.0 : std::numeric_limits<double>::infinity(); };
  const std::vector<double> misfits = held ? misfits_of(C, held(C)) : std::vector<double>{};
  if (!misfits.empty()) {
    for (size_t r = 0; r < C.size(); ++r) C[r] -= misfits[r];
    violation = worst_of(C, enabled_, wanted_).ratio;
    if (holds && !(violation > 1.0)) return 0.0;
  }
  const bool is_misfit = holds && !misfits.empty() && worst_of(misfits, enabled_, wanted_).ratio > kDeadZone;
  idle_updates_ = violation < 0.5 * smallest_violation_ ? 0 : idle_updates_ + 1;
  if (idle_updates_ == 0) smallest_violation_ = violation;
  if (idle_updates_ >= (is_misfit ? kIdleLoopLimit : kIdleUpdateLimit)) return give_up();
  double change = 0.0;
  for (int32_t j = 0; j < joint_count_; ++j) {
    const Joint& joint = *groups_[places_[j].group].joint;
    int64_t r = places_[j].residual;
    size_t row = 0;
    for (const int rows : joint.hold_sizes()) {
      const double tolerance = wanted_.of(joint.units()[row]);
      const std::span<const char> one_sided = std::span(joint.one_sided()).subspan(row, rows);
      // What counts is the norm, as in worst(): each entry may be within the tolerance while it is not.
      const double size = norm_of_rows(C, r, one_sided);
      const bool is_slow = !is_misfit && !last_residuals_.empty() && size > tolerance &&
                           size * kFall > norm_of_rows(last_residuals_, r, one_sided);
      for (const size_t end = row + rows; row < end; ++row, ++r) {
        const double multiplier =
            updated(multipliers_[r], penalties_[r], C[r], kDeadZone * tolerance, joint.one_sided()[row] != 0);
        change = std::max(change, std::fabs(multiplier - multipliers_[r]));
        multipliers_[r] = multiplier;
        if (is_slow) penalties_[r] = std::min(penalties_[r] * kFall, largest_penalties_[r]);
      }
    }
  }
  last_residuals_ = C;
  write_inputs();
  return change > 0.0 ? change : give_up();
}

std::vector<double> ConstraintSet::next_multipliers(std::span<const double> residuals) const {
  std::vector<double> result = multipliers_;
  for (int32_t j = 0; j < joint_count_; ++j) {
    const Joint& joint = *groups_[places_[j].group].joint;
    for (size_t k = 0; k < joint.units().size(); ++k) {
      const int64_t r = places_[j].residual + static_cast<int64_t>(k);
      result[r] = updated(multipliers_[r], penalties_[r], residuals[r],
                          kDeadZone * wanted_.of(joint.units()[k]), joint.one_sided()[k] != 0);
    }
  }
  return result;
}

std::vector<double> ConstraintSet::reactions(std::span<const double> residuals) const {
  std::vector<double> result(residuals.begin(), residuals.end());
  for (const Place& place : places_) turn_into_reactions(place, std::span(result).subspan(place.residual));
  return result;
}

std::vector<double> ConstraintSet::reactions_of(int32_t first, int32_t count, std::span<const Vec3> x) const {
  std::vector<double> result = residuals_of(first, count, x);
  size_t row = 0;
  for (int32_t j = first; j < first + count; ++j) {
    turn_into_reactions(places_[j], std::span(result).subspan(row));
    row += groups_[places_[j].group].joint->units().size();
  }
  return result;
}

void ConstraintSet::turn_into_reactions(const Place& place, std::span<double> residuals) const {
  const std::vector<char>& one_sided = groups_[place.group].joint->one_sided();
  for (size_t k = 0; k < one_sided.size(); ++k) {
    const size_t r = static_cast<size_t>(place.residual) + k;
    residuals[k] = multipliers_[r] + penalties_[r] * residuals[k];
    if (one_sided[k] != 0) residuals[k] = std::max(0.0, residuals[k]);
  }
}

ConstraintSet::Violation ConstraintSet::worst_of(std::span<const double> C, std::span<const double> enabled,
                                                 const ConstraintTolerance& tolerance) const {
  Violation worst;
  for (int32_t j = 0; j < joint_count_; ++j) {
    if (enabled[j] == 0.0) continue;
    const Violation violation = worst_of_joint(C, j, tolerance);
    if (violation.ratio > worst.ratio) worst = violation;
  }
  return worst;
}

ConstraintSet::Violation ConstraintSet::worst_of_joint(std::span<const double> C, int32_t j,
                                                       const ConstraintTolerance& tolerance) const {
  Violation worst;
  const Joint& joint = *groups_[places_[j].group].joint;
  size_t row = 0;
  for (const int rows : joint.hold_sizes()) {
    const ResidualUnit unit = joint.units()[row];
    const std::span<const char> one_sided = std::span(joint.one_sided()).subspan(row, rows);
    const double size = norm_of_rows(C, places_[j].residual + static_cast<int64_t>(row), one_sided);
    const double ratio = size / tolerance.of(unit);
    if (ratio > worst.ratio) worst = {ratio, j, size, unit};
    row += static_cast<size_t>(rows);
  }
  return worst;
}

std::vector<ConstraintSet::Violation> ConstraintSet::nearly_beyond(std::span<const double> residuals) const {
  std::vector<Violation> result;
  for (int32_t j = 0; j < joint_count_; ++j) {
    if (enabled_[j] == 0.0) continue;
    const Violation violation = worst_of_joint(residuals, j, tolerance_);
    if (violation.ratio > kNearly) result.push_back(violation);
  }
  std::ranges::stable_sort(result, std::ranges::greater{}, &Violation::ratio);
  return result;
}

namespace {

/// Outputs [first, first + count) of the values of all elements of a group.
void append_values(const ConstraintGroup& group, std::span<const Vec3> x, size_t first, size_t count,
                   std::vector<double>& out) {
  if (count == 0) return;
  const std::vector<double> values = group.batch.evaluate(group.joint->values(), x);
  const size_t outputs = static_cast<size_t>(group.joint->values().output_count());
  for (int64_t e = 0; e < group.batch.size(); ++e)
    out.insert(out.end(), values.begin() + e * outputs + first, values.begin() + e * outputs + first + count);
}

}  // namespace

std::vector<double> ConstraintSet::residuals(std::span<const Vec3> x) const {
  std::vector<double> result;
  for (const ConstraintGroup& group : groups_)
    append_values(group, x, 0, group.joint->units().size(), result);
  return result;
}

std::vector<double> ConstraintSet::residuals_of(int32_t first, int32_t count, std::span<const Vec3> x) const {
  std::vector<double> result;
  for (int32_t j = first; j < first + count;) {
    const int32_t g = places_[j].group;
    ConstraintGroup part{groups_[g].joint, PotentialBatch(groups_[g].joint->potential()), {}};
    std::vector<int64_t> elements;
    std::vector<int32_t> stencils;
    for (; j < first + count && places_[j].group == g; ++j) {
      elements.push_back(places_[j].element);
      std::ranges::copy(groups_[g].batch.stencil(places_[j].element), std::back_inserter(stencils));
    }
    part.batch.resize(stencils);
    part.batch.take(groups_[g].batch, elements);
    append_values(part, x, 0, part.joint->units().size(), result);
  }
  return result;
}

std::vector<double> ConstraintSet::coordinates(std::span<const Vec3> x) const {
  std::vector<double> result;
  for (const ConstraintGroup& group : groups_)
    append_values(group, x, group.joint->units().size(), group.joint->coordinates().size(), result);
  return result;
}

}  // namespace stark
