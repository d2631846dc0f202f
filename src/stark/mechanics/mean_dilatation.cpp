// See mean_dilatation.h.
#include <stark/mechanics/mean_dilatation.h>

#include <algorithm>
#include <array>
#include <cmath>

#include <stark/base/error.h>
#include <stark/mechanics/lane_of.h>

namespace stark {

using symbolic::kLanes;
using symbolic::Order;

namespace {

constexpr int kUnknowns = 12;  ///< of the law: F, the volume ratio, two without meaning
constexpr int kMaxPoints = 27, kMaxModes = 4;

/// Place of (r, c), r <= c, in an upper triangle of n x n.
constexpr int upper(int n, int r, int c) { return r * n - r * (r - 1) / 2 + c - r; }

}  // namespace

MeanDilatation::MeanDilatation(std::shared_ptr<const Potential> ratio, int points_per_element, int modes)
    : ratio_(std::move(ratio)), points_(points_per_element), modes_(modes) {
  STARK_CHECK(ratio_->point_count() == 3 && points_ <= kMaxPoints && modes_ <= kMaxModes);
}

void MeanDilatation::resize(int64_t element_count) {
  shapes_.assign(static_cast<size_t>(element_count) * points_ * modes_, 0.0);
  forms_.assign(static_cast<size_t>(element_count) * modes_ * 4, 0.0);
  weights_.assign(static_cast<size_t>(element_count) * points_, 0.0);
}

void MeanDilatation::set_geometry(int64_t element, std::span<const double> weights,
                                  std::span<const Vec3> positions) {
  std::copy(weights.begin(), weights.end(), weights_.begin() + element * points_);
  double volume = 0.0;
  Vec3 centre;
  for (int q = 0; q < points_; ++q) volume += weights[q];
  for (int q = 0; q < points_; ++q) centre += positions[q] * (weights[q] / volume);
  double* shapes = shapes_.data() + element * points_ * modes_;
  double* forms = forms_.data() + element * modes_ * 4;
  for (int k = 0; k < modes_; ++k) {  // Gram and Schmidt
    for (int q = 0; q < points_; ++q)
      shapes[q * modes_ + k] = k == 0 ? 1.0 : positions[q][k - 1] - centre[k - 1];
    forms[4 * k] = k == 0 ? 1.0 : -centre[k - 1];
    if (k > 0) forms[4 * k + k] = 1.0;
    for (int j = 0; j < k; ++j) {
      double overlap = 0.0;
      for (int q = 0; q < points_; ++q)
        overlap += weights[q] * shapes[q * modes_ + j] * shapes[q * modes_ + k];
      for (int q = 0; q < points_; ++q) shapes[q * modes_ + k] -= overlap * shapes[q * modes_ + j];
      for (int i = 0; i < 4; ++i) forms[4 * k + i] -= overlap * forms[4 * j + i];
    }
    double square = 0.0;
    for (int q = 0; q < points_; ++q) square += weights[q] * shapes[q * modes_ + k] * shapes[q * modes_ + k];
    for (int q = 0; q < points_; ++q) shapes[q * modes_ + k] /= std::sqrt(square);
    for (int i = 0; i < 4; ++i) forms[4 * k + i] /= std::sqrt(square);
  }
}

void MeanDilatation::average(int64_t element, std::span<double> ratios) const {
  std::array<double, kMaxModes> amplitudes{};
  for (int q = 0; q < points_; ++q)
    for (int k = 0; k < modes_; ++k)
      amplitudes[k] += weight(element, q) * modes_at(element, q)[k] * ratios[q];
  for (int q = 0; q < points_; ++q) {
    ratios[q] = 0.0;
    for (int k = 0; k < modes_; ++k) ratios[q] += modes_at(element, q)[k] * amplitudes[k];
  }
}

std::array<double, 4> MeanDilatation::linear_form(int64_t element, std::span<const double> ratios) const {
  std::array<double, 4> form{};
  for (int k = 0; k < modes_; ++k) {
    double amplitude = 0.0;
    for (int q = 0; q < points_; ++q) amplitude += weight(element, q) * modes_at(element, q)[k] * ratios[q];
    for (int i = 0; i < 4; ++i) form[i] += amplitude * forms_[(element * modes_ + k) * 4 + i];
  }
  return form;
}

int MeanDilatation::output_count(Order order) {
  return order == Order::Energy ? 1 : order == Order::Gradient ? kRow : kOutputs;
}

void MeanDilatation::evaluate(const PotentialBatch& law, Order order, const double* F, int64_t begin,
                              int64_t end, double* out) const {
  const symbolic::Kernel& ratio_kernel = ratio_->kernel();
  const int ratio_outputs = ratio_kernel.output_count(order), outputs = output_count(order);
  const int law_outputs = law.potential().kernel().output_count(order);
  const int64_t blocks = end - begin;
  thread_local AlignedVector<double> ratio, unknowns, energies;
  ratio.resize(static_cast<size_t>(blocks) * ratio_outputs * kLanes);
  unknowns.assign(static_cast<size_t>(blocks) * kUnknowns * kLanes, 0.0);
  energies.resize(static_cast<size_t>(blocks) * law_outputs * kLanes);
  const double nothing = 0.0;  // no inputs but F
  ratio_kernel.evaluate(order, F, &nothing, &nothing, ratio.data(), blocks);
  for (int64_t block = 0; block < blocks; ++block)
    std::copy_n(F + block * 9 * kLanes, 9 * kLanes, unknowns.data() + block * kUnknowns * kLanes);
  const int64_t first = begin * kLanes / points_;
  const int64_t last = std::min(end * kLanes, law.size()) / points_;
  std::array<double, kMaxPoints> ratios{};
  for (int64_t e = first; e < last; ++e) {
    const int64_t lane = (e - first) * points_;
    for (int q = 0; q < points_; ++q) ratios[q] = *lane_of(ratio.data(), ratio_outputs, lane + q);
    average(e, std::span(ratios).first(points_));
    for (int q = 0; q < points_; ++q) lane_of(unknowns.data(), kUnknowns, lane + q)[9 * kLanes] = ratios[q];
  }
  const int64_t filled = (last - first) * points_;
  for (int64_t lane = filled; lane < blocks * kLanes; ++lane)  // padding repeats the last point
    lane_of(unknowns.data(), kUnknowns, lane)[9 * kLanes] =
        lane_of(unknowns.data(), kUnknowns, filled - 1)[9 * kLanes];
  law.evaluate_lanes(order, unknowns.data(), begin, end, energies.data());
  if (order == Order::Energy) {
    std::copy(energies.begin(), energies.end(), out);
    return;
  }
  for (int64_t e = first; e < last; ++e)
    merge(e, (e - first) * points_, order, energies.data(), ratio.data(), out);
  for (int64_t lane = filled; lane < blocks * kLanes; ++lane)
    for (int k = 0; k < outputs; ++k)
      lane_of(out, outputs, lane)[k * kLanes] = lane_of(out, outputs, filled - 1)[k * kLanes];
}

void MeanDilatation::merge(int64_t element, int64_t first, Order order, const double* law,
                           const double* ratio, double* out) const {
  const int law_outputs = order == Order::Gradient ? 1 + kUnknowns : 1 + kUnknowns + upper(kUnknowns, 12, 12);
  const int ratio_outputs = order == Order::Gradient ? 10 : 55, outputs = output_count(order);
  std::array<double, kMaxModes> pressures{};  // by mode
  for (int q = 0; q < points_; ++q)
    for (int k = 0; k < modes_; ++k)
      pressures[k] += modes_at(element, q)[k] * lane_of(law, law_outputs, first + q)[10 * kLanes];
  for (int q = 0; q < points_; ++q) {
    const double* l = lane_of(law, law_outputs, first + q);
    const double* r = lane_of(ratio, ratio_outputs, first + q);
    double* o = lane_of(out, outputs, first + q);
    double pressure = 0.0;  // derivative of the energy of the element in det F of the point
    for (int k = 0; k < modes_; ++k) pressure += modes_at(element, q)[k] * pressures[k];
    pressure *= weight(element, q);
    o[0] = l[0];
    for (int i = 0; i < 9; ++i) o[(1 + i) * kLanes] = l[(1 + i) * kLanes] + pressure * r[(1 + i) * kLanes];
    if (order == Order::Gradient) continue;
    const double* H = l + (1 + kUnknowns) * kLanes;
    o[kRow * kLanes] = H[upper(kUnknowns, 9, 9) * kLanes];
    for (int i = 0; i < 9; ++i) {
      o[(kRow + 1 + i) * kLanes] = H[upper(kUnknowns, i, 9) * kLanes];
      o[(kCofactors + i) * kLanes] = r[(1 + i) * kLanes];
      for (int j = i; j < 9; ++j)
        o[(kUpper + upper(9, i, j)) * kLanes] =
            H[upper(kUnknowns, i, j) * kLanes] + pressure * r[(10 + upper(9, i, j)) * kLanes];
    }
  }
}

}  // namespace stark
