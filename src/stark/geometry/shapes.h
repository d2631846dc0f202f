// Meshes of simple shapes, all centred at the origin, sizes in metres. Closed surfaces are oriented outwards.
// Used while a scene is built.
#pragma once

#include <stark/geometry/mesh.h>

namespace stark {

/// Rectangle in the plane z = 0, (cells_x + 1)(cells_y + 1) vertices with x fastest, two triangles a cell,
/// the same diagonal in all cells, normals +z.
TriangleMesh make_grid(double size_x, double size_y, int cells_x, int cells_y);

/// Box with edge lengths `size`, each face split into subdivisions x subdivisions squares.
TriangleMesh make_box(const Vec3& size, int subdivisions = 1);

/// Icosahedron with each triangle split into four `subdivisions` times, vertices pushed onto the sphere.
TriangleMesh make_icosphere(double radius, int subdivisions);

/// Closed cylinder about z, `height` from cap to cap; the caps have no vertices but those of their rims.
TriangleMesh make_cylinder(double radius, double height, int segments = 32, int stacks = 1);

/// Capsule about z: a cylinder of `height` between the centres of two half spheres.
TriangleMesh make_capsule(double radius, double height, int segments = 32, int rings = 8);

/// Torus about z: centre circle of `major_radius`, tube of `minor_radius`.
TriangleMesh make_torus(double major_radius, double minor_radius, int major_segments = 48,
                        int minor_segments = 24);

/// Box of cells[0] x cells[1] x cells[2] cuboid cells. Each cell has an extra node at its centre and 12 tets,
/// two on each face, so the mesh has no preferred diagonal through a cell. Corner nodes first (x fastest),
/// then centres. 20^3 cells: 17,261 nodes.
TetMesh make_tet_box(const Vec3& size, const Index3& cells);

}  // namespace stark
