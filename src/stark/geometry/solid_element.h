// Finite elements of solids on their reference cells: shape functions, quadrature, faces and edges. Nodes in
// the order of VTK; reference coordinates in [0, 1]^3, for tetrahedra below x + y + z = 1. Used while a model
// is built.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include <stark/geometry/mesh.h>

namespace stark {

/// Linear and quadratic tetrahedra, trilinear and triquadratic hexahedra.
enum class ElementType : uint8_t { Tet4, Tet10, Hex8, Hex27 };

struct QuadraturePoint {
  Vec3 position;        ///< reference coordinates
  double weight = 0.0;  ///< the weights sum to the volume of the reference cell
};

/// Side of an element. Corners say which face it is; triangles cover it with all its nodes, outwards.
struct ElementFace {
  std::vector<int32_t> corners;
  std::vector<Index3> triangles;
};

/// Everything that does not depend on the mesh; one constant object for each type.
struct ReferenceElement {
  ElementType type;
  std::string_view name;  ///< "tetrahedron", "10-node tetrahedron", ...
  int node_count = 0;
  std::vector<Vec3> nodes;  ///< reference coordinates
  /// Corners whose mean is the node on a straight-sided element: 1 of a corner, 2 of an edge, 4 of a face, 8
  /// of a cell.
  std::vector<std::vector<int32_t>> parents;
  std::vector<QuadraturePoint> quadrature;       ///< of the energy
  std::vector<QuadraturePoint> mass_quadrature;  ///< exact for products of shape functions
  std::vector<ElementFace> faces;
  std::vector<Index2> edges;  ///< between neighbouring nodes of the element's edges
};

const ReferenceElement& reference_element(ElementType type);

/// Functions of the volume ratio of an element of mean dilatation: 1 for a constant one, 4 for a linear one,
/// which triquadratic hexahedra have enough displacements for (Q2/P1).
int mean_dilatation_modes(ElementType type);

/// Values of the shape functions at a point of the reference cell, one per node.
void shape_functions(ElementType type, const Vec3& position, std::span<double> out);
/// Their gradients in reference coordinates.
void shape_gradients(ElementType type, const Vec3& position, std::span<Vec3> out);

}  // namespace stark
