// See internal_variables.h.
#include <stark/sim/internal_variables.h>

#include <algorithm>

#include <stark/base/error.h>

namespace stark {

namespace {

void append(std::vector<double>& all, const std::vector<double>& values) {
  all.insert(all.end(), values.begin(), values.end());
}

void refuse_rates(const Potential& potential, const std::string& owner) {
  const bool has_rates = std::ranges::any_of(
      potential.uniform_fields(), [](const UniformField& field) { return field.name == "time_step"; });
  if (potential.internal_width() > 0 && has_rates)
    throw InvalidArgument(
        "'" + owner + "': the energy '" + potential.name() +
        "' has internal variables and uses the time step: time.integrator must not be bdf2; "
        "use implicit_euler");
}

}  // namespace

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

void refuse_rates_of_internal(const Energies& energies) {
  for (const ModelBatch& batch : energies.batches) refuse_rates(batch.batch.potential(), batch.owner);
  for (const ModelQuadrature& elements : energies.quadrature)
    refuse_rates(elements.batch.law().potential(), elements.body);
}

}  // namespace stark
