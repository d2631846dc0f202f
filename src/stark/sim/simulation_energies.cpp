// Simulation: the user's energies. Checks before the first step, live values, energies and forces.
#include <cmath>

#include <stark/base/error.h>
#include <stark/sim/model/internal_variables.h>
#include <stark/sim/simulation.h>
#include <stark/sim/simulation_parts.h>

namespace stark {

using symbolic::Order;

namespace {

constexpr double kInvarianceTolerance = 1e-8;  ///< of the sum of point forces over the largest one

std::string owner_text(const EnergyDescription& energy) { return "energy '" + energy.name + "'"; }

std::string positions_text(const PotentialBatch& batch, int64_t element, std::span<const Vec3> x) {
  std::string text;
  for (const int32_t site : batch.stencil(element)) {
    if (!text.empty()) text += ", ";
    text += to_text(FieldValue(x[site]));
  }
  return text + " m";
}

/// Position of the first number that is not finite, -1 if all are.
int first_not_finite(std::span<const double> values) {
  for (size_t k = 0; k < values.size(); ++k)
    if (!std::isfinite(values[k])) return static_cast<int>(k);
  return -1;
}

}  // namespace

void Simulation::check_energies() {
  const std::vector<Vec3> x = site_positions();
  for (int32_t k = 0; k < static_cast<int32_t>(scene_.energies().size()); ++k) {
    PotentialBatch& batch = energies_.batches[model_->energy_batch({k})].batch;
    batch.set_previous(x);
    batch.set_time(settings_.time.step, settings_.time.step);
    const std::vector<double> values = batch.evaluate(Order::Hessian, x);
    const size_t outputs = values.size() / batch.size();
    const int n = 3 * batch.point_count();
    for (int64_t e = 0; e < batch.size(); ++e) {
      const std::span<const double> element(values.data() + e * outputs, outputs);
      const std::string where = owner_text(scene_.energies()[k]) + ": element " + std::to_string(e);
      if (const int bad = first_not_finite(element); bad >= 0)
        throw InvalidArgument(where + " has " +
                              (bad == 0   ? "an energy of "
                               : bad <= n ? "a force of "
                                          : "a stiffness of ") +
                              to_text(element[bad]) + " at time 0, with its points at " +
                              positions_text(batch, e, x) +
                              ": must be finite; look for a square root, logarithm or division of zero, and "
                              "guard it with where/select "
                              "or a small offset");
      if (batch.potential().is_translation_invariant()) check_invariance(batch, element, where);
    }
    check_start(batch, x, owner_text(scene_.energies()[k]));
  }
}

// Steps need an energy of the time at their end alone, but the ledger what it stores at the start, too.
void Simulation::check_start(PotentialBatch& batch, std::span<const Vec3> x, const std::string& owner) const {
  if (!depends_on_time(batch.potential())) return;
  batch.set_time(settings_.time.step, 0.0);
  const std::vector<double> energies = batch.evaluate(Order::Energy, x);
  if (const int bad = first_not_finite(energies); bad >= 0)
    throw InvalidArgument(owner + ": element " + std::to_string(bad) + " has an energy of " +
                          to_text(energies[bad]) +
                          " when the time is 0: must be finite; look for a division by the time or its "
                          "logarithm, and guard it with a small offset");
}

void Simulation::check_invariance(const PotentialBatch& batch, std::span<const double> element,
                                  const std::string& where) const {
  Vec3 sum;
  double largest = 0.0;
  for (int p = 0; p < batch.point_count(); ++p)
    for (int c = 0; c < 3; ++c) {
      sum[c] += element[1 + 3 * p + c];
      largest = std::max(largest, std::fabs(element[1 + 3 * p + c]));
    }
  if (max_abs(sum) > kInvarianceTolerance * largest)
    throw InvalidArgument(where +
                          " is declared invariant under translation, but the forces on its points sum to " +
                          to_text(FieldValue(sum)) +
                          " N: must sum to zero; set translation_invariant = false in its definition");
}

namespace {

/// What the value was when the energy was added; throws for unknown names.
const FieldValues& added_value(const EnergyDescription& energy, const std::string& name) {
  if (const auto found = energy.values.find(name); found != energy.values.end()) return found->second;
  std::vector<std::string> names;
  for (const auto& [known, value] : energy.values) names.push_back(known);
  throw InvalidArgument(owner_text(energy) + ": unknown value '" + name + "'" +
                        nearest_name_hint(name, names) + ": must be an input of the formula");
}

}  // namespace

void Simulation::set_energy_value(EnergyId id, const std::string& name, std::span<const double> values) {
  const EnergyDescription& energy = scene_.energy(id);
  // Not from the formula: recording it again would cost more than the step of a small scene.
  const FieldValues& added = added_value(energy, name);
  ModelBatch& elements = energies_.batches[model_->energy_batch(id)];
  PotentialBatch& batch = elements.batch;
  const bool per_element = added.per_element;
  const size_t expected = added.values.size();
  const std::string owner = owner_text(energy) + ": '" + name + "'";
  if (values.size() != expected)
    throw InvalidArgument(owner + ": got " + std::to_string(values.size()) + " numbers: must be " +
                          std::to_string(expected) +
                          (per_element ? ", as it was given one value for each element when it was added"
                                       : ", as it was given one value for all elements when it was added"));
  if (const int bad = first_not_finite(values); bad >= 0)
    throw InvalidArgument(owner + ": number " + std::to_string(bad) + " is " + to_text(values[bad]) +
                          ": must be finite; check where it is computed");
  const std::vector<Vec3>& x = site_positions();
  const InternalOfState stored(energies_, state_.internal_variable);
  const double before = parts_->ledger.stored_energy(elements, x);
  if (per_element) {
    const int field = batch.field_index(name);
    const size_t width = expected / static_cast<size_t>(batch.size());
    for (int64_t e = 0; e < batch.size(); ++e) batch.set(field, e, values.subspan(e * width, width));
  } else {
    batch.set_uniform(name, values);
  }
  parts_->placing.add_energy(parts_->ledger.stored_energy(elements, x) - before);
}

std::vector<double> Simulation::element_energies(EnergyId id) const {
  scene_.energy(id);
  if (energies_.batches[model_->energy_batch(id)].batch.potential().totals())
    return {energy_plane(id).energy};
  return energies_.batches[model_->energy_batch(id)].batch.evaluate(Order::Energy, site_positions());
}

TouchingPlane Simulation::energy_plane(EnergyId id) const {
  scene_.energy(id);
  return energies_.batches[model_->energy_batch(id)].batch.touching(site_positions()).plane();
}

std::vector<Vec3> Simulation::element_forces(EnergyId id) const {
  scene_.energy(id);
  const PotentialBatch& batch = energies_.batches[model_->energy_batch(id)].batch;
  const std::vector<double> values = batch.evaluate(Order::Gradient, site_positions());
  const int points = batch.point_count();
  std::vector<Vec3> forces(batch.size() * points);
  for (size_t k = 0; k < forces.size(); ++k) {
    const size_t first = (k / points) * (1 + 3 * points) + 1 + 3 * (k % points);
    forces[k] = Vec3{values[first], values[first + 1], values[first + 2]} * -1.0;
  }
  return forces;
}

}  // namespace stark
