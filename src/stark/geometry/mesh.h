// Plain triangle and tetrahedron meshes: positions in metres and index lists. Geometry layer; no phase, pure
// data.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <stark/base/math.h>

namespace stark {

using Index2 = std::array<int32_t, 2>;
using Index3 = std::array<int32_t, 3>;
using Index4 = std::array<int32_t, 4>;

/// Triangle mesh; vertices in metres. Counter-clockwise triangles seen from outside (or from +z for sheets).
struct TriangleMesh {
  std::vector<Vec3> vertices;
  std::vector<Index3> triangles;
};

/// Tetrahedron mesh; vertices in metres. det[x1 - x0, x2 - x0, x3 - x0] > 0 for every tet.
struct TetMesh {
  std::vector<Vec3> vertices;
  std::vector<Index4> tets;
};

}  // namespace stark
