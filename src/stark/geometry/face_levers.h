// Where friction of the corners of a flat face acts, so that it takes the torque of an even pressure.
//
// Corners are farther from the middle of a face than the pressure that they stand for: sliding about the
// normal would meet the mean distance of the corners, 1.85 times that of the points of a square.
#pragma once

#include <span>
#include <vector>

#include <stark/geometry/flat_faces.h>
#include <stark/geometry/mesh.h>

namespace stark {

/// A vertex of the border of a flat face, a triangle of that face, and the place of the vertex's share.
struct FaceLever {
  int32_t vertex = 0, triangle = 0;
  Vec3 place;  ///< between the vertex and the centre of the face [m]
};

/// Of all large, convex flat faces with at most a few vertices inside; more of them carry pressure
/// themselves. Large: from a twentieth of the surface on; what has smaller ones is round. Sorted by vertex,
/// then triangle.
std::vector<FaceLever> find_face_levers(std::span<const Vec3> vertices, std::span<const Index3> triangles);

/// Vertices inside those faces, sorted: too few to sample a pressure, as one in the middle of a disc is.
/// flat: find_flat_faces() of the mesh.
std::vector<int32_t> find_lone_vertices(std::span<const Vec3> vertices, std::span<const Index3> triangles,
                                        const FlatFaces& flat);

}  // namespace stark
