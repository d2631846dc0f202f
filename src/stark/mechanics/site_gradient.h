// Gradients of energies with respect to the positions of sites, prescribed ones included: forces, and the
// work they do (step phase 8).
#pragma once

#include <span>

#include <stark/base/thread_pool.h>
#include <stark/mechanics/quadrature_batch.h>

namespace stark {

/// Adds the derivative of the batch's energy with respect to every site at x, times `factor` [N]. pool: for
/// large batches; the sums are the same without.
void add_site_gradient(const PotentialBatch& batch, std::span<const Vec3> x, double factor,
                       std::span<Vec3> gradient, ThreadPool* pool = nullptr);
void add_site_gradient(const QuadratureBatch& batch, std::span<const Vec3> x, double factor,
                       std::span<Vec3> gradient, ThreadPool* pool = nullptr);

/// Sum of the batch's energies at x [J].
double total_energy(const PotentialBatch& batch, std::span<const Vec3> x, ThreadPool* pool = nullptr);
double total_energy(const QuadratureBatch& batch, std::span<const Vec3> x, ThreadPool* pool = nullptr);

}  // namespace stark
