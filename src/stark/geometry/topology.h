// Connectivity of triangle and tetrahedron meshes: edges, hinges, boundaries, components. Everything is
// sorted, so the result depends only on the input, never on hashing. Used while a scene is built.
#pragma once

#include <span>
#include <vector>

#include <stark/geometry/mesh.h>

namespace stark {

/// Sorts edges (low, high) and leaves each once.
void sort_unique(std::vector<Index2>& edges);

/// Unique undirected edges of the triangles, each (low, high), sorted.
std::vector<Index2> find_edges(std::span<const Index3> triangles);

/// Unique undirected edges of the tets, each (low, high), sorted.
std::vector<Index2> find_edges(std::span<const Index4> tets);

/// One hinge per pair of triangles that share an edge: (v0, v1, v2, v3) with shared edge v0 -> v1 as it runs
/// in the triangle of v2, so (v0, v1, v2) is that triangle's orientation, and v3 opposite in the other
/// triangle. Sorted by the undirected edge. Of an edge with k > 2 triangles all k (k - 1) / 2 pairs become
/// hinges.
std::vector<Index4> find_hinges(std::span<const Index3> triangles);

/// For each edge of find_edges(triangles) (same order) the list of incident triangles: CSR offsets and
/// triangle ids.
struct EdgeTriangles {
  std::vector<Index2> edges;
  std::vector<int32_t> offsets;  // edge_count + 1
  std::vector<int32_t> triangles;
};
EdgeTriangles find_edge_triangles(std::span<const Index3> triangles);

/// Edges with exactly one triangle, directed as that triangle runs through them, sorted by the undirected
/// edge.
std::vector<Index2> find_boundary_edges(std::span<const Index3> triangles);

/// Triangles of the tets' boundary (faces of exactly one tet), oriented outwards for positively oriented
/// tets. In the order of the tets.
std::vector<Index3> find_boundary_triangles(std::span<const Index4> tets);

/// Sorted ids of all vertices that a triangle (or edge, or tet) uses.
std::vector<int32_t> find_used_vertices(std::span<const Index3> triangles);

/// Component number of each vertex; vertices joined by a triangle share one. Components are numbered by their
/// lowest vertex, unused vertices are components of their own.
std::vector<int32_t> find_connected_components(int32_t vertex_count, std::span<const Index3> triangles);

/// Every edge has exactly two triangles.
bool is_closed(std::span<const Index3> triangles);

/// No two triangles run through an edge in the same direction (and no edge has more than two triangles).
bool is_orientation_consistent(std::span<const Index3> triangles);

/// Edges of the box around points, of which there is at least one.
Vec3 box_size(std::span<const Vec3> points);

/// One third of the area of the incident triangles for each vertex [m^2].
std::vector<double> compute_vertex_areas(std::span<const Vec3> vertices, std::span<const Index3> triangles);

/// One third of the area of the incident triangles for each of the edges [m^2] (edges as find_edges gives
/// them).
std::vector<double> compute_edge_areas(std::span<const Vec3> vertices, std::span<const Index3> triangles,
                                       std::span<const Index2> edges);

/// Area of each triangle [m^2].
std::vector<double> compute_triangle_areas(std::span<const Vec3> vertices, std::span<const Index3> triangles);

/// Signed volume of each tet [m^3].
std::vector<double> compute_tet_volumes(std::span<const Vec3> vertices, std::span<const Index4> tets);

/// Throws InvalidMesh when an index is out of range, a vertex repeats in an element or a position is not
/// finite. `name` is what the message calls the mesh.
void validate(const TriangleMesh& mesh, const char* name);

/// As above; additionally every tet must have positive volume.
void validate(const TetMesh& mesh, const char* name);

}  // namespace stark
