// A surface in a lattice of cubes: what a coarse elastic body with a fine surface is made from. Used while a
// mesh is made. [theory eq. 10m]
#pragma once

#include <stark/geometry/solid_mesh.h>

namespace stark {

/// Cubes of edge `cell_size` [m] wherever the surface is or encloses, of 8 nodes or with `quadratic` of 27,
/// and the surface embedded in them. Cells at the surface are filled in part: points of a sequence that fills
/// space evenly are inside where the winding number of the surface is above one half, so it may have holes
/// and overlaps. The volume of a closed surface without overlaps is met exactly. Throws InvalidArgument for a
/// cell size that is not positive or makes more than two million cells, InvalidMesh for surfaces without
/// triangles, with vertices that are not finite or belong to no triangle, for those that enclose nothing and
/// for those that are so much thinner than a cell that no sample is inside.
SolidMesh make_lattice(const TriangleMesh& surface, double cell_size, bool quadratic = false);

/// Reference coordinates of the points, [0, 1)^3, at which cells are asked whether they are inside.
inline constexpr int kFillingSamples = 1024;

}  // namespace stark
