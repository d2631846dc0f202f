// See quadrature_batch.h.
#include <stark/mechanics/quadrature_batch.h>

#include <algorithm>
#include <numeric>

#include <stark/base/error.h>

namespace stark {

using symbolic::kLanes;
using symbolic::Order;

QuadratureBatch::QuadratureBatch(std::shared_ptr<const Potential> law, int node_count, int points_per_element)
    : node_count_(node_count), points_(points_per_element), law_(std::move(law)) {
  STARK_CHECK(law_.point_count() == 3 && !law_.potential().totals());
}

QuadratureBatch::QuadratureBatch(std::shared_ptr<const Potential> law, int node_count, int points_per_element,
                                 MeanDilatation dilatation)
    : node_count_(node_count),
      points_(points_per_element),
      law_(std::move(law)),
      dilatation_(std::move(dilatation)) {
  STARK_CHECK(law_.point_count() == 4 && !law_.potential().totals());
}

void QuadratureBatch::resize(std::span<const int32_t> stencils) {
  stencils_.assign(stencils.begin(), stencils.end());
  size_ = static_cast<int64_t>(stencils.size()) / node_count_;
  gradients_.assign(static_cast<size_t>(size_) * points_ * 3 * padded_nodes(), 0.0);
  if (dilatation_) dilatation_->resize(size_);
  std::vector<int32_t> columns(static_cast<size_t>(law_.point_count() * size_ * points_));
  std::iota(columns.begin(), columns.end(), 0);
  law_.resize(columns);
}

void QuadratureBatch::set_geometry(int64_t element, std::span<const Vec3> gradients,
                                   std::span<const double> weights, std::span<const Vec3> positions) {
  if (dilatation_) dilatation_->set_geometry(element, weights, positions);
  const int weight = law_.field_index(kQuadratureWeight);
  for (int q = 0; q < points_; ++q) {
    double* G = gradients_.data() + (element * points_ + q) * 3 * padded_nodes();
    for (int a = 0; a < node_count_; ++a)
      for (int j = 0; j < 3; ++j) G[j * padded_nodes() + a] = gradients[q * node_count_ + a][j];
    law_.set(weight, element * points_ + q, {&weights[q], 1});
  }
}

void QuadratureBatch::set_values(const ParameterValues& values) {
  ParameterValues at_points = values;
  for (auto& [name, field] : at_points) {
    if (!field.per_element) continue;
    const std::vector<double> of_elements = std::move(field.values);
    const int64_t width = static_cast<int64_t>(of_elements.size()) / std::max<int64_t>(1, size_);
    field.values.clear();
    for (int64_t e = 0; e < size_; ++e)
      for (int q = 0; q < points_; ++q)
        field.values.insert(field.values.end(), of_elements.begin() + e * width,
                            of_elements.begin() + (e + 1) * width);
  }
  stark::set_values(law_, at_points);
}

Vec3 QuadratureBatch::column(int64_t element, int point, int j, std::span<const Vec3> x) const {
  const double* G = gradients(element, point) + j * padded_nodes();
  const auto nodes = stencil(element);
  Vec3 sum;
  for (int a = 0; a < node_count_; ++a) sum += x[nodes[a]] * G[a];
  return sum;
}

std::vector<Vec3> QuadratureBatch::columns(std::span<const Vec3> x) const {
  std::vector<Vec3> columns;
  columns.reserve(static_cast<size_t>(law_.point_count() * size_ * points_));
  std::vector<double> ratios(points_);
  for (int64_t e = 0; e < size_; ++e) {
    const size_t first = columns.size();
    for (int q = 0; q < points_; ++q) {
      for (int j = 0; j < 3; ++j) columns.push_back(column(e, q, j, x));
      if (!dilatation_) continue;
      const Vec3* F = columns.data() + columns.size() - 3;
      ratios[q] = dot(cross(F[0], F[1]), F[2]);
      columns.push_back({});
    }
    if (!dilatation_) continue;
    dilatation_->average(e, ratios);
    for (int q = 0; q < points_; ++q) columns[first + 4 * q + 3] = {ratios[q], 0.0, 0.0};
  }
  return columns;
}

std::vector<Vec3> QuadratureBatch::columns_for(ElementField::Source source, std::span<const Vec3> x) const {
  const auto& fields = law_.potential().element_fields();
  if (std::ranges::none_of(fields, [&](const ElementField& f) { return f.source == source; })) return {};
  return columns(x);
}

std::vector<double> QuadratureBatch::updated_internal(std::span<const Vec3> x) const {
  if (law_.potential().internal_width() == 0) return {};
  return law_.updated_internal(columns(x));
}

std::vector<double> QuadratureBatch::energies(std::span<const Vec3> x) const {
  return law_.evaluate(Order::Energy, columns(x));
}

std::vector<double> QuadratureBatch::volume_ratios(std::span<const Vec3> x) const {
  std::vector<double> forms;
  if (!dilatation_) return forms;
  const std::vector<Vec3> at_points = columns(x);
  std::vector<double> ratios(points_);
  for (int64_t e = 0; e < size_; ++e) {
    for (int q = 0; q < points_; ++q) ratios[q] = at_points[4 * (e * points_ + q) + 3].x;
    const auto form = dilatation_->linear_form(e, ratios);
    forms.insert(forms.end(), form.begin(), form.end());
  }
  return forms;
}

void QuadratureBatch::set_previous(std::span<const Vec3> x_prev) {
  const std::vector<Vec3> columns = columns_for(ElementField::Source::Previous, x_prev);
  if (!columns.empty()) law_.set_previous(columns);
}

void QuadratureBatch::set_beyond(std::span<const Vec3> x_beyond) {
  const std::vector<Vec3> columns = columns_for(ElementField::Source::Beyond, x_beyond);
  if (!columns.empty()) law_.set_beyond(columns);
}

void QuadratureBatch::evaluate(Order order, std::span<const Vec3> x, int64_t first, int64_t last,
                               double* out) const {
  thread_local AlignedVector<double> unknowns;
  unknowns.resize(static_cast<size_t>(points_) * 9 * kLanes);
  const int outputs = output_count(order);
  for (int64_t group = first; group < last; ++group) {
    const int64_t begin = block_of_group(group), end = block_of_group(group + 1);
    for (int64_t lane = 0; lane < (end - begin) * kLanes; ++lane) {
      const int64_t point = std::min(begin * kLanes + lane, law_.size() - 1);
      double* F = unknowns.data() + lane / kLanes * 9 * kLanes + lane % kLanes;
      for (int j = 0; j < 3; ++j) {
        const Vec3 c = column(point / points_, static_cast<int>(point % points_), j, x);
        for (int i = 0; i < 3; ++i) F[(3 * j + i) * kLanes] = c[i];
      }
    }
    double* group_out = out + (begin - block_of_group(first)) * outputs * kLanes;
    if (dilatation_)
      dilatation_->evaluate(law_, order, unknowns.data(), begin, end, group_out);
    else
      law_.evaluate_lanes(order, unknowns.data(), begin, end, group_out);
  }
}

}  // namespace stark
