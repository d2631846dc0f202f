// Barrier stiffness of a pair from the mass and the elastic stiffness of what it separates, frozen within a
// step.
//
// A unit force along the contact normal moves the pair apart by the compliance s = sum_b j_b^T H_bb^-1 j_b,
// with H_bb the diagonal blocks of inertia and elasticity at the start of the step and j_b the normal seen by
// block b. 1/s is the effective stiffness of the pair; prescribed sides add no compliance, and a pair that is
// prescribed altogether has no barrier. kappa is such that
// the barrier's curvature at half the contact distance, kappa b''(d_hat/2), is `factor` / s. [theory eq. 18;
// Ando 2024, "elasticity-inclusive"]
//
// Masses say nothing of what is stacked on them: where the loads of the last step ask for more, kappa of all
// contacts between two bodies grows until the largest load is carried at a tenth of the contact distance.
// [theory eq. 18a]
#pragma once

#include <map>
#include <span>
#include <vector>

#include <stark/contact/contact_set.h>
#include <stark/mechanics/kinematic_map.h>

namespace stark {

/// Pairs of bodies whose load asks for stiffer barriers, and by how much. One factor for all contacts of two
/// bodies: were each to follow its own load, all would be carried at the same gap and nothing would hold the
/// distribution of a load over many contacts. Part of the State; sorted, without doubles.
struct LoadMemory {
  std::vector<int64_t> bodies;  ///< code() of a contact
  std::vector<double> factor;   ///< > 1

  static int64_t code(const Contact& contact);
  double find(int64_t code) const;       ///< 1 when nothing is known
  void add(int64_t code, double value);  ///< codes in ascending order; values up to 1 need not be known
};

class PairStiffness {
 public:
  explicit PairStiffness(const KinematicMap& map) : map_(map) {}

  /// Forgets all pairs. diagonal: [block_count] diagonal blocks of the Hessian without contact [N/m, N m].
  void begin_step(const Configuration& configuration, std::span<const Mat3> diagonal, double factor,
                  LoadMemory memory = {});

  /// Sets the stiffness of each contact: the frozen one, or a new one from the contact's normal at x; 0 where
  /// all vertices are prescribed, whose motion no force changes. mesh: see PairKey.
  void assign(const SurfaceMesh& mesh, std::span<const Vec3> x, std::vector<Contact>& contacts);

  /// What the loads at the end of a step ask of the next one. forces: on side A of each contact [N]; share:
  /// of the full time step.
  LoadMemory end_step(const std::vector<Contact>& contacts, std::span<const Vec3> forces,
                      double share = 1.0) const;

  /// The factors of this step, raised to what contacts ask that were met on the way of a step which failed:
  /// an impact that presses a contact to a gap where Newton's method finds nothing any more.
  LoadMemory raised(const std::vector<Contact>& contacts, std::span<const Vec3> forces) const;

  /// Compliance of the pair along its normal [m/N], 0 where its nearest points are prescribed.
  double compliance(const Contact& contact, std::span<const Vec3> x) const;

 private:
  /// Of a difference of points, sum of weights times sites, along n.
  double compliance(std::span<const int32_t> sites, std::span<const double> weights, const Vec3& n) const;
  /// Stiffness by inertia and elasticity [N/m].
  double natural(const SurfaceMesh& mesh, const Contact& contact, std::span<const Vec3> x) const;
  /// Largest factor that the loads ask for, by bodies: of those in contact, 0 for others that have one.
  std::map<int64_t, double> wanted(const std::vector<Contact>& contacts, std::span<const Vec3> forces) const;

  const KinematicMap& map_;
  Configuration configuration_;
  std::vector<Mat3> inverse_diagonal_;
  double factor_ = 0.0;
  LoadMemory memory_;
  std::map<PairKey, double> frozen_;  ///< by inertia and elasticity
};

}  // namespace stark
