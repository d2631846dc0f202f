// Why a time step failed: a named cause, the bodies and vertices that it is about, the numbers behind it and
// what to change. judge() reads the evidence that step_evidence.h collects; nothing here looks at a solver.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <stark/base/math.h>
#include <stark/base/settings.h>
#include <stark/sim/scene/settings.h>
#include <stark/solve/report.h>

namespace stark {

/// In the order in which they are looked for: what is certain first, what is merely likely later.
enum class FailureCause : uint8_t {
  None,                    ///< nothing failed
  Interrupted,             ///< by the user
  TimeBudget,              ///< newton.max_seconds is used up
  ContradictingJoints,     ///< joints or attachments that cannot hold all at once
  BlockedMotion,           ///< scripted bodies or pins press something against an obstacle
  OverconstrainedPins,     ///< prescribed vertices invert or overstretch what is between them
  InvertedElement,         ///< an element turned inside out, whose law has no energy there
  NotFinite,               ///< an energy or its derivatives are not finite
  SingularEnergy,          ///< an energy of the user's that has no bound where its points are
  RoughEnergy,             ///< an energy of the user's with a kink or a jump where its points are
  ToleranceBelowRoundOff,  ///< the tolerances ask for more than rounding of the forces allows
  NoEquilibrium,           ///< a quasistatic step without anything that holds the bodies
  ThicknessOverlap,        ///< bodies that start well within their contact distances
  UnitMistake,             ///< numbers that look as if given in other units
  CrushingLoad,            ///< forces press bodies together harder than contact can carry
  Overload,                ///< forces that joints do not hold against, or too strong for what they move
  Detour,                  ///< bodies would change places within the step
  SingularSystem,          ///< the linear system could not be solved
  StiffnessContrast,       ///< stiffnesses too far apart for double precision
  IterationBudget,         ///< newton.max_iterations is used up, with nothing wrong in sight
  Unknown,
};
template <>
struct EnumNames<FailureCause> {
  static constexpr std::array<std::string_view, 21> kNames{"none",
                                                           "interrupted",
                                                           "time_budget",
                                                           "contradicting_joints",
                                                           "blocked_motion",
                                                           "overconstrained_pins",
                                                           "inverted_element",
                                                           "not_finite",
                                                           "singular_energy",
                                                           "rough_energy",
                                                           "tolerance_below_round_off",
                                                           "no_equilibrium",
                                                           "thickness_overlap",
                                                           "unit_mistake",
                                                           "crushing_load",
                                                           "overload",
                                                           "detour",
                                                           "singular_system",
                                                           "stiffness_contrast",
                                                           "iteration_budget",
                                                           "unknown"};
};

/// Vertices of one body; none for a rigid body as a whole.
struct BodyVertices {
  std::string body;
  std::vector<int32_t> vertices{};
};

/// "cloth 'towel' (vertices 3, 4)".
std::string place_text(const BodyVertices& place);

/// A force that nothing balances, on a vertex or a rigid body.
struct UnbalancedForce {
  BodyVertices at;
  Vec3 position;              ///< [m]
  double force = 0.0;         ///< [N], torques over the radius of the body
  double acceleration = 0.0;  ///< [m/s^2]
};

/// Two parts that are near each other.
struct NarrowGap {
  BodyVertices a, b;
  double distance = 0.0;          ///< [m]
  double contact_distance = 0.0;  ///< [m] within which they push each other away
  double ratio() const { return distance / contact_distance; }
};

/// The two parts that allow a fraction of the last Newton step only, before they would touch.
struct BlockingPair {
  BodyVertices a, b;
  double fraction = 1.0;
};

/// An element far from its rest shape.
struct StrainedElement {
  BodyVertices at;
  int64_t element = 0;
  double stretch = 1.0;        ///< the edge length over that at rest that is farthest from 1
  double size = 1.0;           ///< volume, area or length over that at rest, below 0 where inverted
  bool is_prescribed = false;  ///< all its vertices are pinned
};

/// Two pins of a body that are farther apart than what is between them is long.
struct PinPair {
  BodyVertices pins;
  double distance = 0.0;  ///< [m] at the end of the step
  double length = 0.0;    ///< [m] at rest, along edges
  double stretch() const { return distance / length; }
};

/// An element of a user's energy whose force grows beyond all bounds near where its points are.
struct SteepEnergy {
  BodyVertices at;
  std::string energy;
  double force = 0.0;   ///< [N] the largest on one of its points
  double length = 0.0;  ///< [m] force over stiffness: about the distance to where it has no value
};

/// An energy of the user that is not smooth where its points are, within the last Newton step.
struct RoughEnergy {
  BodyVertices at;
  std::string energy;
  double jump = 0.0;   ///< [J] of the energy; 0 where it has a kink
  double force = 0.0;  ///< [N] jump of the force on a point
};

/// What an actuator does to the body that it accelerates most.
struct StrongActuator {
  std::string name;
  BodyVertices at;
  double acceleration = 0.0;  ///< [m/s^2], of what turns that of its surface
  bool is_turn = false;
  double size = 1.0;  ///< [m] radius of what turns, the size of the scene of what moves
  /// Angle, or motion over the size of the scene, in a step of length h [s].
  double reach(double h) const { return acceleration * h * h / size; }
};

/// What one attempt at a step came to.
struct Attempt {
  double time_step = 0.0;  ///< [s]
  SolveStatus status = SolveStatus::Converged;
  int iterations = 0;
};

/// What can be seen where the last attempt ended. Lists are sorted, the worst first, and short.
struct StepEvidence {
  SolveReport solve;
  double time_step = 0.0;  ///< [s] of the last attempt
  bool is_first_step = false;
  bool prescribed_arrived = true;    ///< prescribed parts have got where they were to go
  std::vector<std::string> pushing;  ///< prescribed bodies and pinned ones that still had to move
  /// Something is between prescribed parts, or between one and something fixed; else it could go along.
  bool is_between = true;
  std::vector<UnbalancedForce> forces;
  std::vector<NarrowGap> gaps;        ///< where the attempt ended
  std::vector<NarrowGap> start_gaps;  ///< where the step started
  std::optional<BlockingPair> blocking;
  std::vector<StrainedElement> elements;
  std::optional<PinPair> pins;             ///< the pair that stretches its body most
  std::optional<BlockingPair> in_the_way;  ///< of an attempt that went around something
  std::vector<BodyVertices> not_finite;    ///< where energies are not finite, and their owners
  std::string not_finite_update;           ///< of the first one, if it is an internal variable's
  std::optional<SteepEnergy> steep;        ///< the steepest
  std::optional<RoughEnergy> rough;        ///< the roughest
  std::vector<std::string> acting;         ///< users' energies on what is most out of balance
  std::optional<StrongActuator> actuator;  ///< the strongest
  /// Smallest unbalanced force and acceleration that rounding of the positions lets forces tell apart.
  double force_rounding = 0.0;         ///< [N]
  double acceleration_rounding = 0.0;  ///< [m/s^2]
  double speed_rounding = 0.0;         ///< [m/s] of Newton steps
  double stiffness_ratio = 1.0;        ///< of the stiffest to the softest translation
  std::string stiffest, softest;
  double motion = 0.0, scene_size = 0.0;  ///< [m] largest motion in the step; diagonal of all bodies
  BodyVertices fastest;                   ///< what moved so far
  std::string joint_violation;
  std::string released_by;   ///< the joint or attachment that has released the bodies of the narrowest gap
  bool joints_held = false;  ///< all did where the step started, and what is prescribed has hardly moved
  std::vector<std::string> unit_suspicions;
  std::vector<Attempt> attempts;
};

struct Diagnosis {
  FailureCause cause = FailureCause::None;
  std::string finding;              ///< what was found, with names, numbers and units
  std::string remedy;               ///< what to change
  std::vector<std::string> bodies;  ///< those involved, without repetition
  StepEvidence evidence;

  explicit operator bool() const { return cause != FailureCause::None; }
};

/// Names the cause of a failed step.
Diagnosis judge(StepEvidence evidence, const Settings& settings);

}  // namespace stark
