// Directions of the edges of a triangle mesh: which directions a law of edges leaves free. Used while a scene
// is built.
#pragma once

#include <span>
#include <vector>

#include <stark/geometry/mesh.h>

namespace stark {

/// Largest angle [rad] between neighbouring directions of the edges around each triangle, in its plane:
/// its own edges and those of the triangles across them, unfolded. Up to half of it away from any edge, a
/// direction can stretch by 1/cos of that half before an edge does. A quarter turn on a grid of right
/// triangles whose diagonals are parallel, an eighth with diagonals that alternate.
std::vector<double> compute_direction_gaps(std::span<const Vec3> vertices, std::span<const Index3> triangles);

}  // namespace stark
