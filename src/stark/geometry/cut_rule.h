// Quadrature in hexahedra that a surface fills in part. Used while a model is built. [theory eq. 10m]
#pragma once

#include <vector>

#include <stark/geometry/solid_mesh.h>

namespace stark {

/// Quadrature points in reference coordinates with positive weights that sum to one, as many as the element
/// has in full. Of what is filled, with a little of the whole cell mixed in so that no motion of its nodes is
/// free, they have with 27 nodes all moments of a CellFilling (within 2e-4 where it is at least a fifth of
/// the cell wide), with 8 nodes those up to the second order.
std::vector<QuadraturePoint> cut_rule(ElementType type, const CellFilling& filling);

/// Whether moments can be those of a part of a cell, as far as simple bounds tell.
bool is_of_a_cell(const CellFilling& filling);

}  // namespace stark
