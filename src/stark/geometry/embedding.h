// Surfaces in hexahedra: shape functions at embedded vertices, and masses of elements that are filled in
// part. Used while a scene or model is built. [theory eq. 10m]
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

/// Positive weights of a product rule at `points` of the reference cell, two or three in each direction,
/// that sum to one and have the mean, and with three points the mean square, of a filling. Where positive
/// weights cannot, they have the nearest that can.
void filled_rule(std::span<const Vec3> points, const CellFilling& filling, std::span<double> out);

}  // namespace stark
