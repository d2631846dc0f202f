// Chain rule for one element: J^T g and J^T H J added to gradient and block matrix, and the moment sum that
// the rigid curvature needs (step phase 4e; formulas in kinematic_map.h). [theory eq. 5, 6]
#pragma once

#include <limits>
#include <span>

#include <stark/linalg/block_matrix.h>
#include <stark/mechanics/element_view.h>
#include <stark/mechanics/embedded_assembly.h>
#include <stark/mechanics/kinematic_map.h>

namespace stark {

/// First-order change of the gradient of `element` due to the displacements of its prescribed sites:
/// sum_j H_ij pending_j, one Vec3 per point. `sites` is the stencil.
void pending_gradient(const ElementView& element, std::span<const int32_t> sites, const KinematicMap& map,
                      std::span<const Vec3> pending, std::span<Vec3> out);

/// Rows of blocks of the system.
struct RowRange {
  int32_t begin = 0, end = std::numeric_limits<int32_t>::max();
  bool has(int32_t row) const { return begin <= row && row < end; }
};

/// Adds an element whose sites are points or prescribed: the map is the identity on `blocks`, kNoBlock for
/// prescribed sites. Same result as the functions below, without Jacobians; in these rows only.
void add_point_element(const ElementView& element, std::span<const int32_t> blocks,
                       std::span<const Vec3> extra_gradient, const RowRange& rows, std::span<double> gradient,
                       BlockMatrix& hessian);

/// Adds J^T g of a site.
void add_mapped_gradient(const SiteJacobian& jacobian, const Vec3& g, std::span<double> gradient);

/// Adds J^T g of an element and its part of the moment sums. extra_gradient is added to the point gradients
/// for the gradient only (empty: none).
void add_mapped_gradients(const ElementView& element, std::span<const SiteJacobian> jacobians,
                          std::span<const Vec3> extra_gradient, std::span<double> gradient,
                          std::span<Mat3> body_moment);

/// Adds J^T H J of an element. Blocks of embedded sites go to `pairs`, which has to be scattered after the
/// last element. Where all sites are of bodies or points, LaneCongruence is faster.
void add_mapped_hessian(const ElementView& element, std::span<const int32_t> sites,
                        std::span<const SiteJacobian> jacobians, BlockMatrix& hessian, SitePairs& pairs);

}  // namespace stark
