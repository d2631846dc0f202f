// The collision primitives of a scene: points, edges and triangles on one array of positions. Pure data.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <stark/collision/group_frames.h>
#include <stark/geometry/mesh.h>

namespace stark {

/// All collision primitives of a scene; vertex ids index one position array. Every vertex of an edge or
/// triangle is a collision point unless it is `inner`; `points` adds vertices that belong to neither
/// (particles). Vertices inside solids are simply not named.
struct SurfaceMesh {
  int32_t vertex_count = 0;
  std::vector<int32_t> points;  // vertices without edges or triangles; others may be listed, too
  std::vector<int32_t> inner;   // vertices of triangles that are no collision points: inside flat faces
  std::vector<Index2> edges;
  std::vector<Index3> triangles;
  std::vector<int32_t> vertex_group, edge_group, triangle_group;  // collision group (body) of each primitive
  std::vector<std::optional<GroupFrame>> frames;  // by group, of those that move as one piece; may end early

  /// Null for groups whose sites move by themselves.
  const GroupFrame* frame_of(int32_t group) const {
    const bool has_frame = static_cast<size_t>(group) < frames.size() && frames[group].has_value();
    return has_frame ? &*frames[group] : nullptr;
  }
};

/// Throws InvalidMesh for indices out of range, array sizes that do not match, repeated vertices, groups
/// outside [0, group_count) and primitives whose vertices are of another group.
void validate(const SurfaceMesh& mesh, int32_t group_count);

}  // namespace stark
