// Rotation of rigid bodies and of frames of rods: what free motion brings them to, and what the torques of a
// step make of it (step phases 1 and 6). [theory eq. 9a, 9b, 26c]
#include <numbers>

#include <stark/base/rotation.h>
#include <stark/mechanics/free_rotation.h>
#include <stark/sim/model/script_phase.h>
#include <stark/sim/step/step_motion.h>

namespace stark {

namespace {

/// Angle by which the angular velocity at the end of a step may be ahead of the turn in it [rad]: as far as a
/// free body turns in a step.
constexpr double kLargestDifference = std::numbers::pi / 2.0;

/// Angular impulse of a step over the angular momentum below which nothing holds the body.
constexpr double kHeld = 1e-3;

/// Torque that holds R against inertia, whose energy is least at R_free: the gradient of (9) with respect to
/// a rotation, the sum of m_k (R_free e_k) x (R e_k) / (sigma s) [N m].
Vec3 inertial_torque(const Mat3& R, const Mat3& R_free, const Vec3& second_moments,
                     const TimeStencil& stencil) {
  Vec3 sum;
  for (int k = 0; k < 3; ++k) sum += cross(R_free.column(k), R.column(k)) * second_moments[k];
  return sum / (stencil.duration * stencil.scale);
}

}  // namespace

void StepMotion::set_free_rotations(double h) {
  const State& s = state_;
  MotionReference& r = reference_;
  r.free_rotation = s.body_rotation;
  r.angular_momentum.assign(s.body_rotation.size(), Vec3{});
  r.body_rotation_rate.resize(s.body_rotation.size());
  const TimeStencil& stencil = r.stencil;
  const bool has_history = stencil.history != 0.0;
  const std::vector<int32_t>& blocks = model_.map().layout().rotation_block;
  for (size_t b = 0; b < blocks.size(); ++b) {
    const Mat3 rate = skew(s.body_angular_velocity[b]) * s.body_rotation[b];
    r.body_rotation_rate[b] = rate;
    if (has_history)
      r.body_rotation_rate[b] +=
          (rate - skew(s.previous_body_angular_velocity[b]) * s.previous_body_rotation[b]) * stencil.history;
    if (blocks[b] == kNoBlock) continue;
    const Vec3& J = model_.rigid_masses()[b].moments;
    const Mat3& R = s.body_rotation[b];
    const Vec3 L = spin(b);
    r.angular_momentum[b] = L;
    if (has_history) {
      r.angular_momentum[b] = stencil.velocity(L, s.body_spin_increment[b], s.body_spin_contact_increment[b]);
      // The momentum with which free motion leads over the whole step to where (26) leads positions.
      r.free_rotation[b] = free_rotation(
          R, J, L + ((r.angular_momentum[b] - L) * stencil.duration - s.body_spin_lag[b] * stencil.lag) / h,
          h);
    } else {
      r.free_rotation[b] = free_rotation(R, J, L, h);
    }
  }
}

std::vector<Vec3> StepMotion::torques() {
  const DofLayout& layout = model_.map().layout();
  const Configuration& end = potential_.configuration();
  std::vector<Vec3> result(layout.rotation_block.size());
  const auto is_free = [&](size_t b) { return layout.rotation_block[b] != kNoBlock; };
  bool has_rigid = false;
  for (size_t b = 0; b < result.size(); ++b) {
    if (!is_free(b)) continue;
    const RigidMass& mass = model_.rigid_masses()[b];
    result[b] = inertial_torque(end.body_rotation[b], reference_.free_rotation[b], mass.second_moments,
                                reference_.stencil);
    has_rigid = has_rigid || !mass.is_frame;
  }
  // Frames take what their inertia balances. Rigid bodies take the torques themselves: the residual that
  // Newton's method leaves is then an error of their place, not of their angular momentum.
  if (!has_rigid || !has_inertia(settings_.time.integrator)) return result;
  scratch_gradient_.assign(3 * static_cast<size_t>(model_.map().layout().block_count), 0.0);
  potential_.evaluate_gradient(scratch_gradient_);
  for (size_t b = 0; b < result.size(); ++b) {
    if (!is_free(b) || model_.rigid_masses()[b].is_frame) continue;
    const double* left = scratch_gradient_.data() + 3 * layout.rotation_block[b];
    const Vec3 residual{left[0], left[1], left[2]};
    // Beyond the tolerance it is no residual of motion but friction that was refreshed since, or rounding of
    // forces that hold a small body: the rotation knows better.
    const RigidMass& mass = model_.rigid_masses()[b];
    if (norm(residual) * mass.reach <= settings_.newton.acceleration_tolerance * mass.resistance)
      result[b] -= residual;
  }
  return result;
}

void StepMotion::commit_rotation(int32_t b, const Vec3& torque, double h) {
  const Mat3 end = potential_.configuration().body_rotation[b];
  const bool is_free = model_.map().layout().rotation_block[b] != kNoBlock;
  const bool keeps_velocity = !is_free && script_phase(state_.script_remaining[b]) == ScriptPhase::Velocity;
  if (is_free && has_inertia(settings_.time.integrator)) {
    const Vec3& J = model_.rigid_masses()[b].moments;
    const Vec3 turning = log_rotation(end * transpose(state_.body_rotation[b])) / h;
    state_.body_rotation[b] = orthonormalized(end);
    const Vec3 L = reference_.angular_momentum[b] + torque * reference_.stencil.scale;
    const Vec3 w = velocity_of_momentum(state_.body_rotation[b], J, L);
    // A needle that is held far from its free motion has momentum along an axis of next to no inertia: then
    // the turn itself tells, if it has less energy. One that nothing holds may turn as fast as it likes.
    const bool is_free_motion = norm(torque) * reference_.stencil.scale <= kHeld * norm(L);
    const bool is_possible = norm(w - turning) * h <= kLargestDifference;
    const bool is_less = dot(turning, angular_momentum(state_.body_rotation[b], J, turning)) < dot(w, L);
    state_.body_angular_velocity[b] = is_free_motion || is_possible || !is_less ? w : turning;
    return;
  }
  // In equilibrium what is free is at rest; of what follows poses, or rests at the last one, the velocity
  // tells what it did.
  if (is_free)
    state_.body_angular_velocity[b] = {};
  else if (!keeps_velocity)
    state_.body_angular_velocity[b] = log_rotation(end * transpose(state_.body_rotation[b])) / h;
  state_.body_rotation[b] = is_free ? orthonormalized(end) : end;
}

Vec3 StepMotion::spin(size_t b) const {
  return angular_momentum(state_.body_rotation[b], model_.rigid_masses()[b].moments,
                          state_.body_angular_velocity[b]);
}

Vec3 StepMotion::turning_velocity(int32_t b, const Vec3& local) const {
  return cross(state_.body_angular_velocity[b], state_.body_rotation[b] * local);
}

}  // namespace stark
