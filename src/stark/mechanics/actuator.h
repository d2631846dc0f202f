// An actuator: what acts along a coordinate of a joint, or couples the coordinates of two. Motors, servos,
// springs, friction, stops and gears are each written once as a formula of the coordinate and serve every
// joint, rotation and displacement, rigid bodies and patches alike:
//
//   ActuatorDefinition spring_damper() {
//     return define_actuator("spring_damper", "...", [](ActuatorBuilder& a) {
//       const Scalar k = a.parameter("stiffness", a.stiffness_unit(), "..."), ...;
//       return 0.5 * k * square(a.q() - rest) + 0.5 * a.time_step() * c * square(a.rate());
//     });
//   }
//
// The energy E is that of one implicit time step, so the effort -dE/dq is applied at the end of it: a torque
// [N m] along coordinates in rad, a force [N] along those in m, positive where it raises the coordinate. It
// acts on frame b of the joint, and its opposite on frame a. A cap is a property of dE/dq and therefore
// exact. Phase: model building.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <stark/mechanics/joint.h>

namespace stark {

struct ActuatorParameter {
  std::string name, unit, doc;
  FieldRule rule = any_number();
  std::optional<double> fallback{};  ///< unset: must be given
};

/// How an actuator's formula sees a coordinate and declares what it needs. Angles count full turns.
class ActuatorBuilder {
 public:
  /// `units`: of the coordinates, "rad" or another; `inputs` has one point.
  ActuatorBuilder(PotentialBuilder& inputs, std::vector<std::string> units);

  symbolic::Scalar q(int coordinate = 0);           ///< at the end of the step
  symbolic::Scalar q_start(int coordinate = 0);     ///< at its start
  symbolic::Scalar dq(int coordinate = 0);          ///< the difference
  symbolic::Scalar rate(int coordinate = 0);        ///< dq / time_step
  symbolic::Scalar rate_start(int coordinate = 0);  ///< of the step before; at time 0, of the velocities
  symbolic::Scalar time_step();                     ///< of rates: s of the integrator, h but for BDF2 [s]
  symbolic::Scalar duration();                      ///< how long the step takes, h [s]
  symbolic::Scalar time();                          ///< at the end of the step [s]

  /// A number that each actuator has of its own and that can be changed between steps.
  symbolic::Scalar parameter(const std::string& name, const std::string& unit, const std::string& doc,
                             const FieldRule& rule = any_number(), std::optional<double> fallback = {});
  /// A number that is kept from step to step, zero at first, and what it becomes at the end of a step.
  symbolic::Scalar memory(const std::string& name, const std::string& unit, const std::string& doc);
  void remember(const std::string& name, const symbolic::Scalar& value);
  /// A residual, in the unit of the first coordinate, that is held at zero, or kept at or below zero.
  void hold(const symbolic::Scalar& residual);
  void limit(const symbolic::Scalar& residual);

  /// A formula of one point, the changes of up to three coordinates, with the inputs of this builder.
  std::vector<symbolic::Scalar> repeat(const Formula& formula) { return formula.repeat(inputs_); }

  int coordinate_count() const { return static_cast<int>(units_.size()); }
  std::string unit(int coordinate = 0) const { return units_.at(coordinate); }
  std::string rate_unit(int coordinate = 0) const { return unit(coordinate) + "/s"; }
  std::string effort_unit() const { return units_[0] == "rad" ? "N m" : "N"; }
  std::string stiffness_unit() const { return effort_unit() + "/" + units_[0]; }
  std::string damping_unit() const { return effort_unit() + " s/" + units_[0]; }

  struct Memory {
    std::string name;
    symbolic::Scalar next;
  };
  struct Row {
    symbolic::Scalar residual;
    bool one_sided = false;
  };
  const std::vector<ActuatorParameter>& parameters() const { return parameters_; }
  const std::vector<Memory>& memories() const { return memories_; }
  const std::vector<Row>& rows() const { return rows_; }

 private:
  PotentialBuilder& inputs_;
  std::vector<std::string> units_;
  std::vector<ActuatorParameter> parameters_;
  std::vector<Memory> memories_;
  std::vector<Row> rows_;
};

struct ActuatorDefinition {
  std::string name;
  std::string doc;
  std::function<symbolic::Scalar(ActuatorBuilder&)> formula;
  int coordinate_count = 1;
  bool needs_rates = false;                                    ///< has no meaning in quasistatic steps
  std::vector<std::pair<std::string, std::string>> ordered{};  ///< values: the first is at most the second
};

ActuatorDefinition define_actuator(std::string name, std::string doc,
                                   std::function<symbolic::Scalar(ActuatorBuilder&)> formula);

/// What the outputs of a formula mean as an actuator: the energy, a residual for each row, what each memory
/// becomes.
struct ActuatorOutputs {
  int coordinates = 1;
  std::vector<bool> one_sided{};  ///< by row
  std::vector<std::string> memories{};
  std::map<std::string, double> fallbacks{};  ///< of parameters that need not be given
};

/// Actuator from a formula of one point, whose components are the changes of the coordinates. Its element
/// data are "coordinate.k" and "rate.k" (at the start of the step) and "memory.name"; its parameters become
/// values.
ActuatorDefinition define_actuator(std::string name, std::string doc, Formula formula,
                                   ActuatorOutputs outputs);

/// Parameters of an actuator on coordinates with these units, in the order of their first use.
std::vector<ActuatorParameter> actuator_parameters(const ActuatorDefinition& definition,
                                                   const std::vector<std::string>& units);

/// A coordinate of a joint between two kinds of frames.
struct JointCoordinate {
  const JointDefinition* joint = nullptr;
  int index = 0;
  FrameKind a = FrameKind::Axes, b = FrameKind::Axes;
};

/// A compiled actuator. To the constraint set it is a joint whose residuals are the actuator's; values() are
/// the residuals, the effort along each coordinate, then what its memories become. Element data: those of a
/// joint, "active" (0 or 1), "raw_start0" and so on for each coordinate (as the joint's formula gives it at
/// the start of the step), kActuatorPrefix + parameters, and the fields below.
class Actuator : public Joint {
 public:
  Actuator(const ActuatorDefinition& definition, const std::vector<JointCoordinate>& coordinates,
           symbolic::Backend backend);

  /// How many of points() belong to each coordinate; their numbers are those of its joint's frames.
  const std::vector<int>& point_counts() const { return point_counts_; }
  const std::vector<ActuatorParameter>& parameters() const { return parameters_; }
  const std::vector<std::string>& memories() const { return memories_; }
  int coordinate_count() const { return static_cast<int>(point_counts_.size()); }

 private:
  std::vector<int> point_counts_;
  std::vector<ActuatorParameter> parameters_;
  std::vector<std::string> memories_;
};

/// Names of element data of a compiled actuator.
std::string actuator_parameter_field(const std::string& parameter);
std::string actuator_memory_field(const std::string& memory);
std::string actuator_start_field(int coordinate);       ///< coordinate at the start of the step
std::string actuator_rate_start_field(int coordinate);  ///< its rate in the step before
std::string actuator_duration_field();                  ///< length of the step
std::string actuator_raw_start_field(int coordinate);   ///< as the formula gives it, without full turns
/// What the fields of a joint are called for coordinate k of an actuator.
std::string actuator_joint_prefix(int coordinate);

}  // namespace stark
