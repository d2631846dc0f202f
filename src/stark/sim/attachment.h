// An attachment of a scene: points that are glued to what carries them, pair by pair. A pair is a ball joint
// (mechanics/joint.h) between a point and a point, or between a point and its place on a triangle.
#pragma once

#include <limits>
#include <string>
#include <vector>

#include <stark/geometry/mesh.h>
#include <stark/sim/point_set.h>

namespace stark {

struct AttachmentDescription {
  std::string name{};  ///< unique among the attachments of the scene; empty: "attachment", numbered
  PointSet a{};        ///< n points
  /// Points that coincide with them at time 0, together n. Or else patches: each point keeps its place
  /// relative to three vertices of `patch_body` as it is at time 0, height above their plane included.
  std::vector<PointSet> b{};
  BodyId patch_body{};
  std::vector<Index3> patches{};
  double break_force = std::numeric_limits<double>::infinity();  ///< [N] of each pair, above which it breaks
  bool enabled = true;

  int64_t size() const { return a.size(); }
};

}  // namespace stark
