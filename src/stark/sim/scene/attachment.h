// An attachment of a scene: points that are glued to what carries them, pair by pair. A pair is a ball joint
// (mechanics/joint.h) between a point and a point, or between a point and its place on a triangle.
#pragma once

#include <limits>
#include <set>
#include <string>
#include <vector>

#include <stark/geometry/mesh.h>
#include <stark/sim/scene/point_set.h>

namespace stark {

struct AttachmentDescription {
  std::string name{};  ///< unique among the attachments of the scene; empty: "attachment", numbered
  PointSet a{};        ///< n points
  /// Points that coincide with them at time 0 (where `sewn`, or released: later), together n. Or else
  /// patches: each point keeps its place relative to three vertices of `patch_body` as it is at time 0,
  /// height above their plane included.
  std::vector<PointSet> b{};
  BodyId patch_body{};
  std::vector<Index3> patches{};
  double break_force = std::numeric_limits<double>::infinity();  ///< [N] of each pair, above which it breaks
  bool enabled = true;
  bool contact = true;  ///< false: the two bodies do not touch while a pair holds (sim/model/exclusions.h)
  bool sewn = false;    ///< contact is left out from time 0 on, so that pairs that are released can meet

  int64_t size() const { return a.size(); }
};

/// The bodies of both sides, by number.
inline std::set<int32_t> connected_bodies(const AttachmentDescription& attachment) {
  std::set<int32_t> bodies;
  const auto add = [&](const PointSet& points) {
    if (points.kind != PointKind::WorldPoints) bodies.insert(points.body.index);
  };
  add(attachment.a);
  for (const PointSet& points : attachment.b) add(points);
  if (!attachment.patches.empty()) bodies.insert(attachment.patch_body.index);
  return bodies;
}

}  // namespace stark
