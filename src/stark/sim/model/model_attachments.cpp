// Attachments of a model: sites of their pairs, one group of the constraint set for pairs of points and one
// for points on patches.
#include <algorithm>

#include <stark/base/error.h>
#include <stark/sim/model/held_places.h>
#include <stark/sim/model/model_builder.h>

namespace stark {

void Model::Builder::add_attachment_sites() {
  for (const AttachmentDescription& attachment : scene.attachments()) {
    const size_t first = attachment_sites.size();
    for (const int32_t site : add_point_sites(attachment.a)) attachment_sites.push_back({site});
    size_t pair = first;
    attachment_frames.resize(attachment_sites.size());
    for (const PointSet& points : attachment.b) {
      const std::vector<int32_t> carrier =
          can_hold_here(attachment, points) ? add_carrier_sites(points) : std::vector<int32_t>{};
      for (const int32_t site : add_point_sites(points)) {
        attachment_frames[pair] = carrier;
        attachment_sites[pair++].push_back(site);
      }
    }
    for (const Index3& patch : attachment.patches) {
      for (const int32_t v : patch)
        attachment_sites[pair].push_back(model.bodies_[attachment.patch_body.index].first_site + v);
      ++pair;
    }
  }
}

std::vector<int32_t> Model::Builder::add_carrier_sites(const PointSet& points) {
  const std::vector<Vec3> axes{{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}};
  if (points.kind == PointKind::WorldPoints) return add_frame_sites(world_frame({}));
  std::vector<int32_t> result;
  PointSet frame{.kind = PointKind::BodyPoints, .body = points.body, .node = points.node, .local = {Vec3{}}};
  for (const int32_t site : add_point_sites(frame)) result.push_back(site);
  frame.kind = PointKind::BodyDirections;
  frame.local = axes;
  for (const int32_t site : add_point_sites(frame)) result.push_back(site);
  return result;
}

void Model::Builder::set_carried_places(PotentialBatch& batch, std::span<const int32_t> pairs) const {
  std::vector<Vec3> local;  // by pair, as its attachment has it
  for (const AttachmentDescription& attachment : scene.attachments()) {
    for (const PointSet& points : attachment.b)
      for (int64_t k = 0; k < points.size(); ++k)
        local.push_back(can_hold_here(attachment, points) ? points.local[k] : Vec3{});
    local.resize(local.size() + attachment.patches.size());
  }
  for (size_t e = 0; e < pairs.size(); ++e)
    set_place(batch, static_cast<int64_t>(e),
              std::array{local[pairs[e]].x, local[pairs[e]].y, local[pairs[e]].z});
}

void Model::Builder::add_attachments(std::vector<ConstraintGroup>& groups) {
  const auto first_number = static_cast<int32_t>(scene.joints().size() + scene.actuators().size());
  int32_t next = 0;
  for (const AttachmentDescription& attachment : scene.attachments()) {
    model.attachments_.push_back({.first_pair = next, .first_constraint = first_number + next});
    next += static_cast<int32_t>(attachment.size());
  }
  const auto kind_of_pair = [&](int32_t pair) {
    if (!attachment_frames[pair].empty()) return FrameKind::Placed;
    return attachment_sites[pair].size() == 2 ? FrameKind::Axes : FrameKind::Patch;
  };
  for (const FrameKind kind : {FrameKind::Axes, FrameKind::Patch, FrameKind::Placed}) {
    std::vector<int32_t> stencils, pairs;
    for (int32_t pair = 0; pair < next; ++pair) {
      if (kind_of_pair(pair) != kind) continue;
      const std::span<const int32_t> of_pair = attachment_sites[pair];
      const std::span<const int32_t> carriers =
          kind == FrameKind::Placed ? std::span<const int32_t>(attachment_frames[pair]) : of_pair.subspan(1);
      stencils.push_back(of_pair[0]);
      stencils.insert(stencils.end(), carriers.begin(), carriers.end());
      pairs.push_back(pair);
    }
    if (pairs.empty()) continue;
    auto joint = std::make_shared<const Joint>(*find_joint("ball"), FrameKind::Axes, kind, backend());
    STARK_CHECK(joint->points().size() == stencils.size() / pairs.size());  // the origin and its carriers
    ConstraintGroup group{joint, PotentialBatch(joint->potential()), {}};
    for (const int32_t pair : pairs) group.joints.push_back(first_number + pair);
    group.batch.resize(stencils);
    if (kind == FrameKind::Placed) set_carried_places(group.batch, pairs);
    groups.push_back(std::move(group));
  }
  for (const std::vector<int32_t>& of_pair : attachment_sites) {
    model.joint_sides_.push_back(side_of_sites(std::span(of_pair).first(1)));
    model.joint_sides_.push_back(side_of_sites(std::span(of_pair).subspan(1)));
  }
}

JointSide Model::Builder::side_of_sites(std::span<const int32_t> some) const {
  JointSide side;
  const DofLayout& layout = model.map_.layout();
  const auto add = [&](int32_t block, double mass) {
    if (block == kNoBlock) return;
    side.blocks.push_back(block);
    side.mass += mass;
  };
  for (const int32_t s : some) {
    const Site& site = model.map_.site(s);
    if (site.kind == SiteKind::Point) add(layout.point_block[site.index], model.point_masses_[site.index]);
    if (site.kind == SiteKind::RigidPoint) {
      add(layout.body_block[site.index], model.rigid_masses_[site.index].mass);
      side.rotation_block = layout.rotation_block[site.index];
      side.lever = norm(site.local);
    }
    const SiteSupport support = model.map_.support(s);
    for (size_t k = 0; k < support.points.size(); ++k)
      if (support.weights[k] != 0.0)
        add(layout.point_block[support.points[k]], model.point_masses_[support.points[k]]);
  }
  return side;
}

void Model::Builder::set_initial_attachments(std::span<const Vec3> x) {
  for (const AttachmentDescription& attachment : scene.attachments())
    model.initial_state_.attachment_held.insert(model.initial_state_.attachment_held.end(), attachment.size(),
                                                attachment.enabled ? 1.0 : 0.0);
  if (model.attachments_.empty()) return;
  for (ConstraintGroup& group : energies.constraints.groups()) {
    if (group.joints.front() < model.attachments_.front().first_constraint) continue;
    if (group.batch.point_count() != 4) continue;
    const int field = group.batch.field_index("placement_b");
    for (int64_t e = 0; e < group.batch.size(); ++e) {
      const std::span<const int32_t> sites_of_pair = group.batch.stencil(e);
      group.batch.set(field, e,
                      patch_numbers(world_frame(x[sites_of_pair[0]]),
                                    {x[sites_of_pair[1]], x[sites_of_pair[2]], x[sites_of_pair[3]]}));
    }
  }
}

}  // namespace stark
