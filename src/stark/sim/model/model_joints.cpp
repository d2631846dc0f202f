// Joints of a model: sites of their frames, one group for each definition and kinds of frames.
#include <stark/base/rotation.h>
#include <stark/sim/model/held_places.h>
#include <stark/sim/model/model_builder.h>

namespace stark {

namespace {

using Carrier = FrameDescription::Carrier;

}  // namespace

std::vector<double> Model::Builder::patch_numbers(const FrameDescription& frame,
                                                  const std::array<Vec3, 3>& p) {
  const Vec3 u = p[1] - p[0], v = p[2] - p[0], d = frame.position - p[0];
  const Vec3 z = normalized(cross(u, v)), x = normalized(u);
  const Mat3 axes = Mat3::from_columns(x, cross(z, x), z);
  const double height = dot(d, z);
  const Vec3 flat = d - z * height;
  const double uu = dot(u, u), uv = dot(u, v), vv = dot(v, v), fu = dot(flat, u), fv = dot(flat, v);
  const double scale = 1.0 / (uu * vv - uv * uv);
  const double w1 = (vv * fu - uv * fv) * scale, w2 = (uu * fv - uv * fu) * scale;
  std::vector<double> numbers{1.0 - w1 - w2, w1, w2, height};
  const Mat3 local = transpose(axes) * frame.rotation;
  numbers.insert(numbers.end(), local.m.begin(), local.m.end());
  return numbers;
}

FrameKind Model::Builder::kind_of(const FrameDescription& frame) {
  return frame.carrier == Carrier::Patch ? FrameKind::Patch : FrameKind::Axes;
}

FrameKind Model::Builder::kind_of_b(const JointDescription& joint) {
  return can_hold_here(joint) ? FrameKind::Placed : kind_of(joint.b);
}

std::vector<int32_t> Model::Builder::add_frame_sites(const FrameDescription& frame) {
  const std::vector<Vec3> axes{frame.rotation.column(0), frame.rotation.column(1), frame.rotation.column(2)};
  std::vector<int32_t> result;
  const auto append = [&](const PointSet& points) {
    for (const int32_t site : add_point_sites(points)) result.push_back(site);
  };
  switch (frame.carrier) {
    case Carrier::World:
      append(world_points({frame.position, axes[0], axes[1], axes[2]}));
      break;
    case Carrier::Body:
      append(body_points(frame.body, {frame.position}));
      append(body_directions(frame.body, axes));
      break;
    case Carrier::Node: {
      const int32_t node = frame.vertices[0];
      const Mat3 to_node = transpose(scene.initial_frames(frame.body)[node]);
      const Vec3 offset = frame.position - scene.initial_positions(frame.body)[node];
      append(node_points(frame.body, node, {to_node * offset}));
      append(node_directions(frame.body, node, {to_node * axes[0], to_node * axes[1], to_node * axes[2]}));
      break;
    }
    case Carrier::Patch:
      append(vertex_points(frame.body, {frame.vertices.begin(), frame.vertices.end()}));
      break;
  }
  return result;
}

void Model::Builder::add_joint_sites() {
  for (const JointDescription& joint : scene.joints()) {
    std::vector<int32_t>& sites_of_joint = joint_sites.emplace_back(add_frame_sites(joint.a));
    const std::vector<int32_t> second = add_frame_sites(joint.b);
    sites_of_joint.insert(sites_of_joint.end(), second.begin(), second.end());
  }
}

void Model::Builder::add_joints() {
  struct Key {
    const JointDefinition* definition;
    FrameKind a, b;
    auto operator<=>(const Key&) const = default;
  };
  std::map<Key, size_t> index;
  std::vector<std::vector<int32_t>> members;
  std::vector<Key> keys;  // in the order of the joints: addresses decide nothing
  for (int32_t j = 0; j < static_cast<int32_t>(scene.joints().size()); ++j) {
    const JointDescription& joint = scene.joints()[j];
    const Key key{joint.definition.get(), kind_of(joint.a), kind_of_b(joint)};
    const auto [entry, is_new] = index.try_emplace(key, members.size());
    if (is_new) {
      members.emplace_back();
      keys.push_back(key);
    }
    members[entry->second].push_back(j);
  }
  std::vector<ConstraintGroup> groups;
  for (size_t g = 0; g < keys.size(); ++g)
    groups.push_back(make_group(std::make_shared<Joint>(*keys[g].definition, keys[g].a, keys[g].b, backend()),
                                members[g]));
  for (const JointDescription& joint : scene.joints())
    for (const FrameDescription* frame : {&joint.a, &joint.b}) model.joint_sides_.push_back(side_of(*frame));
  add_actuators(groups);
  add_attachments(groups);
  energies.constraints = ConstraintSet(std::move(groups));
  list_held_places();
  locate_actuators();
}

ConstraintGroup Model::Builder::make_group(std::shared_ptr<const Joint> joint,
                                           const std::vector<int32_t>& members) const {
  std::vector<int32_t> stencils;
  for (const int32_t j : members)
    for (const int p : joint->points()) stencils.push_back(joint_sites[j][p]);
  ConstraintGroup group{joint, PotentialBatch(joint->potential()), members};
  group.batch.resize(stencils);
  for (size_t e = 0; e < members.size(); ++e)
    set_joint_fields(group.batch, static_cast<int64_t>(e), scene.joints()[members[e]], "");
  return group;
}

void Model::Builder::set_joint_fields(PotentialBatch& batch, int64_t element, const JointDescription& joint,
                                      const std::string& prefix) const {
  for (const ElementField& field : batch.potential().element_fields()) {
    if (field.source != ElementField::Source::Data || !field.name.starts_with(prefix)) continue;
    const std::string name = field.name.substr(prefix.size());
    if (name == "placement_a") batch.set(field.name, element, placement(joint.a));
    if (name == "placement_b" && can_hold_here(joint))
      set_place(batch, element, std::array{0.0, 0.0, 0.0});
    else if (name == "placement_b")
      batch.set(field.name, element, placement(joint.b));
    if (const auto given = joint.values.find(name); given != joint.values.end())
      batch.set(field.name, element, given->second.values);
  }
}

std::vector<double> Model::Builder::placement(const FrameDescription& frame) const {
  const std::vector<Vec3> x = scene.initial_positions(frame.body);
  return patch_numbers(frame, {x[frame.vertices[0]], x[frame.vertices[1]], x[frame.vertices[2]]});
}

void Model::Builder::set_initial_rates(std::span<const Vec3> x) {
  // Those of an imagined step that ends at time 0, so that the first step continues it.
  State& state = model.initial_state_;
  const double h = settings.time.step;
  Configuration before{state.point_position, state.body_position, state.body_rotation};
  for (size_t p = 0; p < before.point_position.size(); ++p)
    before.point_position[p] -= state.point_velocity[p] * h;
  for (size_t b = 0; b < before.body_position.size(); ++b) {
    before.body_position[b] -= state.body_velocity[b] * h;
    before.body_rotation[b] = exp_rotation(state.body_angular_velocity[b] * -h) * before.body_rotation[b];
  }
  std::vector<Vec3> x_before(x.size());
  model.map_.positions(before, x_before);
  const std::vector<double> from = energies.constraints.coordinates(x_before);
  state.joint_rate = state.joint_coordinate;
  for (const ConstraintGroup& group : energies.constraints.groups())
    for (const int32_t j : group.joints) {
      const int64_t first = energies.constraints.place(j).coordinate;
      const auto& coordinates = group.joint->coordinates();
      for (size_t k = 0; k < coordinates.size(); ++k) {
        const double change = state.joint_coordinate[first + k] - from[first + k];
        state.joint_rate[first + k] = (coordinates[k].unit == "rad" ? shortest_turn(change) : change) / h;
      }
    }
}

std::vector<int32_t> Model::Builder::carriers_of(int32_t site) const {
  const std::span<const int32_t> support = model.map_.support(site).points;
  return support.empty() ? std::vector{site} : std::vector(support.begin(), support.end());
}

JointSide Model::Builder::side_of(const FrameDescription& frame) const {
  JointSide side;
  const DofLayout& layout = model.map_.layout();
  if (frame.carrier == Carrier::Body || frame.carrier == Carrier::Node) {
    const int32_t node = frame.carrier == Carrier::Node ? frame.vertices[0] : 0;
    const int32_t body = model.bodies_[frame.body.index].rigid_index + node;
    const RigidMass& mass = model.rigid_masses_[body];
    if (const int32_t block = layout.body_block[body]; block != kNoBlock) {
      side.blocks = {block};
      side.mass = mass.mass;
    }
    if (const int32_t block = layout.rotation_block[body]; block != kNoBlock) {
      side.rotation_block = block;
      side.moment = (mass.moments.x + mass.moments.y + mass.moments.z) / 3.0;
    }
    if (frame.carrier == Carrier::Node)
      side.lever = norm(frame.position - scene.initial_positions(frame.body)[node]);
  }
  if (frame.carrier == Carrier::Patch) {
    const ModelBody& body = model.bodies_[frame.body.index];
    const std::vector<Vec3> x = scene.initial_positions(frame.body);
    for (int k = 0; k < 3; ++k) {
      const int32_t p = body.first_site + frame.vertices[k];
      for (const int32_t q : carriers_of(p))
        if (const int32_t block = layout.point_block[q]; block != kNoBlock) {
          side.blocks.push_back(block);
          side.mass += model.point_masses_[q];
        }
      const double edge = norm(x[frame.vertices[k]] - x[frame.vertices[(k + 1) % 3]]);
      side.reach = std::max(side.reach, edge);
    }
    side.moment = side.mass * side.reach * side.reach / 3.0;
  }
  return side;
}

}  // namespace stark
