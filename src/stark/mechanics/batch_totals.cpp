// PotentialBatch: energies of totals. [theory eq. 15h]
#include <algorithm>
#include <array>
#include <cmath>

#include <stark/mechanics/element_view.h>
#include <stark/mechanics/potential_batch.h>
#include <stark/mechanics/total_energy.h>

namespace stark {

using symbolic::kLanes;
using symbolic::Order;

namespace {

/// Part of the energy below which its change is integrated from slopes instead, which round with themselves.
constexpr double kSmallChange = 1e-6;

/// Gauss's quadrature of five points in [0, 1].
constexpr std::array<double, 5> kPlaces{0.046910077030668004, 0.23076534494715845, 0.5, 0.76923465505284155,
                                        0.953089922969332};
constexpr std::array<double, 5> kWeights{0.11846344252809454, 0.23931433524968324, 0.28444444444444444,
                                         0.23931433524968324, 0.11846344252809454};

double dot(std::span<const double> a, std::span<const double> b) {
  double sum = 0.0;
  for (size_t k = 0; k < a.size(); ++k) sum += a[k] * b[k];
  return sum;
}

}  // namespace

AlignedVector<double> PotentialBatch::evaluate_measure(int k, Order order, std::span<const Vec3> x) const {
  const symbolic::Kernel& measure = potential_->totals()->measure(k);
  const int outputs = measure.output_count(order);
  AlignedVector<double> unknowns(static_cast<size_t>(kGroupBlocks) * 3 * point_count() * kLanes),
      out(static_cast<size_t>(block_count()) * outputs * kLanes);
  for (int64_t first = 0; first < block_count(); first += kGroupBlocks) {
    const int64_t last = std::min(first + kGroupBlocks, block_count());
    gather(x, first, last, unknowns.data());
    measure.evaluate(order, unknowns.data(), elements_.data() + first * potential_->element_width() * kLanes,
                     uniforms_.data(), out.data() + first * outputs * kLanes, last - first);
  }
  return out;
}

std::vector<double> PotentialBatch::totals_at(std::span<const Vec3> x) const {
  std::vector<double> totals;
  for (int k = 0; k < potential_->totals()->count(); ++k) {
    const AlignedVector<double> of_elements = evaluate_measure(k, Order::Energy, x);
    double sum = 0.0, lost = 0.0;  // of the terms as well as of the sum [Neumaier 1974]
    for (int64_t e = 0; e < size_; ++e) {
      const double term = of_elements[e], next = sum + term;
      lost += std::fabs(sum) >= std::fabs(term) ? (sum - next) + term : (term - next) + sum;
      sum = next;
    }
    totals.push_back(std::isfinite(sum) ? sum + lost : sum);
  }
  return totals;
}

void PotentialBatch::touch(std::span<const Vec3> x) {
  const TotalEnergy* totals = potential_->totals();
  if (!totals || size_ == 0) return;
  plane_.totals = totals_at(x);
  TotalEnergy::Value value = totals->evaluate(plane_.totals, uniforms_);
  plane_.energy = value.energy;
  plane_.slopes = std::move(value.slopes);
  plane_.curvature = std::move(value.curvature);
  double* const of_plane = uniforms_.data() + potential_->uniform_width();
  std::ranges::copy(plane_.slopes, of_plane);
  of_plane[totals->count()] =
      (plane_.energy - dot(plane_.slopes, plane_.totals)) / static_cast<double>(size_);
}

EnergyDifference PotentialBatch::change_of_totals(std::span<const Vec3> x) const {
  const TotalEnergy& energy = *potential_->totals();
  const std::vector<double> totals = totals_at(x);
  std::vector<double> change(totals.size()), between(totals.size());
  for (size_t k = 0; k < totals.size(); ++k) change[k] = totals[k] - plane_.totals[k];
  const double there = energy.evaluate(totals, uniforms_).energy;
  const double size = std::fabs(plane_.energy) + std::fabs(there);
  EnergyDifference found{.difference = there - plane_.energy, .magnitude = size};
  if (!(std::fabs(found.difference) < kSmallChange * size)) return found;
  found = {};
  for (size_t q = 0; q < kPlaces.size(); ++q) {
    for (size_t k = 0; k < totals.size(); ++k) between[k] = plane_.totals[k] + kPlaces[q] * change[k];
    found.difference += kWeights[q] * dot(energy.evaluate(between, uniforms_).slopes, change);
  }
  for (size_t k = 0; k < totals.size(); ++k)
    found.magnitude += std::fabs(plane_.slopes[k] * plane_.totals[k]);
  return found;
}

void PotentialBatch::add_total_gradient(int k, std::span<const Vec3> x, std::span<Vec3> out) const {
  const AlignedVector<double> lanes = evaluate_measure(k, Order::Gradient, x);
  const int points = point_count(), outputs = 1 + 3 * points;
  for (int64_t e = 0; e < size_; ++e) {
    const ElementView element(lanes.data() + (e / kLanes) * outputs * kLanes, 3 * points,
                              static_cast<int>(e % kLanes));
    for (int p = 0; p < points; ++p) out[stencil(e)[p]] += element.point_gradient(p);
  }
}

}  // namespace stark
