// Points of a scene that an energy acts on: vertices of bodies, points that are fixed to rigid bodies or
// embedded in deformable ones, points of the world. Directions count as points whose position is the
// direction itself, in world axes.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <stark/base/math.h>
#include <stark/sim/scene/ids.h>

namespace stark {

enum class PointKind : uint8_t { Vertices, BodyPoints, BodyDirections, Embedded, WorldPoints, Joined };

struct PointSet {
  PointKind kind = PointKind::WorldPoints;
  BodyId body{};                    ///< all kinds but WorldPoints and Joined
  std::vector<int32_t> vertices{};  ///< Vertices: of the body's mesh
  int32_t node = -1;                ///< BodyPoints, BodyDirections of a rod: whose frame carries them
  /// BodyPoints [m], BodyDirections: in the frame of the mesh of a rigid body, or of a node of a rod with the
  /// axes d1, d2, d3. WorldPoints [m].
  std::vector<Vec3> local{};
  std::vector<std::array<int32_t, 4>> supports{};  ///< Embedded: vertices of a cloth or solid ...
  std::vector<std::array<double, 4>> weights{};    ///< ... and their weights, which sum to one
  std::vector<PointSet> parts{};                   ///< Joined: sets of other kinds, one after another

  int64_t size() const {
    if (kind == PointKind::Joined) {
      int64_t sum = 0;
      for (const PointSet& part : parts) sum += part.size();
      return sum;
    }
    return static_cast<int64_t>(kind == PointKind::Vertices   ? vertices.size()
                                : kind == PointKind::Embedded ? supports.size()
                                                              : local.size());
  }
};

inline PointSet vertex_points(BodyId body, std::vector<int32_t> vertices) {
  return {.kind = PointKind::Vertices, .body = body, .vertices = std::move(vertices)};
}
inline PointSet body_points(BodyId body, std::vector<Vec3> local) {
  return {.kind = PointKind::BodyPoints, .body = body, .local = std::move(local)};
}
inline PointSet body_directions(BodyId body, std::vector<Vec3> local) {
  return {.kind = PointKind::BodyDirections, .body = body, .local = std::move(local)};
}
inline PointSet node_points(BodyId rod, int32_t node, std::vector<Vec3> local) {
  return {.kind = PointKind::BodyPoints, .body = rod, .node = node, .local = std::move(local)};
}
inline PointSet node_directions(BodyId rod, int32_t node, std::vector<Vec3> local) {
  return {.kind = PointKind::BodyDirections, .body = rod, .node = node, .local = std::move(local)};
}
inline PointSet embedded_points(BodyId body, std::vector<std::array<int32_t, 4>> supports,
                                std::vector<std::array<double, 4>> weights) {
  return {.kind = PointKind::Embedded,
          .body = body,
          .supports = std::move(supports),
          .weights = std::move(weights)};
}
/// Points of several bodies; of energies.
inline PointSet joined_points(std::vector<PointSet> parts) {
  return {.kind = PointKind::Joined, .parts = std::move(parts)};
}
inline PointSet world_points(std::vector<Vec3> positions) {
  return {.kind = PointKind::WorldPoints, .local = std::move(positions)};
}

}  // namespace stark
