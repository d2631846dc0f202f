// Surfaces in hexahedra: shape functions at embedded vertices, and rules of quadrature and masses for
// elements that are filled in part. Used while a scene or model is built. [theory eq. 10m]
#pragma once

#include <span>
#include <vector>

#include <stark/geometry/solid_mesh.h>

namespace stark {

/// Reference coordinates of a point [m] in an element, by Newton's method on its shape functions; exact in
/// one step for cuboids. Coordinates of points that cannot be found are not finite.
Vec3 find_reference_position(const SolidMesh& mesh, int64_t element, const Vec3& position);

/// Shape functions of its element at embedded vertex k, counted from the first one: [node_count()].
void embedding_weights(const SolidMesh& mesh, size_t k, std::span<double> out);
/// Of all embedded vertices: [vertex][node].
std::vector<double> embedding_weights(const SolidMesh& mesh);

/// Where a point of a rule on the cell is in what is filled: the rule is that of the box with the centre and
/// the second moments of the filling, at least a tenth of the cell wide; with 27 nodes half of it where less
/// than a tenth is filled.
Vec3 filled_position(ElementType type, const CellFilling& filling, const Vec3& position);

/// Positions of the quadrature points of an element in its reference coordinates, those of filled_position().
std::vector<Vec3> quadrature_positions(const SolidMesh& mesh, int64_t element);

/// Positive weights of a product rule at `points` of the reference cell, two or three in each direction,
/// that sum to one and have the mean, and with three points the mean square, of a filling. Where positive
/// weights cannot, they have the nearest that can.
void filled_rule(std::span<const Vec3> points, const CellFilling& filling, std::span<double> out);

}  // namespace stark
