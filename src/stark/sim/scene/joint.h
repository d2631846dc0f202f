// A joint of a scene: a definition (mechanics/joint.h) between two frames, with its constants.
#pragma once

#include <cmath>
#include <limits>
#include <memory>
#include <set>
#include <string>

#include <stark/mechanics/field_values.h>
#include <stark/mechanics/joint.h>
#include <stark/sim/scene/ids.h>

namespace stark {

/// Where a frame is and what carries it. Axes are the columns of `rotation`.
struct FrameDescription {
  enum class Carrier : uint8_t { World, Body, Patch, Node };
  Carrier carrier = Carrier::World;
  BodyId body{};  ///< Body: rigid; Patch: cloth or solid; Node: rod
  /// World, Patch and Node: in the world at time 0. Body: in the frame of the body's mesh. [m]
  Vec3 position{};
  Mat3 rotation = Mat3::identity();
  std::array<int32_t, 3> vertices{};  ///< Patch: three vertices of the body; Node: the first one
};

inline FrameDescription world_frame(const Vec3& position, const Mat3& rotation = Mat3::identity()) {
  return {.position = position, .rotation = rotation};
}
inline FrameDescription body_frame(BodyId body, const Vec3& position,
                                   const Mat3& rotation = Mat3::identity()) {
  return {
      .carrier = FrameDescription::Carrier::Body, .body = body, .position = position, .rotation = rotation};
}
inline FrameDescription patch_frame(BodyId body, const std::array<int32_t, 3>& vertices, const Vec3& position,
                                    const Mat3& rotation = Mat3::identity()) {
  return {.carrier = FrameDescription::Carrier::Patch,
          .body = body,
          .position = position,
          .rotation = rotation,
          .vertices = vertices};
}

inline FrameDescription node_frame(BodyId rod, int32_t node, const Vec3& position,
                                   const Mat3& rotation = Mat3::identity()) {
  return {.carrier = FrameDescription::Carrier::Node,
          .body = rod,
          .position = position,
          .rotation = rotation,
          .vertices = {node, -1, -1}};
}

struct JointDescription {
  std::string name{};  ///< unique among the joints of the scene; empty: the definition's, numbered
  std::shared_ptr<const JointDefinition> definition{};
  FrameDescription a{}, b{};
  ParameterValues values{};  ///< constants of the formula, one set of numbers each
  double break_force = std::numeric_limits<double>::infinity();   ///< [N] above which it breaks
  double break_torque = std::numeric_limits<double>::infinity();  ///< [N m], about the origin of frame b
  bool enabled = true;
  bool contact = true;  ///< false: the two bodies do not touch while it holds (sim/model/exclusions.h)

  bool can_break() const { return std::isfinite(break_force) || std::isfinite(break_torque); }
};

/// The bodies that its frames are carried by, by number.
inline std::set<int32_t> connected_bodies(const JointDescription& joint) {
  std::set<int32_t> bodies;
  for (const FrameDescription* frame : {&joint.a, &joint.b})
    if (frame->carrier != FrameDescription::Carrier::World) bodies.insert(frame->body.index);
  return bodies;
}

/// Force [N] and torque [N m] on a body, about a point.
struct Wrench {
  Vec3 force{}, torque{};
};

}  // namespace stark
