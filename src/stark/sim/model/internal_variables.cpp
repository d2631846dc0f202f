// See internal_variables.h.
#include <stark/sim/model/internal_variables.h>

#include <algorithm>
#include <cmath>

#include <stark/base/error.h>

namespace stark {

namespace {

void append(std::vector<double>& all, const std::vector<double>& values) {
  all.insert(all.end(), values.begin(), values.end());
}

/// What rounding may raise a stored energy by, over its size.
constexpr double kEnergyRounding = 1e-12;

/// Internal variables after they have flown for t from some values, at the strains and rates of the start.
template <typename Batch>
std::vector<double> flowed(Batch& batch, const FlowStart& start, double t, const std::vector<double>& from) {
  std::vector<Vec3> before(start.x.begin(), start.x.end());
  for (size_t i = 0; i < before.size(); ++i) before[i] -= start.v[i] * t;
  batch.set_previous(before);
  batch.set_time(t, start.time);
  batch.set_internal(from);
  return batch.updated_internal(start.x);
}

template <typename Batch>
std::vector<double> stored(Batch& batch, const FlowStart& start, const std::vector<double>& values) {
  batch.set_previous(start.x);
  batch.set_time(start.full_step, start.time);
  batch.set_internal(values);
  return batch.energies(start.x);
}

template <typename Batch>
void flow_for_half(Batch& batch, const FlowStart& start, double h) {
  const std::vector<double> from = batch.internal_values();
  const std::vector<double> half = flowed(batch, start, 0.5 * h, from);
  const std::vector<double> whole = flowed(batch, start, h, from);
  std::vector<double> values = flowed(batch, start, 0.5 * h, half);
  for (size_t k = 0; k < values.size(); ++k) values[k] = half[k] + (values[k] - whole[k]);
  // Nothing is gained in a flow: where the correction says so, steps are too long for it.
  const std::vector<double> before = stored(batch, start, from), after = stored(batch, start, values);
  const auto width = static_cast<size_t>(potential_of(batch).internal_width());
  for (size_t e = 0; e < before.size(); ++e) {
    const double rounding = kEnergyRounding * (std::fabs(before[e]) + std::fabs(after[e]));
    if (after[e] - before[e] <= rounding) continue;
    std::copy_n(half.begin() + e * width, width, values.begin() + e * width);
  }
  batch.set_internal(values);
}

}  // namespace

std::vector<InternalVariable> internal_variables(const Potential& potential, int points,
                                                 std::span<const double> values) {
  std::vector<InternalVariable> found;
  const size_t row = static_cast<size_t>(potential.internal_width());
  size_t first = 0;
  for (const ElementField& field : potential.element_fields()) {
    if (field.source != ElementField::Source::Internal) continue;
    InternalVariable& variable = found.emplace_back();
    variable = {field.name, field.unit, field.doc, field.width, points, {}};
    for (size_t at = first; at < values.size(); at += row)
      variable.values.insert(variable.values.end(), values.begin() + at, values.begin() + at + field.width);
    first += field.width;
  }
  return found;
}

std::vector<double> internal_values(const Energies& energies) {
  std::vector<double> all;
  for (const ModelBatch& batch : energies.batches) append(all, batch.batch.internal_values());
  for (const ModelQuadrature& elements : energies.quadrature)
    append(all, elements.batch.law().internal_values());
  return all;
}

void set_internal(Energies& energies, std::span<const double> values) {
  if (values.empty()) return;
  const auto take = [&](const PotentialBatch& batch) {
    const auto count = static_cast<size_t>(batch.size() * batch.potential().internal_width());
    STARK_CHECK(count <= values.size());
    const std::span<const double> own = values.first(count);
    values = values.subspan(count);
    return own;
  };
  for (ModelBatch& batch : energies.batches) batch.batch.set_internal(take(batch.batch));
  for (ModelQuadrature& elements : energies.quadrature)
    elements.batch.set_internal(take(elements.batch.law()));
}

InternalOfState::InternalOfState(Energies& energies, std::span<const double> values)
    : energies_(energies), before_(internal_values(energies)) {
  set_internal(energies_, values);
}

std::vector<double> updated_internal(const Energies& energies, std::span<const Vec3> x) {
  std::vector<double> all;
  for (const ModelBatch& batch : energies.batches) append(all, batch.batch.updated_internal(x));
  for (const ModelQuadrature& elements : energies.quadrature) append(all, elements.batch.updated_internal(x));
  return all;
}

bool has_flow(const Energies& energies) {
  const auto flows = [](const auto& part) { return potential_of(part.batch).flows_at_a_rate(); };
  return std::ranges::any_of(energies.batches, flows) || std::ranges::any_of(energies.quadrature, flows);
}

void flow_for_half(Energies& energies, const FlowStart& start, double h) {
  for (ModelBatch& part : energies.batches)
    if (potential_of(part.batch).flows_at_a_rate()) flow_for_half(part.batch, start, h);
  for (ModelQuadrature& part : energies.quadrature)
    if (potential_of(part.batch).flows_at_a_rate()) flow_for_half(part.batch, start, h);
}

}  // namespace stark
