#include <stark/contact/friction_set.h>

#include <algorithm>
#include <cmath>

namespace stark {

using symbolic::kLanes;
using symbolic::Order;

namespace {

/// Relative change of the strengths below which friction counts as up to date.
constexpr double kStrengthTolerance = 1e-3;

}  // namespace

FrictionSet::FrictionSet(const std::array<std::shared_ptr<const Potential>, 3>& potentials,
                         double stick_velocity) {
  for (const auto& potential : potentials) {
    batches_.emplace_back(potential);
    batches_.back().set_uniform("stick_velocity", stick_velocity);
  }
}

double FrictionSet::reset(const std::vector<Contact>& contacts, std::span<const Vec3> forces,
                          const FrictionTable& coefficient, std::span<const Vec3> x_reference,
                          double duration) {
  std::map<PairKey, double> strengths;
  std::array<std::vector<int32_t>, 3> stencils;
  std::array<std::vector<size_t>, 3> members;
  for (size_t c = 0; c < contacts.size(); ++c) {
    const Contact& contact = contacts[c];
    const double strength = coefficient(contact.group_a, contact.group_b) * norm(forces[c]);
    if (!(strength > 0.0)) continue;
    strengths.emplace(contact.key, strength);
    auto& stencil = stencils[contact.point_count - 2];
    stencil.insert(stencil.end(), contact.sites.begin(), contact.sites.begin() + contact.point_count);
    members[contact.point_count - 2].push_back(c);
  }
  for (int k = 0; k < 3; ++k) {
    PotentialBatch& batch = batches_[k];
    batch.resize(stencils[k]);
    batch.set_previous(x_reference);
    batch.set_time(duration, 0.0);
    keys_[k].clear();
    side_a_counts_[k].clear();
    for (const size_t c : members[k]) {
      keys_[k].push_back(contacts[c].key);
      side_a_counts_[k].push_back(contacts[c].side_a_count);
    }
    const int strength = batch.field_index("strength"), normal = batch.field_index("normal");
    for (int64_t e = 0; e < batch.size(); ++e) {
      const size_t c = members[k][e];
      const Vec3 n = normalized(forces[c]);
      batch.set(strength, e, {&strengths.at(contacts[c].key), 1});
      batch.set(normal, e, {&n.x, 3});
      for (int p = 0; p < k + 2; ++p) batch.set("weight" + std::to_string(p), e, contacts[c].weights[p]);
    }
  }
  double change = 0.0, largest = 0.0;
  for (const auto& [key, strength] : strengths) {
    largest = std::max(largest, strength);
    const auto old = strengths_.find(key);
    change = std::max(change, std::fabs(strength - (old == strengths_.end() ? 0.0 : old->second)));
  }
  for (const auto& [key, strength] : strengths_)
    if (!strengths.contains(key)) change = std::max(change, strength);
  strengths_ = std::move(strengths);
  return change > kStrengthTolerance * largest ? change : 0.0;
}

std::vector<const PotentialBatch*> FrictionSet::batches() const {
  std::vector<const PotentialBatch*> result;
  for (const PotentialBatch& batch : batches_)
    if (batch.size() > 0) result.push_back(&batch);
  return result;
}

std::map<PairKey, Vec3> FrictionSet::forces(std::span<const Vec3> x) const {
  std::map<PairKey, Vec3> forces;
  for (int k = 0; k < 3; ++k) {
    const std::vector<double> values = batches_[k].evaluate(Order::Gradient, x);
    const int outputs = 1 + 3 * batches_[k].point_count();
    for (size_t e = 0; e < keys_[k].size(); ++e)
      for (int p = 0; p < side_a_counts_[k][e]; ++p) {
        const double* g = values.data() + e * outputs + 1 + 3 * p;
        forces[keys_[k][e]] -= Vec3{g[0], g[1], g[2]};
      }
  }
  return forces;
}

std::vector<double> FrictionSet::energies(std::span<const Vec3> x) const {
  std::vector<double> energies;
  AlignedVector<double> out;
  for (const PotentialBatch& batch : batches_) {
    out.resize(batch.block_count() * kLanes);
    batch.evaluate(Order::Energy, x, 0, batch.block_count(), out.data());
    energies.insert(energies.end(), out.begin(), out.begin() + batch.size());
  }
  return energies;
}

void FrictionSet::remember(std::span<const Vec3> x) { remembered_ = energies(x); }

EnergyDifference FrictionSet::energy_difference(std::span<const Vec3> x) const {
  EnergyDifference total;
  const std::vector<double> now = energies(x);
  for (size_t e = 0; e < now.size(); ++e) {
    total.difference += now[e] - remembered_[e];
    total.magnitude += std::fabs(remembered_[e]);
  }
  return total;
}

}  // namespace stark
