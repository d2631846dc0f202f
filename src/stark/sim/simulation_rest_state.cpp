// Simulation: new values of rest states, which the next step takes.
#include <algorithm>
#include <cmath>

#include <stark/base/error.h>
#include <stark/sim/model/internal_variables.h>
#include <stark/sim/simulation.h>
#include <stark/sim/simulation_parts.h>

namespace stark {

namespace {

bool has_field(const Potential& potential, const std::string& name) {
  return std::ranges::any_of(potential.element_fields(), [&](const ElementField& field) {
    return field.source == ElementField::Source::Data && field.name == name;
  });
}

}  // namespace

void Simulation::set_rest_state(BodyId body, const std::string& name, std::span<const double> values) {
  const std::string owner = "'" + scene_.name(body) + "': " + name;
  const ParameterValues& given = scene_.rest_state(body);
  const auto found = given.find(name);
  if (found == given.end())
    throw InvalidArgument(owner + ": the body had none when the simulation was made: must be given before");
  if (values.size() != found->second.values.size())
    throw InvalidArgument(owner + ": got " + std::to_string(values.size()) + " numbers: must be " +
                          std::to_string(found->second.values.size()));
  for (size_t k = 0; k < values.size(); ++k)
    if (!std::isfinite(values[k]))
      throw InvalidArgument(owner + ": number " + std::to_string(k) + " is " + to_text(values[k]) +
                            ": must be finite; check where it is computed");
  const ParameterValues changed{{name, {{values.begin(), values.end()}, true}}};
  scene_.check_rest_state(body, changed);
  const std::vector<Vec3> x = site_positions();
  const InternalOfState stored(energies_, state_.internal_variable);
  double before = 0.0, after = 0.0;
  const auto set = [&](auto& elements, const Potential& potential, const std::string& of) {
    if (of != scene_.name(body) || !has_field(potential, name)) return;
    before += parts_->ledger.stored_energy(elements, x);
    set_values(elements.batch, changed);
    after += parts_->ledger.stored_energy(elements, x);
  };
  const auto set_bending = [&](ModelBatch& elements) {
    const PotentialBatch& batch = elements.batch;
    if (elements.owner != scene_.name(body) || !has_field(batch.potential(), name)) return;
    const size_t width = values.size() / scene_.surface_triangles(body).size();
    before += parts_->ledger.stored_energy(elements, x);
    for (size_t e = 0; e < elements.subject.size(); ++e)
      elements.batch.set(name, static_cast<int64_t>(e), values.subspan(width * elements.subject[e], width));
    after += parts_->ledger.stored_energy(elements, x);
  };
  for (ModelBatch& elements : energies_.batches)
    if (elements.is_inertia() || elements.subject.empty())
      set(elements, elements.batch.potential(), elements.owner);
    else
      set_bending(elements);
  for (ModelQuadrature& elements : energies_.quadrature)
    set(elements, elements.batch.law().potential(), elements.body);
  parts_->placing.add_energy(after - before);
}

}  // namespace stark
