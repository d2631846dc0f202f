#include <stark/sim/step/step_joints.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>

#include <stark/base/rotation.h>
#include <stark/sim/scene/joint_wrench.h>

namespace stark {

namespace {

double mean_diagonal(const Mat3& H) { return trace(H) / 3.0; }

/// The value next to `previous` among those that differ from `raw` by full turns.
double unwrap(double raw, double previous) {
  constexpr double kTurn = 2.0 * std::numbers::pi;
  return raw + kTurn * std::round((previous - raw) / kTurn);
}

/// Residual over its tolerance between steps: rounding of what moves as one.
constexpr double kRounding = 1.001;

/// Stiffness over that of inertia from which on something elastic holds a body.
constexpr double kElastic = 1.0 + 1e-6;
/// Part of the stiffness of a deformable body that one joined to it takes: joints give way by a thousandth of
/// what a node does, and Newton's method is not held on straight ways.
constexpr double kShare = 0.1;
constexpr int kPasses = 100;  ///< of handing stiffness on from body to body

/// Accelerations to which reactions are to be right [m/s^2, rad/s^2], and residuals that are small enough for
/// any [m, rad].
constexpr double kLinear = 0.01, kAngular = 0.1;
constexpr double kSmallLength = 1e-10, kSmallAngle = 1e-9;

/// Joints that are named of a loop which does not fit.
constexpr size_t kNamed = 3;

/// Residuals that make the error of a reaction less than its mass times these accelerations, in a step of h.
ConstraintTolerance finer(const ConstraintTolerance& tolerance, double h) {
  return {.length = std::min(tolerance.length, std::max(kLinear * h * h, kSmallLength)),
          .angle = std::min(tolerance.angle, std::max(kAngular * h * h, kSmallAngle))};
}

Vec3 vector_at(std::span<const double> numbers, int64_t first) {
  return {numbers[first], numbers[first + 1], numbers[first + 2]};
}

}  // namespace

ConstraintTolerance joint_tolerance(const JointSettings& settings) {
  return {settings.length_tolerance, settings.angle_tolerance};
}

const char* unit_of(ResidualUnit unit) { return unit == ResidualUnit::Length ? "m" : "rad"; }

std::string residual_text(double residual, ResidualUnit unit) {
  return quantity_text(residual, unit_of(unit));
}

SideStiffness StepJoints::stiffness_of(const JointSide& side, std::span<const Mat3> diagonal) const {
  const double inverse_h2 = 1.0 / (settings_.time.step * settings_.time.step);
  const bool turns = side.rotation_block != kNoBlock;
  SideStiffness stiffness{.is_placed = side.blocks.empty(), .is_turned = side.blocks.empty() && !turns};
  double translation = 0.0;
  for (const int32_t block : side.blocks) translation += mean_diagonal(diagonal[block]);
  stiffness.translation = std::max(translation, side.mass * inverse_h2);
  const double rotation =
      turns ? mean_diagonal(diagonal[side.rotation_block]) : translation * side.reach * side.reach / 3.0;
  stiffness.rotation = std::max(rotation, side.moment * inverse_h2);
  if (stiffness.is_placed && turns && side.lever > settings_.joints.length_tolerance) {
    // A pinned node of a rod turns, and so moves what is at a lever.
    stiffness.is_placed = false;
    stiffness.translation = stiffness.rotation / (side.lever * side.lever);
  }
  return stiffness;
}

void StepJoints::begin(std::span<const Mat3> diagonal, double h) {
  std::vector<SideStiffness> sides;
  for (const JointSide& side : model_.joint_sides()) sides.push_back(stiffness_of(side, diagonal));
  const bool is_dynamic = has_inertia(settings_.time.integrator);
  if (!is_dynamic) share_stiffness(sides);
  const ConstraintTolerance tolerance = joint_tolerance(settings_.joints);
  energies_.constraints.begin_step(state_.joint_multiplier, sides, acting(), tolerance,
                                   is_dynamic ? finer(tolerance, h) : tolerance);
}

void StepJoints::share_stiffness(std::vector<SideStiffness>& sides) const {
  constexpr double SideStiffness::* kParts[] = {&SideStiffness::translation, &SideStiffness::rotation};
  const std::span<const JointSide> places = model_.joint_sides();
  const double inverse_h2 = 1.0 / (settings_.time.step * settings_.time.step);
  const std::vector<double> acts = acting();
  const auto is_held_otherwise = [&](size_t s) {
    return places[s].blocks.size() != 1 || places[s].rotation_block == kNoBlock ||
           sides[s].translation > kElastic * places[s].mass * inverse_h2;
  };
  std::vector<size_t> alone;  // sides that nothing but joints holds
  std::vector<double> share(sides.size(), kShare);
  for (size_t s = 0; s < sides.size(); ++s)
    if (!is_held_otherwise(s)) {
      share[s] = 1.0;
      if (acts[s / 2] != 0.0) alone.push_back(s);
    }
  std::map<int32_t, SideStiffness> bodies;  // by their first block
  bool has_changed = !alone.empty();
  for (int pass = 0; has_changed && pass < kPasses; ++pass) {
    has_changed = false;
    for (const size_t s : alone) {
      SideStiffness& body = bodies[places[s].blocks.front()];
      for (double SideStiffness::* part : kParts) {
        const double most = std::max({body.*part, sides[s].*part, share[s ^ 1] * sides[s ^ 1].*part});
        has_changed = has_changed || most > body.*part || most > sides[s].*part;
        body.*part = sides[s].*part = most;
      }
    }
  }
}

void StepJoints::release() {
  const std::vector<double> none(energies_.constraints.residual_count(), 0.0);
  const std::vector<double> disabled(energies_.constraints.joint_count(), 0.0);
  const std::vector<SideStiffness> soft(model_.joint_sides().size());
  energies_.constraints.begin_step(none, soft, disabled, joint_tolerance(settings_.joints));
}

std::vector<double> StepJoints::acting() const {
  std::vector<double> acting;
  for (const double enabled : state_.joint_enabled) acting.push_back(enabled == kHeld ? 1.0 : 0.0);
  for (size_t k = 0; k < scene_.actuators().size(); ++k) {
    bool on = state_.actuator_enabled[k] != 0.0;
    for (const CoordinateName& coordinate : scene_.actuators()[k].on)
      on = on && state_.joint_enabled[coordinate.joint.index] == kHeld;
    acting.push_back(on ? 1.0 : 0.0);
  }
  for (const double held : state_.attachment_held) acting.push_back(held == 1.0 ? 1.0 : 0.0);
  return acting;
}

void StepJoints::forget_history() {
  // What held pulls for half a step longer with bdf2, as its velocities remember: a ball that is let go from
  // a circle would fly off at a wrong angle, and faster.
  if (has_history(settings_.time.integrator)) state_.previous_time_step = 0.0;
}

std::string StepJoints::commit() {
  ConstraintSet& constraints = energies_.constraints;
  if (constraints.joint_count() == 0) return "";
  const std::span<const Vec3> x = potential_.site_positions();
  SelfStress::End end = potential_.end_constraints();
  std::string misfit = misfit_text(end.misfits);
  state_.joint_multiplier = std::move(end.multipliers);
  take_forces(std::move(end.forces));
  constraints.set_forces(state_.joint_force);  // what loops do to themselves is not read, and breaks nothing
  commit_joints(x);
  commit_attachments();
  commit_actuators(x);
  const std::vector<double> raw = constraints.coordinates(x), start = motion_.coordinates();
  const bool has_rates = has_inertia(settings_.time.integrator);
  for (int32_t j = 0; j < constraints.joint_count(); ++j) {
    const ConstraintSet::Place& place = constraints.place(j);
    const auto& coordinates = constraints.groups()[place.group].joint->coordinates();
    for (size_t k = 0; k < coordinates.size(); ++k) {
      double& value = state_.joint_coordinate[place.coordinate + k];
      const double now = raw[place.coordinate + k], change = now - start[place.coordinate + k];
      const bool is_angle = coordinates[k].unit == "rad";
      const double way = is_angle ? shortest_turn(change) : change;
      state_.joint_rate[place.coordinate + k] = has_rates ? way / motion_.reference().stencil.duration : 0.0;
      value = is_angle ? unwrap(now, value) : now;
    }
  }
  return misfit;
}

// A constraint force pushes with s; where that is less than the step although the velocity at its end is the
// mean one, before an impact, the rest is what v_bar has of the last step. Read is what has pushed in the
// mean. [theory eq. 26g]
void StepJoints::take_forces(std::vector<double> forces) {
  const TimeStencil& stencil = motion_.reference().stencil;
  if (stencil.history != 0.0 && stencil.scale != stencil.duration) {
    const double part = stencil.scale / stencil.duration;
    for (size_t r = 0; r < forces.size(); ++r)
      forces[r] = part * forces[r] + (1.0 - part) * state_.joint_carried[r];
  }
  state_.joint_force = std::move(forces);
  if (!has_history(settings_.time.integrator)) return;
  state_.joint_carried = state_.joint_force;
  // An impact has no history.
  if (motion_.reference().has_impact) std::ranges::fill(state_.joint_carried, 0.0);
}

std::string StepJoints::misfit_text() const { return misfit_text(potential_.end_constraints().misfits); }

std::string StepJoints::misfit_text(std::span<const double> misfits) const {
  if (misfits.empty()) return "";
  const std::vector<ConstraintSet::Violation> off = energies_.constraints.nearly_beyond(misfits);
  if (off.empty()) return "";
  std::string names;
  for (size_t k = 0; k < std::min(kNamed, off.size()); ++k)
    names += (k > 0 ? ", " : "") + name_of(off[k].joint);
  const ConstraintSet::Violation& worst = off.front();
  const bool is_length = worst.unit == ResidualUnit::Length;
  const std::string setting = is_length ? "joints.length_tolerance" : "joints.angle_tolerance";
  const double tolerance = is_length ? settings_.joints.length_tolerance : settings_.joints.angle_tolerance;
  return "a closed loop does not fit: " + names + (off.size() > kNamed ? ", ..." : "") + ", off by " +
         rough_text(worst.residual, unit_of(worst.unit)) + " which no motion closes, of " + setting + " = " +
         quantity_text(tolerance, unit_of(worst.unit)) +
         ", beyond which it jams; make places and axes of its joints fit, let one of them hold less, or "
         "loosen that tolerance";
}

void StepJoints::commit_joints(std::span<const Vec3> x) {
  for (int32_t j = 0; j < static_cast<int32_t>(scene_.joints().size()); ++j) {
    const JointDescription& joint = scene_.joints()[j];
    if (!joint.can_break() || state_.joint_enabled[j] != kHeld) continue;
    const Wrench wrench = joint_wrench(joint, energies_.constraints, j, x);
    if (norm(wrench.force) <= joint.break_force && norm(wrench.torque) <= joint.break_torque) continue;
    state_.joint_enabled[j] = kBroken;
    forget_history();
    const ConstraintSet::Place& place = energies_.constraints.place(j);
    const size_t count = energies_.constraints.groups()[place.group].joint->units().size();
    let_go(state_, place.residual, count);
  }
}

void StepJoints::commit_attachments() {
  const auto breakable = [](const AttachmentDescription& a) {
    return a.break_force < std::numeric_limits<double>::infinity();
  };
  if (std::ranges::none_of(scene_.attachments(), breakable)) return;
  const std::vector<double> reactions = state_.joint_force;
  for (size_t k = 0; k < scene_.attachments().size(); ++k) {
    const AttachmentDescription& attachment = scene_.attachments()[k];
    const ModelAttachment& place = model_.attachments()[k];
    for (int32_t pair = 0; pair < attachment.size(); ++pair) {
      if (state_.attachment_held[place.first_pair + pair] != kHeld) continue;
      const int64_t r = energies_.constraints.place(place.first_constraint + pair).residual;
      if (norm(vector_at(reactions, r)) > attachment.break_force) set_attachment_status(place, pair, kBroken);
    }
  }
}

void StepJoints::set_attachment_status(const ModelAttachment& attachment, int64_t pair, double status) {
  double& held = state_.attachment_held[attachment.first_pair + pair];
  if (held == status || held == kBroken) return;
  held = status;
  forget_history();
  const int64_t r =
      energies_.constraints.place(attachment.first_constraint + static_cast<int32_t>(pair)).residual;
  let_go(state_, r, 3);
}

std::string StepJoints::name_of(int32_t constraint) const {
  const auto joints = static_cast<int32_t>(scene_.joints().size());
  if (is_of_attachments(constraint)) {
    const auto after =
        std::ranges::upper_bound(model_.attachments(), constraint, {}, &ModelAttachment::first_constraint);
    const auto k = static_cast<size_t>(after - model_.attachments().begin()) - 1;
    return "attachment '" + scene_.attachments()[k].name + "', pair " +
           std::to_string(constraint - model_.attachments()[k].first_constraint);
  }
  if (constraint >= joints) return "actuator '" + scene_.actuators()[constraint - joints].name + "'";
  return "joint '" + scene_.joints()[constraint].name + "'";
}

std::string StepJoints::text_of(const ConstraintSet::Violation& worst) const {
  const bool is_of_joint = worst.joint < static_cast<int32_t>(scene_.joints().size());
  const char* verb = is_of_attachments(worst.joint) ? ", is apart by "
                     : is_of_joint                  ? " is apart by "
                                                    : " is off by ";
  return name_of(worst.joint) + verb + rough_text(worst.residual, unit_of(worst.unit));
}

bool StepJoints::is_of_attachments(int32_t constraint) const {
  return !model_.attachments().empty() && constraint >= model_.attachments().front().first_constraint;
}

std::string StepJoints::violation_text(std::span<const Vec3> x,
                                       const std::function<bool(int32_t)>& some) const {
  std::vector<double> enabled = acting();
  for (size_t j = 0; j < enabled.size(); ++j)
    if (!some(static_cast<int32_t>(j))) enabled[j] = 0.0;
  const ConstraintSet::Violation worst =
      energies_.constraints.worst(x, enabled, joint_tolerance(settings_.joints));
  return worst.ratio > kRounding ? text_of(worst) : "";
}

std::string StepJoints::violation_text() const {
  const ConstraintSet::Violation worst = energies_.constraints.worst(potential_.site_positions());
  if (worst.joint < 0) return "";
  const char* remedy =
      "look for joints that contradict each other, for prescribed bodies that pull it apart, and for bodies "
      "in its way";
  if (is_of_attachments(worst.joint))
    remedy = "look for prescribed bodies that pull it apart, or give it a break_force";
  else if (worst.joint >= static_cast<int32_t>(scene_.joints().size()))
    remedy = "look for joints, limits and prescribed bodies that contradict it";
  return text_of(worst) + "; " + remedy;
}

}  // namespace stark
