// Scene: checks of joints.
#include <algorithm>
#include <tuple>

#include <stark/base/error.h>
#include <stark/sim/scene/scene.h>
#include <stark/sim/scene/validation.h>

namespace stark {

namespace {

/// Twice the area over the longest edge squared, below which a patch has no normal to speak of.
constexpr double kThinnestPatch = 1e-6;

void check_patch(const std::string& owner, const Scene& scene, const FrameDescription& frame) {
  const std::vector<Vec3> x = scene.initial_positions(frame.body);
  for (const int32_t v : frame.vertices)
    if (v < 0 || static_cast<size_t>(v) >= x.size())
      throw InvalidArgument(owner + ": vertex " + std::to_string(v) + " of '" + scene.name(frame.body) +
                            "': must be in [0, " + std::to_string(x.size()) +
                            "); give indices of three vertices of the mesh");
  const Vec3 &a = x[frame.vertices[0]], &b = x[frame.vertices[1]], &c = x[frame.vertices[2]];
  const double longest = std::max({norm(b - a), norm(c - b), norm(a - c)});
  if (!(norm(cross(b - a, c - a)) > kThinnestPatch * longest * longest))
    throw InvalidArgument(owner + ": the patch of '" + scene.name(frame.body) +
                          "' has no area at time 0: its vertices must not be on a line; choose others");
}

}  // namespace

void Scene::check_frame(const std::string& owner, const FrameDescription& frame) const {
  check_finite(owner, "position", frame.position, "m");
  check_rotation(owner, frame.rotation);
  switch (frame.carrier) {
    case FrameDescription::Carrier::World:
      break;
    case FrameDescription::Carrier::Body:
      if (!is_rigid(kind(frame.body)))
        throw InvalidArgument(owner + ": '" + name(frame.body) + "' is a " + to_string(kind(frame.body)) +
                              " body: only rigid bodies and nodes of rods carry frames; use a patch of three "
                              "vertices");
      break;
    case FrameDescription::Carrier::Patch:
      if (!has_points(kind(frame.body)))
        throw InvalidArgument(owner + ": '" + name(frame.body) + "' is a " + to_string(kind(frame.body)) +
                              " body: patches belong to cloth and solids; use a frame of the body or of a "
                              "node of the rod");
      check_patch(owner, *this, frame);
      break;
    case FrameDescription::Carrier::Node:
      if (const auto nodes = static_cast<int32_t>(rod(frame.body).mesh.vertices.size());
          frame.vertices[0] < 0 || frame.vertices[0] >= nodes)
        throw InvalidArgument(owner + ": node " + std::to_string(frame.vertices[0]) + " of '" +
                              name(frame.body) + "': must be in [0, " + std::to_string(nodes) +
                              "); give the index of a node of the rod");
      break;
  }
}

JointId Scene::add_joint(JointDescription joint) {
  if (!joint.definition || !joint.definition->formula)
    throw InvalidArgument("joint '" + joint.name + "': has no definition; make one with define_joint");
  if (joint.name.empty()) {
    joint.name = joint_names_.next(joint.definition->name);
  } else if (joint_names_.contains(joint.name)) {
    throw InvalidArgument(
        "joint '" + joint.name +
        "': the name is taken: names of joints must be unique in a scene; choose another or "
        "leave it out");
  }
  const std::string owner = "joint '" + joint.name + "'";
  check_frame(owner + ", frame a", joint.a);
  check_frame(owner + ", frame b", joint.b);
  const auto is_world = [](const FrameDescription& f) {
    return f.carrier == FrameDescription::Carrier::World;
  };
  if (is_world(joint.a) && is_world(joint.b))
    throw InvalidArgument(owner + ": both frames are of the world: at least one must be carried by a body");
  const auto is_body = [](const FrameDescription& f) { return f.carrier == FrameDescription::Carrier::Body; };
  if (is_body(joint.a) && is_body(joint.b) && joint.a.body.index == joint.b.body.index)
    throw InvalidArgument(owner + ": both frames are of '" + name(joint.a.body) +
                          "': must be of two bodies, as nothing moves within a rigid one");
  for (const auto& [what, value, unit] : {std::tuple("break_force", joint.break_force, "N"),
                                          std::tuple("break_torque", joint.break_torque, "N m")})
    if (!(value > 0.0))
      throw InvalidArgument(owner + ": " + what + " = " + quantity_text(value, unit) +
                            ": must be > 0; leave it out for joints that do not break");
  std::vector<std::string> names;
  for (const ParameterDeclaration& field : joint_parameters(*joint.definition)) {
    names.push_back(field.name);
    const auto given = joint.values.find(field.name);
    if (given == joint.values.end())
      throw InvalidArgument(owner + ": '" + field.name + "' [" + field.unit + "] is missing: " + field.doc);
    check_values(owner, field, given->second, 1);
  }
  for (const auto& [name, values] : joint.values)
    if (std::find(names.begin(), names.end(), name) == names.end())
      throw InvalidArgument(owner + ": unknown value '" + name + "'" + nearest_name_hint(name, names) +
                            ": must be an input of the formula; remove it");
  joint_names_.add(joint.name);
  joints_.push_back(std::move(joint));
  return {static_cast<int32_t>(joints_.size()) - 1};
}

const JointDescription& Scene::joint(JointId joint) const {
  if (joint.index < 0 || joint.index >= static_cast<int32_t>(joints_.size()))
    throw InvalidArgument("joint id " + std::to_string(joint.index) + ": must be in [0, " +
                          std::to_string(joints_.size()) +
                          ") for this scene; use the ids that add_joint returned");
  return joints_[joint.index];
}

}  // namespace stark
