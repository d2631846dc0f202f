// Virials of elements: from their forces to their stress, whatever their energy is.
#pragma once

#include <span>
#include <vector>

#include <stark/base/math.h>
#include <stark/mechanics/quadrature_batch.h>

namespace stark {

/// Of each element, the sum over its points of the derivative of its energy by the position, times the
/// position: sum_a dE/dx_a (x) x_a [J]. Of an element whose rotation is free it equals the integral of the
/// Cauchy stress over its volume, since both are the virtual work of x -> (1 + t H) x. [theory eq. 10r]
std::vector<Mat3> element_virials(const PotentialBatch& batch, std::span<const Vec3> x);
std::vector<Mat3> element_virials(const QuadratureBatch& batch, std::span<const Vec3> x);

/// Volumes of the elements with nodes at x [m^3]: that of the parts that quadrature points stand for.
std::vector<double> element_volumes(const QuadratureBatch& batch, std::span<const Vec3> x);

}  // namespace stark
