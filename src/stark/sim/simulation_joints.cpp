// Simulation: joints. Stiffness of their sides, coordinates, reactions, enabling.
#include <algorithm>
#include <cmath>
#include <numbers>

#include <stark/base/error.h>
#include <stark/sim/simulation_parts.h>

namespace stark {

namespace {

std::string owner_text(const JointDescription& joint) { return "joint '" + joint.name + "'"; }

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

}  // namespace

void Simulation::check_joints() {
  if (scene_.joints().empty()) return;
  const std::vector<Vec3> x = site_positions();
  for (ConstraintGroup& group : energies_.constraints.groups()) group.batch.set_previous(x);
  const std::vector<double> C = energies_.constraints.residuals(x);
  std::vector<std::vector<double>> derivatives;
  for (const ConstraintGroup& group : energies_.constraints.groups())
    derivatives.push_back(group.batch.evaluate(symbolic::Order::Hessian, x));
  for (int32_t j = 0; j < static_cast<int32_t>(scene_.joints().size()); ++j) {
    if (!scene_.joints()[j].enabled) continue;
    const ConstraintSet::Place& place = energies_.constraints.place(j);
    const ConstraintGroup& group = energies_.constraints.groups()[place.group];
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
      const double tolerance = unit == ResidualUnit::Length ? joint_tolerance(settings_.joints).length
                                                            : joint_tolerance(settings_.joints).angle;
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

void Simulation::set_joint_enabled(JointId joint, bool enabled) {
  scene_.joint(joint);
  const ConstraintSet::Place& place = energies_.constraints.place(joint.index);
  if ((state_.joint_enabled[joint.index] != 0.0) == enabled) return;
  state_.joint_enabled[joint.index] = enabled ? 1.0 : 0.0;
  const size_t count = energies_.constraints.groups()[place.group].joint->units().size();
  std::fill_n(state_.joint_multiplier.begin() + place.residual, count, 0.0);
}

bool Simulation::joint_enabled(JointId joint) const {
  scene_.joint(joint);
  return state_.joint_enabled[joint.index] != 0.0;
}

std::vector<Joint::Coordinate> Simulation::joint_coordinate_names(JointId joint) const {
  scene_.joint(joint);
  return energies_.constraints.groups()[energies_.constraints.place(joint.index).group].joint->coordinates();
}

std::vector<double> Simulation::joint_coordinates(JointId joint) const {
  scene_.joint(joint);
  const ConstraintSet::Place& place = energies_.constraints.place(joint.index);
  const size_t count = energies_.constraints.groups()[place.group].joint->coordinates().size();
  const auto first = state_.joint_coordinate.begin() + place.coordinate;
  return {first, first + static_cast<std::ptrdiff_t>(count)};
}

std::vector<double> Simulation::joint_rates(JointId joint) const {
  scene_.joint(joint);
  const ConstraintSet::Place& place = energies_.constraints.place(joint.index);
  const size_t count = energies_.constraints.groups()[place.group].joint->coordinates().size();
  const auto first = state_.joint_rate.begin() + place.coordinate;
  return {first, first + static_cast<std::ptrdiff_t>(count)};
}

std::vector<double> Simulation::joint_residuals(JointId joint) const {
  scene_.joint(joint);
  const ConstraintSet& constraints = energies_.constraints;
  const ConstraintSet::Place& place = constraints.place(joint.index);
  const size_t count = constraints.groups()[place.group].joint->units().size();
  const std::vector<double> all = constraints.residuals(site_positions());
  return {all.begin() + place.residual, all.begin() + place.residual + static_cast<std::ptrdiff_t>(count)};
}

Wrench Simulation::joint_reaction(JointId joint) const {
  const JointDescription& description = scene_.joint(joint);
  const ConstraintSet::Place& place = energies_.constraints.place(joint.index);
  const ConstraintGroup& group = energies_.constraints.groups()[place.group];
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
