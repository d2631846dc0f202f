// Barrier stiffness of a pair from the mass and the elastic stiffness of what it separates, frozen within a
// step.
//
// A unit force along the contact normal moves the pair apart by the compliance s = sum_b j_b^T H_bb^-1 j_b,
// with H_bb the diagonal blocks of inertia and elasticity at the start of the step and j_b the normal seen by
// block b. 1/s is the effective stiffness of the pair; prescribed sides add no compliance. kappa is such that
// the barrier's curvature at half the contact distance, kappa b''(d_hat/2), is `factor` / s. [theory eq. 18;
// Ando 2024, "elasticity-inclusive"]
#pragma once

#include <map>
#include <span>
#include <vector>

#include <stark/contact/contact_set.h>
#include <stark/mechanics/kinematic_map.h>

namespace stark {

class PairStiffness {
 public:
  explicit PairStiffness(const KinematicMap& map) : map_(map) {}

  /// Forgets all pairs. diagonal: [block_count] diagonal blocks of the Hessian without contact [N/m, N m].
  void begin_step(const Configuration& configuration, std::span<const Mat3> diagonal, double factor);

  /// Sets the stiffness of each contact: the frozen one, or a new one from the contact's normal at x.
  void assign(std::span<const Vec3> x, std::vector<Contact>& contacts);

  /// Compliance of the pair along its normal [m/N].
  double compliance(const Contact& contact, std::span<const Vec3> x) const;

 private:
  const KinematicMap& map_;
  Configuration configuration_;
  std::vector<Mat3> inverse_diagonal_;
  double factor_ = 0.0;
  std::map<PairKey, double> frozen_;
};

}  // namespace stark
