// Simulation: joints. Stiffness of their sides, coordinates, reactions, enabling.
#include <algorithm>
#include <cmath>
#include <numbers>

#include <stark/base/error.h>
#include <stark/sim/simulation.h>

namespace stark {

namespace {

std::string owner_text(const JointDescription& joint) { return "joint '" + joint.name + "'"; }

std::string residual_text(double residual, ResidualUnit unit) {
  return quantity_text(residual, unit == ResidualUnit::Length ? "m" : "rad");
}

/// Origin of frame b of a joint at x. Its points are those from `first` on: of a frame of axes the origin and
/// directions, of a patch three vertices.
Vec3 origin_of_b(const ConstraintGroup& group, int64_t element, int first, bool is_patch,
                 std::span<const Vec3> x) {
  const std::span<const int32_t> sites = group.batch.stencil(element);
  std::vector<Vec3> p;
  for (int k = 0; k < group.batch.point_count(); ++k)
    if (group.joint->points()[k] >= first) p.push_back(x[sites[k]]);
  if (!is_patch) return p.empty() ? Vec3{} : p.front();
  if (p.size() < 3) return {};
  const int field = group.batch.field_index("placement_b");
  const auto number = [&](int i) { return group.batch.get(field, element, i); };
  const Vec3 normal = normalized(cross(p[1] - p[0], p[2] - p[0]));
  return p[0] * number(0) + p[1] * number(1) + p[2] * number(2) + normal * number(3);
}

double mean_diagonal(const Mat3& H) { return trace(H) / 3.0; }

/// The value next to `previous` among those that differ from `raw` by full turns.
double unwrap(double raw, double previous) {
  constexpr double kTurn = 2.0 * std::numbers::pi;
  return raw + kTurn * std::round((previous - raw) / kTurn);
}

}  // namespace

ConstraintTolerance Simulation::joint_tolerance() const {
  return {settings_.joints.length_tolerance, settings_.joints.angle_tolerance};
}

void Simulation::begin_joints(std::span<const Mat3> diagonal) {
  const double inverse_h2 = 1.0 / (settings_.time.step * settings_.time.step);
  std::vector<SideStiffness> sides;
  for (const JointSide& side : model_->joint_sides()) {
    SideStiffness stiffness{.is_prescribed = side.blocks.empty()};
    double translation = 0.0;
    for (const int32_t block : side.blocks) translation += mean_diagonal(diagonal[block]);
    stiffness.translation = std::max(translation, side.mass * inverse_h2);
    const double rotation = side.rotation_block != kNoBlock ? mean_diagonal(diagonal[side.rotation_block])
                                                            : translation * side.reach * side.reach / 3.0;
    stiffness.rotation = std::max(rotation, side.moment * inverse_h2);
    sides.push_back(stiffness);
  }
  model_->constraints().begin_step(state_.joint_multiplier, sides, acting(), joint_tolerance());
}

void Simulation::release_joints() {
  const std::vector<double> none(model_->constraints().residual_count(), 0.0);
  const std::vector<double> disabled(model_->constraints().joint_count(), 0.0);
  const std::vector<SideStiffness> soft(model_->joint_sides().size());
  model_->constraints().begin_step(none, soft, disabled, joint_tolerance());
}

void Simulation::check_joints() {
  if (scene_.joints().empty()) return;
  const std::vector<Vec3> x = site_positions();
  for (ConstraintGroup& group : model_->constraints().groups()) group.batch.set_previous(x);
  const std::vector<double> C = model_->constraints().residuals(x);
  std::vector<std::vector<double>> derivatives;
  for (const ConstraintGroup& group : model_->constraints().groups())
    derivatives.push_back(group.batch.evaluate(symbolic::Order::Hessian, x));
  for (int32_t j = 0; j < static_cast<int32_t>(scene_.joints().size()); ++j) {
    if (!scene_.joints()[j].enabled) continue;
    const ConstraintSet::Place& place = model_->constraints().place(j);
    const ConstraintGroup& group = model_->constraints().groups()[place.group];
    const Joint& joint = *group.joint;
    const size_t outputs = derivatives[place.group].size() / static_cast<size_t>(group.batch.size());
    const auto first =
        derivatives[place.group].begin() + static_cast<std::ptrdiff_t>(place.element * outputs);
    if (!std::all_of(first, first + static_cast<std::ptrdiff_t>(outputs),
                     [](double v) { return std::isfinite(v); }))
      throw InvalidArgument(
          owner_text(scene_.joints()[j]) +
          ": its residuals or their derivatives are not finite at time 0: must be; look for the norm "
          "of a zero vector, a division by zero, or the root or logarithm of a negative number there");
    int64_t r = place.residual;
    for (const int rows : joint.hold_sizes()) {
      const ResidualUnit unit = joint.units()[r - place.residual];
      double squared = 0.0;
      for (int k = 0; k < rows; ++k, ++r) {
        const bool one_sided = joint.one_sided()[r - place.residual] != 0;
        const double off = one_sided ? std::max(0.0, C[r]) : C[r];
        squared += off * off;
      }
      const double tolerance =
          unit == ResidualUnit::Length ? joint_tolerance().length : joint_tolerance().angle;
      if (!(std::sqrt(squared) <= tolerance))
        throw InvalidArgument(
            owner_text(scene_.joints()[j]) + ": its frames differ by " +
            residual_text(std::sqrt(squared), unit) + " at time 0: must be within " +
            residual_text(tolerance, unit) +
            "; place both frames at the same point of the world, or add the joint with enabled = "
            "false");
    }
  }
}

void Simulation::commit_joints() {
  const ConstraintSet& constraints = model_->constraints();
  if (constraints.joint_count() == 0) return;
  const std::span<const Vec3> x = potential_->site_positions();
  state_.joint_multiplier = constraints.forces(x);
  commit_attachments(x);
  commit_actuators(x);
  const std::vector<double> raw = constraints.coordinates(x), start = reference_coordinates();
  for (int32_t j = 0; j < constraints.joint_count(); ++j) {
    const ConstraintSet::Place& place = constraints.place(j);
    const auto& coordinates = constraints.groups()[place.group].joint->coordinates();
    for (size_t k = 0; k < coordinates.size(); ++k) {
      double& value = state_.joint_coordinate[place.coordinate + k];
      const double now = raw[place.coordinate + k], change = now - start[place.coordinate + k];
      const bool is_angle = coordinates[k].unit == "rad";
      state_.joint_rate[place.coordinate + k] =
          (is_angle ? shortest_turn(change) : change) / reference_.stencil.duration;
      value = is_angle ? unwrap(now, value) : now;
    }
  }
}

std::string Simulation::violation_text() const {
  const ConstraintSet::Violation worst = model_->constraints().worst(potential_->site_positions());
  if (worst.joint < 0) return "";
  const auto joints = static_cast<int32_t>(scene_.joints().size());
  if (!model_->attachments().empty() && worst.joint >= model_->attachments().front().first_constraint) {
    const auto after =
        std::ranges::upper_bound(model_->attachments(), worst.joint, {}, &ModelAttachment::first_constraint);
    const auto k = static_cast<size_t>(after - model_->attachments().begin()) - 1;
    return "attachment '" + scene_.attachments()[k].name + "', pair " +
           std::to_string(worst.joint - model_->attachments()[k].first_constraint) + ", is apart by " +
           residual_text(worst.residual, worst.unit) +
           "; look for prescribed bodies that pull it apart, or give it a break_force";
  }
  if (worst.joint >= joints)
    return "actuator '" + scene_.actuators()[worst.joint - joints].name + "' is off by " +
           residual_text(worst.residual, worst.unit) +
           "; look for joints, limits and prescribed bodies that contradict it";
  return owner_text(scene_.joints()[worst.joint]) + " is apart by " +
         residual_text(worst.residual, worst.unit) +
         "; look for joints that contradict each other, for prescribed bodies that pull it apart, and for "
         "bodies in "
         "its way";
}

void Simulation::set_joint_enabled(JointId joint, bool enabled) {
  scene_.joint(joint);
  const ConstraintSet::Place& place = model_->constraints().place(joint.index);
  if ((state_.joint_enabled[joint.index] != 0.0) == enabled) return;
  state_.joint_enabled[joint.index] = enabled ? 1.0 : 0.0;
  const size_t count = model_->constraints().groups()[place.group].joint->units().size();
  std::fill_n(state_.joint_multiplier.begin() + place.residual, count, 0.0);
}

bool Simulation::joint_enabled(JointId joint) const {
  scene_.joint(joint);
  return state_.joint_enabled[joint.index] != 0.0;
}

std::vector<Joint::Coordinate> Simulation::joint_coordinate_names(JointId joint) const {
  scene_.joint(joint);
  return model_->constraints().groups()[model_->constraints().place(joint.index).group].joint->coordinates();
}

std::vector<double> Simulation::joint_coordinates(JointId joint) const {
  const size_t count = joint_coordinate_names(joint).size();
  const auto first = state_.joint_coordinate.begin() + model_->constraints().place(joint.index).coordinate;
  return {first, first + static_cast<std::ptrdiff_t>(count)};
}

std::vector<double> Simulation::joint_rates(JointId joint) const {
  const size_t count = joint_coordinate_names(joint).size();
  const auto first = state_.joint_rate.begin() + model_->constraints().place(joint.index).coordinate;
  return {first, first + static_cast<std::ptrdiff_t>(count)};
}

std::vector<double> Simulation::joint_residuals(JointId joint) const {
  scene_.joint(joint);
  const ConstraintSet& constraints = model_->constraints();
  const ConstraintSet::Place& place = constraints.place(joint.index);
  const size_t count = constraints.groups()[place.group].joint->units().size();
  const std::vector<double> all = constraints.residuals(site_positions());
  return {all.begin() + place.residual, all.begin() + place.residual + static_cast<std::ptrdiff_t>(count)};
}

Wrench Simulation::joint_reaction(JointId joint) const {
  const JointDescription& description = scene_.joint(joint);
  const ConstraintSet::Place& place = model_->constraints().place(joint.index);
  const ConstraintGroup& group = model_->constraints().groups()[place.group];
  const std::vector<Vec3> x = site_positions();
  const std::vector<double> values = group.batch.evaluate(symbolic::Order::Gradient, x);
  const int points = group.batch.point_count(), outputs = 1 + 3 * points;
  const bool b_is_patch = description.b.carrier == FrameDescription::Carrier::Patch;
  const int first_b = frame_point_count(
      description.a.carrier == FrameDescription::Carrier::Patch ? FrameKind::Patch : FrameKind::Axes);
  const std::span<const int32_t> sites = group.batch.stencil(place.element);
  const Vec3 origin = origin_of_b(group, place.element, first_b, b_is_patch, x);
  Wrench wrench;
  for (int k = 0; k < points; ++k) {
    if (group.joint->points()[k] < first_b) continue;
    const double* g = values.data() + place.element * outputs + 1 + 3 * k;
    const Vec3 force{-g[0], -g[1], -g[2]};
    if (b_is_patch || group.joint->points()[k] == first_b) {
      wrench.force += force;
      wrench.torque += cross(x[sites[k]] - origin, force);
    } else {
      wrench.torque += cross(x[sites[k]], force);  // a direction
    }
  }
  return wrench;
}

}  // namespace stark
