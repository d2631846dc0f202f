// Energy and momentum of a step, from the state and what has acted (step phase 8).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <stark/mechanics/site_sums.h>
#include <stark/sim/step/step_motion.h>
#include <stark/sim/step/step_report.h>

namespace stark {

bool depends_on_time(const Potential& potential);

class StepLedger : private StepPart {
 public:
  StepLedger(const StepContext& context, const StepMotion& motion);

  /// Stored energies of the current state with sites at x; contact is left at zero.
  EnergyLedger stored_energies(std::span<const Vec3> x);
  /// What the elements of one elastic batch store, 0 for others.
  double stored_energy(ModelBatch& batch, std::span<const Vec3> x);
  double stored_energy(ModelQuadrature& elements, std::span<const Vec3> x);
  /// Virials of the same energy [J], which are the volumes of elements times their mean Cauchy stress.
  std::vector<Mat3> stored_virials(ModelBatch& batch, std::span<const Vec3> x);
  std::vector<Mat3> stored_virials(ModelQuadrature& elements, std::span<const Vec3> x);
  /// Stored energies at the start of a step whose times the batches have, for balance().
  EnergyLedger begin(std::span<const Vec3> x);
  /// Completes the ledger of the step that has just been committed; `before`: stored energies at its start,
  /// where joints had the coordinates `coordinates_before`.
  EnergyLedger balance(const EnergyLedger& before, std::span<const double> coordinates_before);
  Momentum momentum() const;
  /// Derivative of all energies of the step by each site at its end [N]: with the forces of what prescribes
  /// sites it adds up to zero.
  std::vector<Vec3> site_gradient() const;

 private:
  /// Motions of the step to x that forces at its end work along: chords, of directions of bodies tangents.
  std::vector<Vec3> way_to(std::span<const Vec3> x) const;
  double prescribed_work();
  /// With the internal variables that the batches have.
  double elastic_energy(std::span<const Vec3> x);
  double damping_work();
  /// Of forces in energies of users that follow from no stored energy, as of wind.
  double driven_work();
  /// What energies of the time gain as it goes on in the step, with sites at x, where it starts.
  /// [theory eq. 27b]
  double work_of_time(std::span<const Vec3> x);
  double friction_work(std::span<const Vec3> x);
  /// What the internal variables of all elements have dissipated; batches have those at the start of the
  /// step.
  double flow_dissipation();
  template <typename Batch>
  double flow_dissipation(Batch& batch);
  template <typename Elements>
  std::vector<Mat3> stored_virials_of(Elements& elements, std::span<const Vec3> x);

  const StepMotion& motion_;
  std::vector<int32_t> centres_;                           ///< sites at the centres of bodies
  std::vector<int32_t> axes_;                              ///< the first of the three axes of each body, ...
  std::vector<int32_t> directions_;                        ///< ... and all directions of bodies
  std::vector<int32_t> energies_of_users_;                 ///< their batches
  std::vector<int32_t> timed_batches_, timed_quadrature_;  ///< whose energy depends on the time
  double work_of_time_ = 0.0;                              ///< of the step under way [J]
  std::vector<int32_t> carried_;  ///< sites whose motion is prescribed in part, ascending
  SiteSums friction_;             ///< of the last friction_work() [N]
};

}  // namespace stark
