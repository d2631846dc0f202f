// What a time step did: returned by Simulation::step(), complete whether the step succeeded or not (step
// phase 8).
#pragma once

#include <array>
#include <string>
#include <vector>

#include <stark/base/math.h>
#include <stark/base/timer.h>
#include <stark/sim/scene/settings.h>
#include <stark/sim/step/diagnosis.h>
#include <stark/solve/report.h>

namespace stark {

/// Accepted: at the first attempt. Retried: after at least one halving of the time step. Failed: the state is
/// unchanged.
enum class StepStatus : uint8_t { Accepted, Retried, Failed, Interrupted };
template <>
struct EnumNames<StepStatus> {
  static constexpr std::array<std::string_view, 4> kNames{"accepted", "retried", "failed", "interrupted"};
};

/// What is not quite as asked of a step that was accepted all the same.
enum class Caveat : uint8_t {
  RoundOff,            ///< the tolerances are not met: energies could not be told apart any more
  OldFriction,         ///< limits of friction, or forces of joints, are a refresh behind (see failures.md)
  PrescribedOverlap,   ///< scripted bodies go into or through others that are scripted or fixed
  ReleasedOverlap,     ///< bodies that a joint or an attachment has released overlap, without contact so far
  BelowLeastDistance,  ///< surfaces are nearer than contact.min_separation_factor asks
  MisfitLoop,          ///< joints of a closed loop are off by nearly their tolerances, as no motion closes it
};
template <>
struct EnumNames<Caveat> {
  static constexpr std::array<std::string_view, 6> kNames{
      "round_off",        "old_friction",         "prescribed_overlap",
      "released_overlap", "below_least_distance", "misfit_loop"};
};

/// Energies stored at the end of a step and energies that the step turned over [J]. For every step
///   stored(end) - stored(start) = external + actuation + belts + restitution - damping - friction -
///   numerical,
/// where the start is the end of the step before, with what was placed in between.
struct EnergyLedger {
  double kinetic = 0.0;    ///< of all free masses
  double elastic = 0.0;    ///< of elements and of users' energies
  double gravity = 0.0;    ///< of all free masses, zero at the origin
  double contact = 0.0;    ///< barriers, whose stiffness is chosen anew in each step
  double damping = 0.0;    ///< dissipated in the step by material and mass damping
  double friction = 0.0;   ///< dissipated in the step
  double external = 0.0;   ///< work of prescribed parts, of energies that drive and of time in them
  double actuation = 0.0;  ///< work of actuators in the step, springs on coordinates included
  double belts = 0.0;      ///< work of the drives of moving surfaces in the step
  /// Given back in the step by restitution: what impacts before it had taken up, in contact that lost its
  /// stiffness and in numerical dissipation.
  double restitution = 0.0;
  /// Given to what is stored between the step before and this one, by placing bodies (sim/step/placing)
  /// and by new values of energies of the scene.
  double placed = 0.0;
  double numerical = 0.0;  ///< what closes the balance: dissipated by the time integration and by joints

  double stored() const { return kinetic + elastic + gravity + contact; }
};

/// Momentum of all free masses at the end of a step; angular momentum is about the origin of the world.
struct Momentum {
  Vec3 linear;   ///< [N s]
  Vec3 angular;  ///< [N m s]
};

struct StepReport {
  StepStatus status = StepStatus::Accepted;
  std::string message;  ///< empty, or why the step was retried, failed or has caveats, with the remedy
  Diagnosis diagnosis;  ///< of a step that failed
  std::vector<Caveat> caveats;  ///< of a step that was accepted
  int64_t step = 0;             ///< number of this step, from 1
  double time = 0.0;            ///< at its end [s]
  double time_step = 0.0;       ///< [s]
  /// What this step was taken with: implicit Euler, too, where bdf2 has no history.
  Integrator integrator = Integrator::ImplicitEuler;
  /// Share of the increments by contact in the last step that goes on in this one with bdf2. [theory eq. 26e]
  double lasting_contact = 0.0;
  int rejected_steps = 0;  ///< attempts thrown away before this one
  SolveReport solve;       ///< of the accepted attempt; counters include the rejected ones
  int64_t contact_count = 0;
  double min_distance = 0.0;  ///< of surfaces within their contact distances [m], infinity without any
  /// Largest difference of a friction limit in this step from mu times the normal force at its end [N].
  double friction_residual = 0.0;
  EnergyLedger energy;
  /// Bodies that were placed between the step before and this one, by number; sorted.
  std::vector<int32_t> placed{};
  /// Of the barriers at the start of the step, with the stiffness of this step [J]: what EnergyLedger takes
  /// for stored(start), where the step before reported the same contacts with its own stiffness.
  double contact_energy_at_start = 0.0;
  /// In the bristles of friction at the start of the step, with the limits of this step [J]. Friction gives
  /// back no more: energy.friction >= -bristle_energy_at_start with implicit Euler.
  double bristle_energy_at_start = 0.0;
  Momentum momentum;
  std::array<double, static_cast<size_t>(Phase::kCount)> phases{};  ///< seconds by Phase

  bool failed() const { return status == StepStatus::Failed || status == StepStatus::Interrupted; }
  /// "step 12  t 0.4 s  h 33.3 ms  6 iterations  132 contacts  residual 1.2e-06 N".
  std::string brief() const;
};

/// A step that is under way, seen between two Newton iterations.
struct StepProgress {
  int64_t step = 0;           ///< number of the step, from 1
  int attempt = 1;            ///< from 1; what fails is tried again with a shorter time step
  int iterations = 0;         ///< Newton iterations, those of earlier attempts included
  SolveReport solve;          ///< of this attempt so far
  int64_t contact_count = 0;  ///< pairs within their contact distance, where the energy was evaluated last
};

}  // namespace stark
