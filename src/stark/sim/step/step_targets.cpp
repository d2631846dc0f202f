// Where a step starts from, where it is to bring what is prescribed and what is free, and how long it may be
// for that (step phases 1 and 2).
#include <algorithm>
#include <limits>
#include <numbers>

#include <stark/base/rotation.h>
#include <stark/sim/model/script_phase.h>
#include <stark/sim/step/step_motion.h>
#include <stark/sim/step/time_marks.h>

namespace stark {

namespace {

/// Angle that scripted bodies turn by in a step at most: from half a turn on, nothing would tell the sense,
/// and friction sees chords, which are off from the way at their end by half of it.
constexpr double kLargestTurn = std::numbers::pi / 8.0;

/// The same for free bodies: inertia resists a turn away from free motion by the sine of its angle, which
/// falls again from a quarter turn on.
constexpr double kLargestFreeTurn = std::numbers::pi / 2.0;

/// Angle by which a free body turns about its angular momentum in a step at most. What holds its axis, as
/// bearings hold that of a gyroscope, acts at the end of the step only: from about 2.3 rad on with implicit
/// Euler, and 1.2 rad with bdf2, it drives the nutation instead of damping it.
constexpr double kLargestNutation = std::numbers::pi / 2.0;
constexpr double kLargestBdf2Nutation = std::numbers::pi / 4.0;

/// Parts of a full step that a free body may ask for. A needle that turns faster, a million times a second
/// after an impact, is left to its momentum: it would hold up everything else.
constexpr double kMostTurningSteps = 256.0;

/// Scale that switches inertia and damping off in quasistatic steps [s].
constexpr double kQuasistaticStep = 1e150;

/// Rate at which a body turns about its angular momentum L, |L|/J_t [rad/s]. J_t is the moment across the
/// axis of the symmetric top that is nearest to it: of discs and of needles the middle one of the three.
double nutation_rate(const Vec3& J, double L) {
  const double middle = std::max(std::min(J.x, J.y), std::min(std::max(J.x, J.y), J.z));
  return middle > 0.0 ? L / middle : 0.0;
}

}  // namespace

double StepMotion::longest_turning_step() const {
  const DofLayout& layout = model_.map().layout();
  double longest = std::numeric_limits<double>::infinity();
  const double nutation = has_history(settings_.time.integrator) ? kLargestBdf2Nutation : kLargestNutation;
  for (size_t b = 0; b < state_.body_rotation.size(); ++b) {
    if (model_.rigid_masses()[b].is_frame) continue;
    const bool is_free = layout.rotation_block[b] != kNoBlock;
    const bool is_at_velocity = script_phase(state_.script_remaining[b]) == ScriptPhase::Velocity;
    if (is_free ? !has_inertia(settings_.time.integrator) : !is_at_velocity) continue;
    const auto limit = [&](double step) {
      if (is_free && step < settings_.time.step / kMostTurningSteps) return;
      longest = std::min(longest, std::max(settings_.time.min_step, step));
    };
    limit((is_free ? kLargestFreeTurn : kLargestTurn) / norm(state_.body_angular_velocity[b]));
    if (is_free) limit(nutation / nutation_rate(model_.rigid_masses()[b].moments, norm(spin(b))));
  }
  return longest;
}

Configuration StepMotion::start_configuration() const {
  return {state_.point_position, state_.body_position, state_.body_rotation};
}

Configuration StepMotion::target_configuration(double h) const {
  Configuration target = start_configuration();
  if (state_.pin_remaining > 0.0) {
    const double fraction = std::min(1.0, h / state_.pin_remaining);
    const auto& blocks = model_.map().layout().point_block;
    for (size_t p = 0; p < blocks.size(); ++p)
      if (blocks[p] == kNoBlock) {
        const Vec3& from = target.point_position[p];
        target.point_position[p] =
            fraction >= 1.0 ? state_.pin_target[p] : from + (state_.pin_target[p] - from) * fraction;
      }
  }
  for (size_t b = 0; b < target.body_position.size(); ++b) {
    const DofLayout& layout = model_.map().layout();
    if (layout.body_block[b] != kNoBlock && layout.rotation_block[b] != kNoBlock) continue;
    const ScriptPhase phase = script_phase(state_.script_remaining[b]);
    if (phase == ScriptPhase::Moving) {
      const double fraction = std::min(1.0, h / state_.script_remaining[b]);
      target.body_position[b] += (state_.script_position[b] - target.body_position[b]) * fraction;
      target.body_rotation[b] = fraction >= 1.0 ? state_.script_rotation[b]
                                                : interpolate_rotation(target.body_rotation[b],
                                                                       state_.script_rotation[b], fraction);
    } else if (phase == ScriptPhase::Velocity) {
      target.body_position[b] += state_.body_velocity[b] * h;
      target.body_rotation[b] = exp_rotation(state_.body_angular_velocity[b] * h) * target.body_rotation[b];
    }
  }
  return target;
}

std::vector<double> StepMotion::free_increments(double h) const {
  const DofLayout& layout = model_.map().layout();
  std::vector<double> increments(3 * static_cast<size_t>(layout.block_count), 0.0);
  const auto set = [&](const std::vector<int32_t>& blocks, const std::vector<Vec3>& velocity) {
    for (size_t i = 0; i < blocks.size(); ++i)
      if (blocks[i] != kNoBlock)
        for (int k = 0; k < 3; ++k) increments[3 * static_cast<size_t>(blocks[i]) + k] = h * velocity[i][k];
  };
  set(layout.point_block, state_.point_velocity);
  set(layout.body_block, state_.body_velocity);
  set(layout.rotation_block, state_.body_angular_velocity);
  return increments;
}

void StepMotion::predict(double h) {
  const double duration = reference_.stencil.duration;
  predict(h, duration, !has_inertia(settings_.time.integrator) ? kQuasistaticStep : duration);
}

void StepMotion::predict(double h, double duration, double scale) {
  const std::span<const Vec3> x = reference_.sites;
  const double time = reference_.time = end_of_step(state_, h);
  reference_.scale = scale;
  reference_.flow_scale = 0.5 * h * (scale / reference_.stencil.duration);
  // 1/(sigma s): smooth forces act for s on velocities that are displacements over sigma.
  const double inertia = scale == kQuasistaticStep
                             ? 0.0
                             : reference_.stencil.duration / reference_.stencil.scale / (scale * scale);
  for (ConstraintGroup& group : energies_.constraints.groups()) {
    group.batch.set_previous(x);
    group.batch.set_time(scale, time);
  }
  for (ModelQuadrature& elements : energies_.quadrature) {
    set_previous(elements.batch);
    set_clock(elements.batch);
  }
  for (ModelBatch& batch : energies_.batches) {
    set_previous(batch.batch);
    set_clock(batch.batch);
    if (!batch.is_inertia()) continue;
    batch.batch.set_uniform("inverse_scale_squared", inertia);
    const int field = batch.batch.field_index("predicted");
    for (int64_t e = 0; e < batch.batch.size(); ++e) {
      const int32_t subject = batch.subject[e];
      Vec3 predicted;
      if (batch.role == ModelBatch::Role::RotationalInertia)
        predicted = reference_.free_rotation[subject / 3].column(subject % 3);
      else
        predicted =
            x[batch.batch.stencil(e)[0]] + duration * (subject >= 0 ? reference_.point_velocity[subject]
                                                                    : reference_.body_velocity[-1 - subject]);
      batch.batch.set(field, e, {&predicted.x, 3});
    }
  }
}

}  // namespace stark
