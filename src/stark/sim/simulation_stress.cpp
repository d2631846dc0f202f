// Simulation: stresses of elements and what their materials remember.
#include <stark/mechanics/element_virial.h>
#include <stark/sim/internal_variables.h>
#include <stark/sim/simulation.h>
#include <stark/sim/simulation_parts.h>

namespace stark {

namespace {

double triangle_area(const Vec3& a, const Vec3& b, const Vec3& c) { return 0.5 * norm(cross(b - a, c - a)); }

double tetrahedron_volume(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  return dot(cross(b - a, c - a), d - a) / 6.0;
}

/// Areas of triangles [m^2], volumes of tetrahedra [m^3], with sites at x.
std::vector<double> element_sizes(const PotentialBatch& batch, std::span<const Vec3> x) {
  std::vector<double> sizes(static_cast<size_t>(batch.size()));
  for (int64_t e = 0; e < batch.size(); ++e) {
    const auto at = [&](int a) { return x[batch.stencil(e)[a]]; };
    sizes[e] = batch.point_count() == 3 ? triangle_area(at(0), at(1), at(2))
                                        : tetrahedron_volume(at(0), at(1), at(2), at(3));
  }
  return sizes;
}

}  // namespace

std::vector<Mat3> Simulation::mean_stresses(BodyId body) {
  const std::string& name = scene_.name(body);
  const std::vector<Vec3> x = site_positions();
  const InternalOfState now(energies_, state_.internal_variable);
  std::vector<Mat3> stresses;
  std::vector<double> sizes;
  const auto add = [&](const std::vector<Mat3>& virials) {
    stresses.resize(virials.size());
    for (size_t e = 0; e < virials.size(); ++e) stresses[e] += virials[e];
  };
  for (ModelBatch& elements : energies_.batches) {
    if (!elements.carries_stress || elements.owner != name) continue;
    sizes = element_sizes(elements.batch, x);
    add(parts_->ledger.stored_virials(elements, x));
  }
  for (ModelQuadrature& elements : energies_.quadrature) {
    if (elements.body != name) continue;
    sizes = element_volumes(elements.batch, x);
    add(parts_->ledger.stored_virials(elements, x));
  }
  for (size_t e = 0; e < stresses.size(); ++e) stresses[e] = stresses[e] * (1.0 / sizes[e]);
  return stresses;
}

std::vector<InternalVariable> Simulation::internal_variables(BodyId body) {
  const std::string& name = scene_.name(body);
  const InternalOfState now(energies_, state_.internal_variable);
  std::vector<InternalVariable> found;
  const auto add = [&](const PotentialBatch& law, int points) {
    std::vector<InternalVariable> own =
        stark::internal_variables(law.potential(), points, law.internal_values());
    found.insert(found.end(), std::make_move_iterator(own.begin()), std::make_move_iterator(own.end()));
  };
  for (const ModelBatch& elements : energies_.batches)
    if (elements.carries_stress && elements.owner == name) add(elements.batch, 1);
  for (const ModelQuadrature& elements : energies_.quadrature)
    if (elements.body == name) add(elements.batch.law(), elements.batch.points_per_element());
  return found;
}

}  // namespace stark
