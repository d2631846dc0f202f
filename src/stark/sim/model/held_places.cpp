#include <stark/sim/model/held_places.h>

#include <algorithm>
#include <array>

#include <stark/sim/model/model_builder.h>
#include <stark/sim/scene/joint_wrench.h>

namespace stark {

namespace {

using Carrier = FrameDescription::Carrier;

bool holds_axes(const JointDescription& joint) { return joint.definition->name == "fixed"; }

/// What the formula of an element knows of the four points of a frame, from `first` on; axes that it does not
/// ask for are those of the world.
JointFrame frame_of_points(const ConstraintGroup& group, int64_t element, int first,
                           std::span<const Vec3> x) {
  std::array<Vec3, 4> p{};
  std::array<bool, 4> is_known{};
  const std::span<const int32_t> sites = group.batch.stencil(element);
  for (size_t k = 0; k < group.joint->points().size(); ++k) {
    const int point = group.joint->points()[k] - first;
    if (point < 0 || point >= 4) continue;
    p[point] = x[sites[k]];
    is_known[point] = true;
  }
  JointFrame frame{.origin = p[0], .axes = Mat3::identity()};
  if (is_known[1] && is_known[3]) frame.axes = Mat3::from_columns(p[1], cross(p[3], p[1]), p[3]);
  return frame;
}

}  // namespace

bool can_hold_here(const JointDescription& joint) {
  const std::string& kind = joint.definition->name;
  return !joint.enabled && (kind == "fixed" || kind == "ball") && joint.b.carrier != Carrier::Patch;
}

bool can_hold_here(const AttachmentDescription& attachment, const PointSet& points) {
  const bool is_rigid = points.kind == PointKind::BodyPoints || points.kind == PointKind::WorldPoints;
  return !attachment.enabled && is_rigid;
}

std::vector<double> find_place(const ConstraintSet& constraints, const HeldPlace& place,
                               std::span<const Vec3> x) {
  const auto& [index, element, residual, coordinate] = constraints.place(place.constraint);
  const ConstraintGroup& group = constraints.groups()[index];
  const std::span<const int32_t> sites = group.batch.stencil(element);
  const JointFrame a =
      group.joint->kind_a() == FrameKind::Patch
          ? frame_on_patch(group, element, "placement_a", {x[sites[0]], x[sites[1]], x[sites[2]]})
          : frame_of_points(group, element, 0, x);
  const JointFrame b = frame_of_points(group, element, frame_point_count(group.joint->kind_a()), x);
  const Vec3 position = transpose(b.axes) * (a.origin - b.origin);
  std::vector<double> numbers{position.x, position.y, position.z};
  if (!place.has_axes) return numbers;
  const Mat3 rotation = transpose(b.axes) * a.axes;
  numbers.insert(numbers.end(), rotation.m.begin(), rotation.m.end());
  return numbers;
}

void set_place(PotentialBatch& batch, int64_t element, std::span<const double> numbers) {
  std::array<double, kPlaceNumbers> all{0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0};
  std::ranges::copy(numbers, all.begin());
  batch.set(batch.field_index("placement_b"), element, all);
}

void set_places(ConstraintSet& constraints, std::span<const HeldPlace> places,
                std::span<const double> numbers) {
  for (const HeldPlace& place : places) {
    const ConstraintSet::Place& at = constraints.place(place.constraint);
    set_place(constraints.groups()[at.group].batch, at.element,
              numbers.subspan(place.first, width_of(place)));
  }
}

void Model::Builder::list_held_places() {
  const auto add = [&](int32_t constraint, bool has_axes) {
    const HeldPlace place{.constraint = constraint,
                          .first = static_cast<int64_t>(model.initial_places_.size()),
                          .has_axes = has_axes};
    const ConstraintSet::Place& at = energies.constraints.place(constraint);
    const PotentialBatch& batch = energies.constraints.groups()[at.group].batch;
    for (int k = 0; k < width_of(place); ++k)
      model.initial_places_.push_back(batch.get(batch.field_index("placement_b"), at.element, k));
    model.held_places_.push_back(place);
  };
  for (int32_t j = 0; j < static_cast<int32_t>(scene.joints().size()); ++j)
    if (can_hold_here(scene.joints()[j])) add(j, holds_axes(scene.joints()[j]));
  for (int32_t pair = 0; pair < static_cast<int32_t>(attachment_frames.size()); ++pair)
    if (!attachment_frames[pair].empty()) add(model.attachments_.front().first_constraint + pair, false);
}

}  // namespace stark
