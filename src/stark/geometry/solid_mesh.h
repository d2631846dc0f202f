// Meshes of solids of one element type: what a solid is made from. Quadrature data, masses, boundary, edges
// and conversions. Used while a scene or model is built.
#pragma once

#include <array>
#include <span>
#include <vector>

#include <stark/geometry/solid_element.h>

namespace stark {

/// What of a hexahedron is filled, in its reference coordinates x, y, z in [0, 1]: integrals of x^i y^j z^k,
/// i, j, k <= 2, over that part, over the volume of the cell. The first one is the part that is filled.
/// [theory eq. 10m]
struct CellFilling {
  std::array<double, 27> moments = of_full_cell();  ///< of x^i y^j z^k at i + 3 j + 9 k

  double part() const { return moments[0]; }
  bool is_full() const { return part() >= 1.0; }
  /// Over what is filled, of the coordinates and of their squares.
  Vec3 mean() const { return Vec3{moments[1], moments[3], moments[9]} / part(); }
  Vec3 mean_square() const { return Vec3{moments[2], moments[6], moments[18]} / part(); }

  static constexpr std::array<double, 27> of_full_cell() {
    std::array<double, 27> full{};
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        for (int k = 0; k < 3; ++k) full[i + 3 * j + 9 * k] = 1.0 / ((i + 1) * (j + 1) * (k + 1));
    return full;
  }
};

/// A surface that elements carry along: the last vertices of a mesh, each at its rest position in an
/// element. It is what the solid shows and touches with, and says how far elements are filled.
struct Embedding {
  std::vector<int32_t> elements;      ///< by embedded vertex
  std::vector<Index3> triangles;      ///< of embedded vertices, by number in the mesh
  std::vector<CellFilling> fillings;  ///< by element
};

/// Vertices in metres; all elements of one type, nodes in the order of VTK, Jacobians positive. Embedded
/// vertices come after the nodes.
struct SolidMesh {
  std::vector<Vec3> vertices;
  ElementType type = ElementType::Tet4;
  std::vector<int32_t> elements;  ///< [element_count()][node_count()]
  Embedding embedding{};          ///< of hexahedra; empty: the solid shows the boundary of its elements

  SolidMesh() = default;
  SolidMesh(const TetMesh& mesh);  // NOLINT: implicit on purpose, a tetrahedron mesh is a solid mesh
  SolidMesh(std::vector<Vec3> vertices, ElementType type, std::vector<int32_t> elements);

  int node_count() const { return reference_element(type).node_count; }
  bool is_embedded() const { return !embedding.triangles.empty(); }
  /// Number of the first vertex that is no node.
  size_t first_embedded() const { return vertices.size() - embedding.elements.size(); }
  int64_t element_count() const { return static_cast<int64_t>(elements.size()) / node_count(); }
  std::span<const int32_t> element(int64_t e) const {
    return {elements.data() + e * node_count(), static_cast<size_t>(node_count())};
  }
};

/// Throws InvalidMesh where an element refers to a vertex, or an embedded vertex to an element, that does not
/// exist, and where fillings are not one for each element.
void check_indices(const SolidMesh& mesh);

/// Gradients of the shape functions in rest coordinates [1/m], and determinant of the Jacobian of the map
/// from the reference cell, at a reference position in an element.
double rest_gradients(const SolidMesh& mesh, int64_t element, const Vec3& position, std::span<Vec3> out);

/// Rest position of a reference position in an element [m].
Vec3 rest_position(const SolidMesh& mesh, int64_t element, const Vec3& position);

/// Smallest determinant of the Jacobian over the quadrature points of an element [m^3]; an element can be
/// computed with where it is positive.
double smallest_jacobian(const SolidMesh& mesh, int64_t element);

/// Quadrature points of an element in reference coordinates, and the volumes that they stand for [m^3]; of
/// elements that are filled in part those of cut_rule().
std::vector<QuadraturePoint> quadrature_rule(const SolidMesh& mesh, int64_t element);

/// Volume of each element [m^3], of what is filled of it.
std::vector<double> compute_element_volumes(const SolidMesh& mesh);

/// Parts of the volume of an element that its nodes stand for [m^3], all positive: a quarter each on linear
/// tetrahedra, otherwise in proportion to the integrals of N_a^2 [Hinton, Rock, Zienkiewicz 1976], because
/// row sums are negative at the corners of quadratic tetrahedra; of elements that are filled in part with the
/// volume and the centre of that part.
void lump_volume(const SolidMesh& mesh, int64_t element, std::span<double> out);

/// Triangles of faces that belong to one element only, outwards, in the order of the elements; of embedded
/// surfaces theirs.
std::vector<Index3> find_boundary_triangles(const SolidMesh& mesh);

/// Unique edges between neighbouring nodes, each (low, high), sorted.
std::vector<Index2> find_edges(const SolidMesh& mesh);

/// Box about the origin of cells[0] x cells[1] x cells[2] cuboid elements with 8 nodes; x fastest.
SolidMesh make_hex_box(const Vec3& size, const Index3& cells);

/// Same cells with nodes in the middle of edges (tetrahedra) and of edges, faces and cells (hexahedra).
/// Quadratic meshes come back as they are.
SolidMesh to_quadratic(const SolidMesh& mesh);

}  // namespace stark
