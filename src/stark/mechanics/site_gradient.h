// Gradients of energies with respect to the positions of sites, prescribed ones included: forces, and the
// work they do (step phase 8).
#pragma once

#include <span>

#include <stark/mechanics/quadrature_batch.h>

namespace stark {

/// Adds the derivative of the batch's energy with respect to every site at x, times `factor` [N].
void add_site_gradient(const PotentialBatch& batch, std::span<const Vec3> x, double factor,
                       std::span<Vec3> gradient);
void add_site_gradient(const QuadratureBatch& batch, std::span<const Vec3> x, double factor,
                       std::span<Vec3> gradient);

/// Sum of the batch's energies at x [J].
double total_energy(const PotentialBatch& batch, std::span<const Vec3> x);
double total_energy(const QuadratureBatch& batch, std::span<const Vec3> x);

}  // namespace stark
