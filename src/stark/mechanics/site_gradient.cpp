#include <stark/mechanics/site_gradient.h>

#include <stark/mechanics/lane_of.h>
#include <stark/mechanics/lane_outputs.h>

namespace stark {

using symbolic::kLanes;
using symbolic::Order;

namespace {

/// Sum of energies, which are all that there is of each element.
double sum_of(std::span<const double> energies, int64_t count) {
  double total = 0.0;
  for (int64_t e = 0; e < count; ++e) total += energies[e];
  return total;
}

void add_elements(const PotentialBatch& batch, std::span<const Vec3> x, double factor,
                  std::span<Vec3> gradient, ThreadPool* pool) {
  const int outputs = batch.potential().kernel().output_count(Order::Gradient);
  const AlignedVector<double> out = lane_outputs(batch, Order::Gradient, x, pool);
  for (int64_t e = 0; e < batch.size(); ++e) {
    const double* g = lane_of(out.data(), outputs, e) + kLanes;  // after the energy
    for (const int32_t site : batch.stencil(e)) {
      gradient[site] += Vec3{g[0], g[kLanes], g[2 * kLanes]} * factor;
      g += 3 * kLanes;
    }
  }
}

}  // namespace

void add_site_gradient(const PotentialBatch& batch, std::span<const Vec3> x, double factor,
                       std::span<Vec3> gradient, ThreadPool* pool) {
  if (batch.potential().totals()) return add_elements(batch.touching(x), x, factor, gradient, pool);
  add_elements(batch, x, factor, gradient, pool);
}

void add_site_gradient(const QuadratureBatch& batch, std::span<const Vec3> x, double factor,
                       std::span<Vec3> gradient, ThreadPool* pool) {
  const int outputs = batch.output_count(Order::Gradient);
  const AlignedVector<double> out = lane_outputs(batch, Order::Gradient, x, pool);
  for (int64_t e = 0; e < batch.size(); ++e)
    for (int q = 0; q < batch.points_per_element(); ++q) {
      const double* P = lane_of(out.data(), outputs, e * batch.points_per_element() + q) + kLanes;
      const double* G = batch.gradients(e, q);
      for (int a = 0; a < batch.node_count(); ++a)
        for (int j = 0; j < 3; ++j) {
          const double* column = P + static_cast<int64_t>(3 * j) * kLanes;
          gradient[batch.stencil(e)[a]] += Vec3{column[0], column[kLanes], column[2 * kLanes]} *
                                           (factor * G[j * batch.padded_nodes() + a]);
        }
    }
}

double total_energy(const PotentialBatch& batch, std::span<const Vec3> x, ThreadPool* pool) {
  if (batch.potential().totals()) return batch.touching(x).plane().energy;
  return sum_of(lane_outputs(batch, Order::Energy, x, pool), batch.size());
}

double total_energy(const QuadratureBatch& batch, std::span<const Vec3> x, ThreadPool* pool) {
  return sum_of(lane_outputs(batch, Order::Energy, x, pool), batch.law().size());
}

}  // namespace stark
