// Layers of a composite body: membranes, plates and rods whose points are vertices of a cloth or a solid. A
// layer adds energy and mass to vertices that are there, so it takes part in everything that the body does.
// The surface for contact and its distance stay those of the body.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <stark/base/math.h>
#include <stark/geometry/mesh.h>
#include <stark/mechanics/constitutive_law.h>
#include <stark/mechanics/field_values.h>
#include <stark/mechanics/rod_law.h>
#include <stark/sim/scene/ids.h>
#include <stark/sim/scene/materials.h>
#include <stark/sim/scene/rest_shape.h>

namespace stark {

/// A sheet on vertices of a body; no unknowns of its own.
struct SkinDescription {
  std::string name{};  ///< unique among bodies and layers; empty: that of the body and "_skin"
  BodyId body{};
  /// Vertices of the body, three by three, of its surface or within it. Empty: the whole surface.
  std::vector<Index3> triangles{};
  ShellMaterial material{};
  std::optional<ShellLaw> law{};  ///< as of cloth
  ParameterValues fields{};       ///< as of cloth
  RestAngles rest_angles = RestAngles::Mesh;
  std::optional<Color> color{};
};

/// Rods along vertices of a body. With bending, every node of every path has a frame, three unknowns that
/// turn; without, none.
struct FibresDescription {
  std::string name{};  ///< unique among bodies and layers; empty: that of the body and "_fibres"
  BodyId body{};
  /// Vertices of the body along each fibre; a path that ends where it starts is a ring. Paths may cross at
  /// vertices, where they turn against each other freely.
  std::vector<std::vector<int32_t>> paths{};
  RodMaterial material{};
  std::optional<RodLaw> law{};  ///< as of rods
  ParameterValues fields{};     ///< as of rods; values for each edge, path by path
  bool bending = true;          ///< bending, twist and shear besides stretch
  RestShape rest_shape = RestShape::Mesh;
  std::optional<Vec3> normal{};  ///< as of rods, of all paths, in the frame of the body
  std::optional<Color> color{};

  int64_t edge_count() const {
    int64_t count = 0;
    for (const auto& path : paths) count += static_cast<int64_t>(path.size()) - 1;
    return count;
  }
};

/// Whether a path is a ring.
inline bool is_ring(const std::vector<int32_t>& path) { return path.front() == path.back(); }
/// Nodes of a path; a ring has its first vertex once.
inline size_t node_count(const std::vector<int32_t>& path) { return path.size() - (is_ring(path) ? 1 : 0); }

}  // namespace stark
