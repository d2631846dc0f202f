// Friction of the contacts of a configuration, with normal force, tangent plane and closest points frozen
// there and displacements measured from the start of the step (step phase 2, refreshed when the iteration has
// converged).
#pragma once

#include <functional>
#include <map>

#include <stark/contact/contact_set.h>

namespace stark {

/// Coulomb's coefficient of a pair of groups.
using FrictionTable = std::function<double(int32_t group_a, int32_t group_b)>;

class FrictionSet {
 public:
  /// potentials: friction of 2, 3 and 4 points.
  FrictionSet(const std::array<std::shared_ptr<const Potential>, 3>& potentials, double stick_velocity);

  /// Freezes friction at the contacts, with the forces on their sides A; x_reference are the site
  /// positions that displacements over `duration` are measured from. Returns the largest change of mu lambda
  /// of a pair [N], 0 when all are within 0.1 % of the largest of before.
  double reset(const std::vector<Contact>& contacts, std::span<const Vec3> forces,
               const FrictionTable& coefficient, std::span<const Vec3> x_reference, double duration);

  std::vector<const PotentialBatch*> batches() const;
  /// Forces on the sides A of the pairs at site positions x [N].
  std::map<PairKey, Vec3> forces(std::span<const Vec3> x) const;
  bool empty() const { return strengths_.empty(); }

  /// Energies at x are compared with those at the last remember(), element by element.
  void remember(std::span<const Vec3> x);
  EnergyDifference energy_difference(std::span<const Vec3> x) const;

 private:
  std::vector<double> energies(std::span<const Vec3> x) const;

  std::vector<PotentialBatch> batches_;               ///< of 2, 3 and 4 points
  std::array<std::vector<PairKey>, 3> keys_;          ///< of their elements
  std::array<std::vector<int8_t>, 3> side_a_counts_;  ///< points of side A of their elements
  std::map<PairKey, double> strengths_;               ///< mu lambda [N]
  std::vector<double> remembered_;
};

}  // namespace stark
