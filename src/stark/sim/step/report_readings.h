// What can be read of the reports of steps, row by row (base/reading.h).
#pragma once

#include <tuple>

#include <stark/base/reading.h>
#include <stark/sim/step/step_report.h>

namespace stark {

template <>
struct Readings<BodyVertices> {
  static constexpr std::tuple kAll{reading<&BodyVertices::body>("body"),
                                   reading<&BodyVertices::vertices>("vertices")};
};

template <>
struct Readings<UnbalancedForce> {
  using F = UnbalancedForce;
  static constexpr std::tuple kAll{reading<&F::at, &BodyVertices::body>("body"),
                                   reading<&F::at, &BodyVertices::vertices>("vertices"),
                                   reading<&F::position>("position"), reading<&F::force>("force"),
                                   reading<&F::acceleration>("acceleration")};
};

template <>
struct Readings<NarrowGap> {
  static constexpr std::tuple kAll{reading<&NarrowGap::a>("a"), reading<&NarrowGap::b>("b"),
                                   reading<&NarrowGap::distance>("distance"),
                                   reading<&NarrowGap::contact_distance>("contact_distance")};
};

template <>
struct Readings<BlockingPair> {
  static constexpr std::tuple kAll{reading<&BlockingPair::a>("a"), reading<&BlockingPair::b>("b"),
                                   reading<&BlockingPair::fraction>("fraction")};
};

template <>
struct Readings<StrainedElement> {
  using E = StrainedElement;
  static constexpr std::tuple kAll{
      reading<&E::at, &BodyVertices::body>("body"), reading<&E::at, &BodyVertices::vertices>("vertices"),
      reading<&E::element>("element"), reading<&E::stretch>("stretch"), reading<&E::size>("size")};
};

template <>
struct Readings<Attempt> {
  static constexpr std::tuple kAll{reading<&Attempt::time_step>("time_step"),
                                   reading<&Attempt::status>("status"),
                                   reading<&Attempt::iterations>("iterations")};
};

template <>
struct Readings<Diagnosis> {
  using D = Diagnosis;
  using E = StepEvidence;
  static constexpr std::tuple kAll{
      reading<&D::cause>(
          "cause",
          "'blocked_motion', 'overconstrained_pins', 'contradicting_joints', 'inverted_element', "
          "'not_finite', 'singular_energy', 'rough_energy', 'tolerance_below_round_off', 'no_equilibrium', "
          "'thickness_overlap', 'unit_mistake', 'crushing_load', 'overload', 'detour', 'singular_system', "
          "'stiffness_contrast', 'iteration_budget', 'time_budget', 'unknown'."),
      reading<&D::finding>("finding", "What was found, with names, numbers and units."),
      reading<&D::remedy>("remedy", "What to change."),
      reading<&D::bodies>("bodies", "Bodies involved: \"cloth 'towel'\"."),
      reading<&D::evidence, &E::forces>(
          "forces",
          "Largest unbalanced forces: body, vertices, position [m], force [N], acceleration [m/s^2]."),
      reading<&D::evidence, &E::gaps>(
          "gaps", "Narrowest gaps where the last attempt ended: a, b, distance [m], contact_distance [m]."),
      reading<&D::evidence, &E::start_gaps>("start_gaps", "Narrowest gaps at the start of the step."),
      reading<&D::evidence, &E::blocking>(
          "blocking",
          "The parts that limit the last Newton step: a, b, fraction of it; None when nothing does."),
      reading<&D::evidence, &E::elements>(
          "elements",
          "Elements farthest from rest: body, vertices, element, stretch of an edge, size (of volume, area "
          "or length, below 0 where inverted), both over those at rest."),
      reading<&D::evidence, &E::pushing>("pushing",
                                         "Bodies with scripted or pinned parts that move in the step."),
      reading<&D::evidence, &E::force_rounding>("force_rounding",
                                                "Unbalanced force that rounding of the positions makes [N]."),
      reading<&D::evidence, &E::acceleration_rounding>("acceleration_rounding",
                                                       "The same over the mass of its node or body [m/s^2]."),
      reading<&D::evidence, &E::stiffness_ratio>("stiffness_ratio",
                                                 "Of the stiffest to the softest node or body."),
      reading<&D::evidence, &E::unit_suspicions>("unit_suspicions",
                                                 "Numbers that look as if in other units."),
      reading<&D::evidence, &E::attempts>("attempts",
                                          "Each attempt at the step: time_step [s], status, iterations.")};
};

template <>
struct Readings<EnergyLedger> {
  using E = EnergyLedger;
  static constexpr std::tuple kAll{reading<&E::kinetic>("kinetic"),   reading<&E::elastic>("elastic"),
                                   reading<&E::gravity>("gravity"),   reading<&E::contact>("contact"),
                                   reading<&E::damping>("damping"),   reading<&E::friction>("friction"),
                                   reading<&E::external>("external"), reading<&E::actuation>("actuation"),
                                   reading<&E::belts>("belts"),       reading<&E::restitution>("restitution"),
                                   reading<&E::placed>("placed"),     reading<&E::numerical>("numerical")};
};

template <>
struct Readings<StepReport> {
  using R = StepReport;
  using S = SolveReport;
  static constexpr std::tuple kAll{
      reading<&R::status>(
          "status",
          "'accepted', 'retried' (after halvings of the step), 'failed' (state unchanged) or 'interrupted'."),
      reading<&R::message>("message",
                           "Why the step was retried, failed or has caveats, and what to do; else empty."),
      reading<&R::step>("step", "Number of the step, from 1."),
      reading<&R::time>("time", "Time at the end of the step [s]."),
      reading<&R::time_step>("time_step", "Length of the step that was taken [s]."),
      reading<&R::integrator>(
          "integrator",
          "What the step was taken with: 'implicit_euler', 'bdf2' or 'quasistatic'. Steps of bdf2 are "
          "'implicit_euler' at the start and where steps more than double."),
      reading<&R::lasting_contact>(
          "lasting_contact",
          "Share of what contact did in the last step that goes on in this one, with 'bdf2' (theory eq. "
          "26e): 1 "
          "where steps resolve contact, 0 where bodies hit each other, and with other integrators."),
      reading<&R::solve, &S::iterations>("newton_iterations", "Newton iterations of the step."),
      reading<&R::solve, &S::linear_iterations>(
          "linear_iterations", "Iterations of conjugate gradients in all Newton iterations."),
      reading<&R::solve, &S::factorizations>("factorizations",
                                             "Factorisations of the matrix in all Newton iterations."),
      reading<&R::solve, &S::backtracks>("line_search_backtracks",
                                         "How often the line search halved a Newton step."),
      reading<&R::rejected_steps>("rejected_steps",
                                  "Attempts thrown away before this one, each with a longer step."),
      reading<&R::solve, &S::status>(
          "solve_status",
          "How the last attempt ended: 'converged', 'round_off', 'max_iterations', 'blocked', ..."),
      reading<&R::solve, &S::is_at_rounding>(
          "at_rounding",
          "Whether it converged because all that is left is rounding: tolerances ask for less."),
      reading<&R::solve, &S::residual>("residual", "Largest unbalanced force [N]."),
      reading<&R::solve, &S::acceleration>("acceleration", "Largest M^-1 residual [m/s^2]."),
      reading<&R::solve, &S::last_motion>(
          "last_motion",
          "Largest motion of a vertex in the last Newton step, taken in full [m]; over the time step "
          "it is what newton.step_tolerance bounds."),
      reading<&R::placed>("placed",
                          "Numbers of the bodies that were placed between the step before and this one."),
      reading<&R::contact_count>("contact_count", "Pairs of surfaces within their contact distance."),
      reading<&R::min_distance>("min_distance",
                                "Smallest distance of an active contact [m], inf without any."),
      reading<&R::friction_residual>(
          "friction_residual",
          "Largest difference of a friction limit in this step from mu times the normal force at its end "
          "[N]."),
      reading<&R::energy>(
          "energy",
          "Stored at the end of the step: kinetic, elastic, gravity, contact [J]. Turned over by the "
          "step: damping, friction (dissipated), external (work of scripted and pinned parts and of energies "
          "that drive or depend on the time), "
          "actuation (work of actuators), belts (work of the drives of moving surfaces), placed (given by "
          "placing bodies before the step), numerical (what closes the balance) [J]."),
      reading<&R::contact_energy_at_start>(
          "contact_energy_at_start",
          "Of the barriers at the start of the step, with the stiffness of this step [J]."),
      reading<&R::bristle_energy_at_start>(
          "bristle_energy_at_start",
          "Stored by sticking friction at the start of the step, with the limits of this step [J]: what "
          "friction can give back in it."),
      reading<&R::momentum, &Momentum::linear>("momentum", "Momentum of all free masses (3,) [N s]."),
      reading<&R::momentum, &Momentum::angular>(
          "angular_momentum", "Angular momentum of all free masses about the origin (3,) [N m s]."),
      reading<&R::caveats>(
          "caveats",
          "What is not quite as asked of a step that was accepted: 'round_off' (the tolerances are "
          "not met, forces are rounding), 'old_friction' (friction or joints are a refresh behind), "
          "'prescribed_overlap', 'released_overlap', 'below_least_distance', 'misfit_loop'; "
          "docs/failures.md explains them, and `message` has names and remedies.")};
};

template <>
struct Readings<StepProgress> {
  using P = StepProgress;
  using S = SolveReport;
  static constexpr std::tuple kAll{
      reading<&P::step>("step", "Number of the step, from 1."),
      reading<&P::attempt>("attempt", "From 1; what fails is tried again with a shorter time step."),
      reading<&P::iterations>("iterations", "Newton iterations, those of earlier attempts included."),
      reading<&P::solve, &S::lag_updates>("refreshes", "Refreshes of friction and joints in this attempt."),
      reading<&P::solve, &S::residual>("residual", "Largest unbalanced force [N]."),
      reading<&P::solve, &S::acceleration>("acceleration", "Largest M^-1 residual [m/s^2]."),
      reading<&P::solve, &S::last_motion>(
          "last_motion", "Largest motion of a vertex in the last Newton step, taken in full [m]."),
      reading<&P::solve, &S::last_step_length>("step_length", "Share of it that was taken."),
      reading<&P::solve, &S::last_bound>(
          "bound", "Largest share of it that collision detection and the limit of rotations allowed."),
      reading<&P::solve, &S::last_slope>(
          "slope", "Of the energy along it [J]: a quadratic energy falls by half of that."),
      reading<&P::solve, &S::last_difference>("difference",
                                              "Change of the energy by what was taken of it [J]."),
      reading<&P::solve, &S::backtracks>("backtracks", "Times that steps were halved in this attempt."),
      reading<&P::solve, &S::projected_iterations>(
          "projected_iterations", "Iterations of this attempt whose Hessians were projected."),
      reading<&P::solve, &S::factorizations>("factorizations", "Of matrices, in this attempt."),
      reading<&P::solve, &S::linear_iterations>("linear_iterations",
                                                "Of conjugate gradients, in this attempt."),
      reading<&P::contact_count>("contacts", "Pairs within their contact distance.")};
};

}  // namespace stark
