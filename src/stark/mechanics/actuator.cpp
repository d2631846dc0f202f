#include <stark/mechanics/actuator.h>

#include <numbers>
#include <set>

#include <stark/base/error.h>
#include <stark/mechanics/reduced_formula.h>
#include <stark/symbolic/diff.h>

namespace stark {

using symbolic::Scalar;

namespace {

// Fields of the law have a prefix of their own; the dots keep names of users' parameters apart.
constexpr const char* kLawPrefix = "actuator.";

constexpr const char* kDuration = "duration";

std::string memory_name(const std::string& name) { return "memory." + name; }
std::string start_name(int k) { return "coordinate." + std::to_string(k); }
std::string rate_start_name(int k) { return "rate." + std::to_string(k); }

}  // namespace

std::string actuator_parameter_field(const std::string& parameter) { return kLawPrefix + parameter; }
std::string actuator_memory_field(const std::string& memory) { return kLawPrefix + memory_name(memory); }
std::string actuator_start_field(int coordinate) { return kLawPrefix + start_name(coordinate); }
std::string actuator_rate_start_field(int coordinate) { return kLawPrefix + rate_start_name(coordinate); }
std::string actuator_duration_field() { return std::string(kLawPrefix) + kDuration; }
std::string actuator_raw_start_field(int coordinate) { return "raw_start." + std::to_string(coordinate); }
std::string actuator_joint_prefix(int coordinate) { return "joint" + std::to_string(coordinate) + "."; }

ActuatorBuilder::ActuatorBuilder(PotentialBuilder& inputs, std::vector<std::string> units)
    : inputs_(inputs), units_(std::move(units)) {}

Scalar ActuatorBuilder::dq(int k) {
  STARK_CHECK(k >= 0 && k < coordinate_count());
  return inputs_.x(0)[k];
}

Scalar ActuatorBuilder::q_start(int k) {
  return inputs_.data(start_name(k), unit(k), "coordinate at the start of the step");
}

Scalar ActuatorBuilder::q(int k) { return q_start(k) + dq(k); }
Scalar ActuatorBuilder::rate(int k) { return dq(k) / time_step(); }

Scalar ActuatorBuilder::rate_start(int k) {
  return inputs_.data(rate_start_name(k), rate_unit(k), "rate of the coordinate in the step before");
}

Scalar ActuatorBuilder::time_step() { return inputs_.time_step(); }
Scalar ActuatorBuilder::duration() { return inputs_.data(kDuration, "s", "length of the step"); }
Scalar ActuatorBuilder::time() { return inputs_.time(); }

Scalar ActuatorBuilder::parameter(const std::string& name, const std::string& unit, const std::string& doc,
                                  const FieldRule& rule, std::optional<double> fallback) {
  const Scalar value = inputs_.parameter(name, unit, doc, rule);
  for (const ActuatorParameter& known : parameters_)
    if (known.name == name) return value;
  parameters_.push_back({name, unit, doc, rule, fallback});
  return value;
}

Scalar ActuatorBuilder::memory(const std::string& name, const std::string& unit, const std::string& doc) {
  const Scalar value = inputs_.data(memory_name(name), unit, doc);
  for (const Memory& known : memories_)
    if (known.name == name) return value;
  memories_.push_back({name, value});
  return value;
}

void ActuatorBuilder::remember(const std::string& name, const Scalar& value) {
  for (Memory& memory : memories_)
    if (memory.name == name) {
      memory.next = value;
      return;
    }
  throw InvalidArgument("actuator memory '" + name +
                        "' is unknown: must be declared with memory() before remember()");
}

void ActuatorBuilder::hold(const Scalar& residual) { rows_.push_back({residual, false}); }
void ActuatorBuilder::limit(const Scalar& residual) { rows_.push_back({residual, true}); }

ActuatorDefinition define_actuator(std::string name, std::string doc,
                                   std::function<Scalar(ActuatorBuilder&)> formula) {
  return {.name = std::move(name), .doc = std::move(doc), .formula = std::move(formula)};
}

ActuatorDefinition define_actuator(std::string name, std::string doc, Formula formula,
                                   ActuatorOutputs outputs) {
  STARK_CHECK(formula.point_count() == 1);
  const int coordinates = outputs.coordinates;
  ActuatorDefinition definition =
      define_actuator(std::move(name), std::move(doc),
                      [formula = std::move(formula), outputs = std::move(outputs)](ActuatorBuilder& a) {
                        for (const UniformField& field : formula.uniform_fields()) {
                          if (field.name == "time_step" || field.name == "time") continue;
                          const auto fallback = outputs.fallbacks.find(field.name);
                          const bool is_given = fallback != outputs.fallbacks.end();
                          a.parameter(field.name, field.unit, field.doc, field.rule,
                                      is_given ? std::optional(fallback->second) : std::nullopt);
                        }
                        for (const std::string& memory : outputs.memories)
                          a.memory(memory, "", "kept from step to step");
                        const std::vector<Scalar> values = a.repeat(formula);
                        size_t next = 1;
                        for (const bool one_sided : outputs.one_sided)
                          one_sided ? a.limit(values[next++]) : a.hold(values[next++]);
                        for (const std::string& memory : outputs.memories) a.remember(memory, values[next++]);
                        return values[0];
                      });
  definition.coordinate_count = coordinates;
  return definition;
}

std::vector<ActuatorParameter> actuator_parameters(const ActuatorDefinition& definition,
                                                   const std::vector<std::string>& units) {
  PotentialBuilder inputs(1);
  ActuatorBuilder builder(inputs, units);
  definition.formula(builder);
  return builder.parameters();
}

namespace {

/// Derivative by the change of each coordinate.
std::vector<Scalar> slopes(PotentialBuilder& inputs, const Scalar& value, int coordinates) {
  std::vector<Scalar> result(coordinates, 0.0);
  if (value.is_literal()) return result;
  symbolic::Graph& graph = *inputs.graph();
  const symbolic::Derivatives d = symbolic::gradient(graph, value.id());
  for (int k = 0; k < coordinates; ++k) result[k] = Scalar(&graph, d.gradient[k]);
  return result;
}

/// An actuator's formula in terms of the changes of its coordinates within the step.
struct Law {
  int rows = 0, memories = 0, coordinates = 0;
  std::vector<char> one_sided;
  Formula formula;  ///< energy, residuals, next memories, slopes of the energy, slopes of the residuals
};

Law trace(const std::shared_ptr<PotentialBuilder>& inputs, const ActuatorBuilder& builder,
          const Scalar& energy) {
  Law law;
  law.coordinates = builder.coordinate_count();
  std::vector<Scalar> outputs{energy};
  for (const ActuatorBuilder::Row& row : builder.rows()) {
    outputs.push_back(row.residual);
    law.one_sided.push_back(row.one_sided);
    ++law.rows;
  }
  for (const ActuatorBuilder::Memory& memory : builder.memories()) {
    outputs.push_back(memory.next);
    ++law.memories;
  }
  for (int r = 0; r <= law.rows; ++r) {
    const std::vector<Scalar> slope = slopes(*inputs, outputs[r], law.coordinates);
    outputs.insert(outputs.end(), slope.begin(), slope.end());
  }
  law.formula = Formula(inputs, std::move(outputs));
  return law;
}

/// Formula of one coordinate of a joint.
ReducedFormula trace(const JointCoordinate& coordinate) {
  const int points = frame_point_count(coordinate.a) + frame_point_count(coordinate.b);
  const auto traced = std::make_shared<PotentialBuilder>(points);
  JointBuilder builder(*traced, coordinate.a, coordinate.b);
  coordinate.joint->formula(builder);
  return {traced, {builder.coordinates().at(coordinate.index).value}};
}

/// Change of an angle within a step, of which half a turn at most is seen.
Scalar shortest_turn(const Scalar& change) {
  constexpr double kHalf = std::numbers::pi, kTurn = 2.0 * std::numbers::pi;
  return select(change > kHalf, change - kTurn, select(change < -kHalf, change + kTurn, change));
}

}  // namespace

Actuator::Actuator(const ActuatorDefinition& definition, const std::vector<JointCoordinate>& coordinates,
                   symbolic::Backend backend) {
  name_ = definition.name;
  const int count = static_cast<int>(coordinates.size());
  STARK_CHECK(count == definition.coordinate_count && count <= 3);
  std::vector<std::string> units;
  std::vector<ReducedFormula> raw;
  std::set<std::string> own_values;
  for (int k = 0; k < count; ++k) {
    const JointCoordinate& c = coordinates[k];
    units.push_back(joint_coordinates(*c.joint).at(c.index).unit);
    for (const ParameterDeclaration& parameter : joint_parameters(*c.joint))
      own_values.insert(actuator_joint_prefix(k) + parameter.name);
    raw.push_back(trace(c));
    const std::vector<int>& points = raw.back().points();
    points_.insert(points_.end(), points.begin(), points.end());
    point_counts_.push_back(static_cast<int>(points.size()));
  }

  const auto inputs = std::make_shared<PotentialBuilder>(1);
  ActuatorBuilder builder(*inputs, units);
  const Scalar law_energy = definition.formula(builder);
  const Law law = trace(inputs, builder, law_energy);
  parameters_ = builder.parameters();
  for (const ActuatorParameter& parameter : parameters_)
    own_values.insert(actuator_parameter_field(parameter.name));
  for (const ActuatorBuilder::Memory& memory : builder.memories()) memories_.push_back(memory.name);
  one_sided_ = law.one_sided;
  units_.assign(law.rows, units[0] == "rad" ? ResidualUnit::Angle : ResidualUnit::Length);
  hold_sizes_.assign(law.rows, 1);

  PotentialBuilder target(static_cast<int>(points_.size()), own_values);
  symbolic::Vec3 change(0.0, 0.0, 0.0);
  for (int k = 0, first = 0; k < count; first += point_counts_[k], ++k) {
    const Scalar now = raw[k].repeat(target, first, actuator_joint_prefix(k))[0];
    const Scalar start =
        target.data(actuator_raw_start_field(k), units[k], "coordinate at the start, up to full turns");
    change[k] = units[k] == "rad" ? shortest_turn(now - start) : now - start;
  }
  const std::vector<Scalar> out = law.formula.repeat(target, {.x = {change}}, kLawPrefix);
  const Scalar active = target.data("active", "1", "1 for actuators that act, 0 for others");
  Scalar energy = active * out[0];
  const Scalar* slope = out.data() + 1 + law.rows + law.memories;
  std::vector<Scalar> effort;
  for (int k = 0; k < count; ++k) effort.push_back(-active * slope[k]);
  if (law.rows > 0) {
    const auto lambda = target.data_array("multiplier", law.rows, "N, N m", "force that holds the residual");
    const auto rho = target.data_array("penalty", law.rows, "N/m, N m", "stiffness of the residual");
    for (int r = 0; r < law.rows; ++r) {
      const ConstraintRow row{out[1 + r], lambda[r], rho[r]};
      energy += constraint_energy(row, law.one_sided[r] != 0);
      for (int k = 0; k < count; ++k)
        effort[k] -= constraint_force(row, law.one_sided[r] != 0) * slope[(1 + r) * count + k];
    }
  }
  potential_ = std::make_shared<Potential>(name_, target, energy, backend);
  std::vector<Scalar> values(out.begin() + 1, out.begin() + 1 + law.rows);
  values.insert(values.end(), effort.begin(), effort.end());
  values.insert(values.end(), out.begin() + 1 + law.rows, out.begin() + 1 + law.rows + law.memories);
  values_ = symbolic::compile_function(values, backend);
}

}  // namespace stark
