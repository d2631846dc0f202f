// Simulation: stresses of elements and what their materials remember.
#include <algorithm>
#include <iterator>

#include <stark/mechanics/element_virial.h>
#include <stark/sim/model/internal_variables.h>
#include <stark/sim/model/stored_energy.h>
#include <stark/sim/simulation.h>
#include <stark/sim/simulation_parts.h>

namespace stark {

namespace {

double triangle_area(const Vec3& a, const Vec3& b, const Vec3& c) { return 0.5 * norm(cross(b - a, c - a)); }

double tetrahedron_volume(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  return dot(cross(b - a, c - a), d - a) / 6.0;
}

/// Areas of triangles [m^2], volumes of solid elements [m^3], with sites at x.
std::vector<double> element_sizes(const PotentialBatch& batch, std::span<const Vec3> x) {
  std::vector<double> sizes(static_cast<size_t>(batch.size()));
  for (int64_t e = 0; e < batch.size(); ++e) {
    const auto at = [&](int a) { return x[batch.stencil(e)[a]]; };
    sizes[e] = batch.point_count() == 3 ? triangle_area(at(0), at(1), at(2))
                                        : tetrahedron_volume(at(0), at(1), at(2), at(3));
  }
  return sizes;
}

std::vector<double> element_sizes(const QuadratureBatch& batch, std::span<const Vec3> x) {
  return element_volumes(batch, x);
}

/// visit(elements) for what the triangles or elements of a body or layer are stretched against.
template <typename Visit>
void visit_stressed(Energies& energies, const std::string& owner, const Visit& visit) {
  for (ModelBatch& elements : energies.batches)
    if (elements.carries_stress && elements.owner == owner) visit(elements);
  for (ModelQuadrature& elements : energies.quadrature)
    if (elements.body == owner) visit(elements);
}

int points_per_element(const PotentialBatch&) { return 1; }
int points_per_element(const QuadratureBatch& batch) { return batch.points_per_element(); }

}  // namespace

std::vector<Mat3> Simulation::mean_stresses(BodyId body) {
  const std::vector<Vec3> x = site_positions();
  const InternalOfState now(energies_, state_.internal_variable);
  std::vector<Mat3> stresses;
  std::vector<double> sizes;
  visit_stressed(energies_, scene_.name(body), [&](auto& elements) {
    const std::vector<Mat3> virials = parts_->ledger.stored_virials(elements, x);
    sizes = element_sizes(elements.batch, x);
    stresses.resize(virials.size());
    for (size_t e = 0; e < virials.size(); ++e) stresses[e] += virials[e];
  });
  for (size_t e = 0; e < stresses.size(); ++e) stresses[e] = stresses[e] * (1.0 / sizes[e]);
  return stresses;
}

std::vector<double> Simulation::volume_ratios(BodyId body) const {
  const std::vector<Vec3> x = site_positions();
  for (const ModelQuadrature& elements : energies_.quadrature)
    if (elements.body == scene_.name(body)) return elements.batch.volume_ratios(x);
  return {};
}

std::vector<InternalVariable> Simulation::internal_variables(BodyId body) {
  const InternalOfState now(energies_, state_.internal_variable);
  std::vector<InternalVariable> found;
  visit_stressed(energies_, scene_.name(body), [&](const auto& elements) {
    const PotentialBatch& law = law_of(elements.batch);
    std::ranges::move(
        stark::internal_variables(law.potential(), points_per_element(elements.batch), law.internal_values()),
        std::back_inserter(found));
  });
  return found;
}

}  // namespace stark
