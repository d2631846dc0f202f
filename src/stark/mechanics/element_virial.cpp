// See element_virial.h.
#include <stark/mechanics/element_virial.h>

#include <stark/base/error.h>
#include <stark/mechanics/lane_of.h>

namespace stark {

using symbolic::kLanes;
using symbolic::Order;

std::vector<Mat3> element_virials(const PotentialBatch& batch, std::span<const Vec3> x) {
  STARK_CHECK(batch.potential().totals() == nullptr);
  const std::vector<double> values = batch.evaluate(Order::Gradient, x);
  const int points = batch.point_count();
  std::vector<Mat3> virials(static_cast<size_t>(batch.size()));
  for (int64_t e = 0; e < batch.size(); ++e) {
    const double* gradient = values.data() + e * (1 + 3 * points) + 1;
    const auto stencil = batch.stencil(e);
    // The gradients sum to zero: positions from the first point on lose no digits far from the origin.
    for (int a = 1; a < points; ++a)
      virials[e] += outer(Vec3{gradient[3 * a], gradient[3 * a + 1], gradient[3 * a + 2]},
                          x[stencil[a]] - x[stencil[0]]);
  }
  return virials;
}

std::vector<Mat3> element_virials(const QuadratureBatch& batch, std::span<const Vec3> x) {
  const int outputs = batch.output_count(Order::Gradient);
  AlignedVector<double> out(batch.law().block_count() * outputs * kLanes);
  batch.evaluate(Order::Gradient, x, 0, batch.group_count(), out.data());
  std::vector<Mat3> virials(static_cast<size_t>(batch.size()));
  for (int64_t e = 0; e < batch.size(); ++e)
    for (int q = 0; q < batch.points_per_element(); ++q) {
      const double* P = lane_of(out.data(), outputs, e * batch.points_per_element() + q) + kLanes;
      for (int j = 0; j < 3; ++j)
        virials[e] += outer(Vec3{P[3 * j * kLanes], P[(3 * j + 1) * kLanes], P[(3 * j + 2) * kLanes]},
                            batch.column(e, q, j, x));
    }
  return virials;
}

std::vector<double> element_volumes(const QuadratureBatch& batch, std::span<const Vec3> x) {
  const int weight = batch.law().field_index(kQuadratureWeight);
  std::vector<double> volumes(static_cast<size_t>(batch.size()));
  for (int64_t e = 0; e < batch.size(); ++e)
    for (int q = 0; q < batch.points_per_element(); ++q) {
      const Vec3 F[] = {batch.column(e, q, 0, x), batch.column(e, q, 1, x), batch.column(e, q, 2, x)};
      volumes[e] +=
          batch.law().get(weight, e * batch.points_per_element() + q) * dot(cross(F[0], F[1]), F[2]);
    }
  return volumes;
}

}  // namespace stark
