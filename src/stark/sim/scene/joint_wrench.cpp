// See joint_wrench.h.
#include <stark/sim/scene/joint_wrench.h>

#include <algorithm>

namespace stark {

namespace {

/// Origin of frame b of a joint at x. Its points are those from `first` on: of a frame of axes the origin and
/// directions, of a patch three vertices.
Vec3 origin_of_b(const ConstraintGroup& group, int64_t element, int first, bool is_patch,
                 std::span<const Vec3> x) {
  const std::span<const int32_t> sites = group.batch.stencil(element);
  std::vector<Vec3> p;
  for (int k = 0; k < group.batch.point_count(); ++k)
    if (group.joint->points()[k] >= first) p.push_back(x[sites[k]]);
  const auto number = [&](int i) {
    return group.batch.get(group.batch.field_index("placement_b"), element, i);
  };
  if (!is_patch && group.joint->kind_b() == FrameKind::Placed && p.size() == 4)
    return p[0] + p[1] * number(0) + p[2] * number(1) + p[3] * number(2);
  if (!is_patch) return p.empty() ? Vec3{} : p.front();
  if (p.size() < 3) return {};
  return frame_on_patch(group, element, "placement_b", {p[0], p[1], p[2]}).origin;
}

}  // namespace

JointFrame frame_on_patch(const ConstraintGroup& group, int64_t element, const std::string& placement,
                          const std::array<Vec3, 3>& p) {
  const int field = group.batch.field_index(placement);
  const auto number = [&](int i) { return group.batch.get(field, element, i); };
  const Vec3 tangent = normalized(p[1] - p[0]), normal = normalized(cross(p[1] - p[0], p[2] - p[0]));
  Mat3 local;
  for (int i = 0; i < 9; ++i) local.m[i] = number(4 + i);
  return {.origin = p[0] * number(0) + p[1] * number(1) + p[2] * number(2) + normal * number(3),
          .axes = Mat3::from_columns(tangent, cross(normal, tangent), normal) * local};
}

Wrench joint_wrench(const JointDescription& description, const ConstraintSet& constraints, int32_t joint,
                    std::span<const Vec3> x) {
  const ConstraintSet::Place& place = constraints.place(joint);
  const ConstraintGroup& group = constraints.groups()[place.group];
  const int points = group.batch.point_count(), outputs = 1 + 3 * points;
  const int64_t block = place.element / symbolic::kLanes, lane = place.element % symbolic::kLanes;
  AlignedVector<double> values(static_cast<size_t>(outputs) * symbolic::kLanes);
  group.batch.evaluate(symbolic::Order::Gradient, x, block, block + 1, values.data());
  const auto slope = [&](int unknown) { return values[(1 + unknown) * symbolic::kLanes + lane]; };
  const bool b_is_patch = description.b.carrier == FrameDescription::Carrier::Patch;
  const int first_b = frame_point_count(
      description.a.carrier == FrameDescription::Carrier::Patch ? FrameKind::Patch : FrameKind::Axes);
  const std::span<const int32_t> sites = group.batch.stencil(place.element);
  const Vec3 origin = origin_of_b(group, place.element, first_b, b_is_patch, x);
  Wrench wrench;
  for (int k = 0; k < points; ++k) {
    if (group.joint->points()[k] < first_b) continue;
    const Vec3 force{-slope(3 * k), -slope(3 * k + 1), -slope(3 * k + 2)};
    if (b_is_patch || group.joint->points()[k] == first_b) {
      wrench.force += force;
      wrench.torque += cross(x[sites[k]] - origin, force);
    } else {
      wrench.torque += cross(x[sites[k]], force);  // a direction
    }
  }
  return wrench;
}

void let_go(State& state, int64_t first_residual, size_t count) {
  for (std::vector<double>* forces : {&state.joint_multiplier, &state.joint_force, &state.joint_carried})
    if (!forces->empty()) std::fill_n(forces->begin() + first_residual, count, 0.0);
}

}  // namespace stark
