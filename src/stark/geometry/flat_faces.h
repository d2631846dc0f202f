// Flat faces of triangle meshes: what a triangulation adds to a polyhedron (inner edges and vertices) and
// which triangles are one convex face. Collision detection of rigid bodies needs the polyhedron only.
#pragma once

#include <span>
#include <vector>

#include <stark/geometry/mesh.h>

namespace stark {

/// The distance of anything to a flat face is attained at a point of it and a vertex of the other, at an edge
/// of its border, or at a corner: inner edges and vertices never decide, and an affine motion keeps it so.
struct FlatFaces {
  std::vector<Index2> edges;            ///< those of find_edges() that are not inside a face, in their order
  std::vector<int32_t> inner_vertices;  ///< sorted
  /// For each triangle the lowest one of its face where the face is convex, so that there is one nearest
  /// point; else the triangle itself.
  std::vector<int32_t> face;
  std::vector<int32_t> patch;  ///< for each triangle the lowest one of its face, convex or not
};

/// Triangles are of one flat face when they share edges (of two triangles each), are oriented alike and their
/// vertices lie within 1e-10 times the diagonal of the mesh of one plane. vertices [m].
FlatFaces find_flat_faces(std::span<const Vec3> vertices, std::span<const Index3> triangles);

/// All edges, no inner vertices, each triangle a face of its own: of surfaces that bend.
FlatFaces separate_faces(std::span<const Index3> triangles);

}  // namespace stark
