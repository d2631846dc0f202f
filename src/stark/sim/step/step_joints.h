// Joints, actuators and attachments in a step: what they start from, what they are when it ends, what breaks
// (step phases 1 and 6).
#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include <stark/sim/step/step_motion.h>

namespace stark {

/// Values of attachment_held and joint_enabled of the state.
inline constexpr double kReleased = 0.0, kHeld = 1.0, kBroken = -1.0;

/// By which constraints may be off [m, rad].
ConstraintTolerance joint_tolerance(const JointSettings& settings);

/// "0.1 m", "0.1 rad".
const char* unit_of(ResidualUnit unit);
std::string residual_text(double residual, ResidualUnit unit);

/// Power [W] that an actuator fed into the motion in the last step.
double actuator_power(const ModelActuator& actuator, const State& state);
/// Work [J] of its efforts on the way of its coordinates since they were `before`. [theory eq. 27]
double actuator_work(const ModelActuator& actuator, const State& state, std::span<const double> before);

class StepJoints : private StepPart {
 public:
  StepJoints(const StepContext& context, const StepMotion& motion) : StepPart(context), motion_(motion) {}

  /// Multipliers and penalties of a step; `diagonal`: blocks of inertia and elasticity without joints.
  void begin(std::span<const Mat3> diagonal, double h);
  /// Takes the stiffness of joints out of the energies.
  void release();
  /// Writes the inputs of actuators for a step of length h from what motion is measured from.
  void begin_actuators(double h);
  /// Whether what moves arrives at a stop in a step of length h with a history. Call it after
  /// begin_actuators(h). [theory eq. 26]
  bool hits_stop(double h) const;
  /// Multipliers, coordinates, rates, efforts and memories at the end of a step; breaks joints and
  /// attachments. Returns which loop is about to jam, or nothing.
  std::string commit();
  /// Which joints of a closed loop are off by nearly their tolerances, as no motion closes it, with a remedy;
  /// empty if none are.
  std::string misfit_text() const;
  /// Where a joint or an attachment begins or ends to hold: the next step starts anew.
  void forget_history();
  void set_attachment_status(const ModelAttachment& attachment, int64_t pair, double status);
  /// Which constraint is worst, with a remedy; empty if none is off.
  std::string violation_text() const;
  /// The same between steps with sites at x, of `some` constraints: what is beyond their tolerances, without
  /// a remedy.
  std::string violation_text(std::span<const Vec3> x, const std::function<bool(int32_t)>& some) const;

 private:
  /// How firmly a side resists, by the diagonal of the Hessian at the start of the step.
  SideStiffness stiffness_of(const JointSide& side, std::span<const Mat3> diagonal) const;
  /// Gives bodies that joints alone hold the stiffness of what they are joined to: without inertia they have
  /// none of their own.
  void share_stiffness(std::vector<SideStiffness>& sides) const;
  /// 1 for each joint, then for each actuator, then for each pair of attachments, that acts; actuators of
  /// released joints rest.
  std::vector<double> acting() const;
  /// Joints, actuators and attachments are numbered one after the other.
  bool is_of_actuators(const ConstraintGroup& group) const;
  std::string misfit_text(std::span<const double> misfits) const;
  /// "joint 'knee'", "attachment 'seam', pair 3".
  std::string name_of(int32_t constraint) const;
  /// "joint 'knee' is apart by 0.1 m".
  std::string text_of(const ConstraintSet::Violation& worst) const;
  bool is_of_attachments(int32_t constraint) const;
  /// Keeps what constraints have pulled with, given what they pull with at the end of a step [N, N m].
  void take_forces(std::vector<double> forces);
  /// Takes efforts and memories over at the end of a step.
  void commit_actuators(std::span<const Vec3> x);
  /// Breaks joints whose force or torque is above what they stand, with sites at x at the end of a step.
  void commit_joints(std::span<const Vec3> x);
  /// Breaks pairs whose force is above what they stand, with sites at x at the end of a step.
  void commit_attachments();

  const StepMotion& motion_;
};

}  // namespace stark
