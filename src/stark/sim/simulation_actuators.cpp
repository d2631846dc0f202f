// Simulation: actuators. Inputs of a step, efforts and memories at its end, live values.
#include <algorithm>
#include <cmath>

#include <stark/base/error.h>
#include <stark/sim/simulation.h>
#include <stark/sim/validation.h>

namespace stark {

namespace {

std::string owner_text(const ActuatorDescription& actuator) { return "actuator '" + actuator.name + "'"; }

/// Element fields of a group of actuators, looked up once.
struct ActuatorFields {
  explicit ActuatorFields(const ConstraintGroup& group) {
    const auto& law = static_cast<const Actuator&>(*group.joint);
    const auto& known = group.batch.potential().element_fields();
    const auto find = [&](const std::string& name) {
      const auto found = std::ranges::find(known, name, &ElementField::name);
      return found == known.end() ? -1 : static_cast<int>(found - known.begin());
    };
    active = find("active");
    duration = find(actuator_duration_field());
    for (int c = 0; c < law.coordinate_count(); ++c) {
      raw_start.push_back(find(actuator_raw_start_field(c)));
      start.push_back(find(actuator_start_field(c)));
      rate.push_back(find(actuator_rate_start_field(c)));
    }
    for (const ActuatorParameter& parameter : law.parameters())
      values.push_back(find(actuator_parameter_field(parameter.name)));
    for (const std::string& memory : law.memories()) memories.push_back(find(actuator_memory_field(memory)));
  }

  int active = -1, duration = -1;  ///< -1: the formula does not use it
  std::vector<int> raw_start, start, rate, values, memories;
};

void set(PotentialBatch& batch, int field, int64_t element, double value) {
  if (field >= 0) batch.set(field, element, {&value, 1});
}

}  // namespace

std::vector<double> Simulation::acting() const {
  std::vector<double> acting = state_.joint_enabled;
  for (size_t k = 0; k < scene_.actuators().size(); ++k) {
    bool on = state_.actuator_enabled[k] != 0.0;
    for (const CoordinateName& coordinate : scene_.actuators()[k].on)
      on = on && state_.joint_enabled[coordinate.joint.index] != 0.0;
    acting.push_back(on ? 1.0 : 0.0);
  }
  for (const double held : state_.attachment_held) acting.push_back(held == 1.0 ? 1.0 : 0.0);
  return acting;
}

bool Simulation::is_of_actuators(const ConstraintGroup& group) const {
  const size_t number = group.joints.front(), joints = scene_.joints().size();
  return number >= joints && number < joints + scene_.actuators().size();
}

void Simulation::begin_actuators(double h) {
  if (scene_.actuators().empty()) return;
  const std::vector<double> on = acting();
  // What rates are measured from: the start of the step, or what BDF2 takes for it.
  const std::vector<double> raw = reference_coordinates(),
                            start = model_->constraints().coordinates(step_start_);
  const auto joints = static_cast<int32_t>(scene_.joints().size());
  for (ConstraintGroup& group : model_->constraints().groups()) {
    if (!is_of_actuators(group)) continue;
    const ActuatorFields fields(group);
    for (int64_t e = 0; e < group.batch.size(); ++e) {
      const int32_t number = group.joints[e];
      const ModelActuator& actuator = model_->actuators()[number - joints];
      set(group.batch, fields.active, e, on[number]);
      set(group.batch, fields.duration, e, h);
      for (size_t c = 0; c < actuator.coordinates.size(); ++c) {
        const int64_t q = actuator.coordinates[c];
        set(group.batch, fields.raw_start[c], e, raw[q]);
        const double change = raw[q] - start[q];
        set(group.batch, fields.start[c], e,
            state_.joint_coordinate[q] + (actuator.is_angle[c] ? shortest_turn(change) : change));
        set(group.batch, fields.rate[c], e, reference_.joint_rate[q]);
      }
      for (size_t v = 0; v < fields.values.size(); ++v)
        set(group.batch, fields.values[v], e, state_.actuator_value[actuator.value + v]);
      for (size_t m = 0; m < fields.memories.size(); ++m)
        set(group.batch, fields.memories[m], e, state_.actuator_memory[actuator.memory + m]);
    }
  }
}

void Simulation::commit_actuators(std::span<const Vec3> x) {
  const auto joints = static_cast<int32_t>(scene_.joints().size());
  for (const ConstraintGroup& group : model_->constraints().groups()) {
    if (!is_of_actuators(group)) continue;
    const std::vector<double> values = group.batch.evaluate(group.joint->values(), x);
    const size_t outputs = values.size() / group.batch.size(), rows = group.joint->units().size();
    for (int64_t e = 0; e < group.batch.size(); ++e) {
      const ModelActuator& actuator = model_->actuators()[group.joints[e] - joints];
      const double* value = values.data() + e * outputs + rows;
      const size_t efforts = actuator.coordinates.size(), memories = actuator.law->memories().size();
      std::copy_n(value, efforts, state_.actuator_effort.begin() + actuator.effort);
      std::copy_n(value + efforts, memories, state_.actuator_memory.begin() + actuator.memory);
    }
  }
}

void Simulation::check_actuators() {
  if (scene_.actuators().empty()) return;
  const std::vector<Vec3> x = site_positions();
  step_start_ = x;
  set_reference(settings_.time.step);
  begin_actuators(settings_.time.step);
  step_start_.clear();  // no step has been taken yet
  const std::vector<double> C = model_->constraints().residuals(x);
  const auto joints = static_cast<int32_t>(scene_.joints().size());
  for (int32_t k = 0; k < static_cast<int32_t>(scene_.actuators().size()); ++k) {
    const ActuatorDescription& actuator = scene_.actuators()[k];
    if (actuator.definition->needs_rates && settings_.time.integrator == Integrator::Quasistatic)
      throw InvalidArgument(owner_text(actuator) + ": " + actuator.definition->name +
                            " drives a rate, and quasistatic steps have none: must be used with "
                            "time.integrator = implicit_euler; use position_servo or effort here");
    const Actuator& law = *model_->actuators()[k].law;
    const int64_t first = model_->constraints().place(joints + k).residual;
    for (size_t r = 0; actuator.enabled && r < law.units().size(); ++r) {
      const bool is_length = law.units()[r] == ResidualUnit::Length;
      const double off = law.one_sided()[r] != 0 ? C[first + r] : std::fabs(C[first + r]);
      const double tolerance = is_length ? joint_tolerance().length : joint_tolerance().angle;
      if (!(off <= tolerance))
        throw InvalidArgument(owner_text(actuator) + ": coordinate '" + actuator.on[0].name + "' of joint '" +
                              scene_.joint(actuator.on[0].joint).name + "' is off by " +
                              quantity_text(off, is_length ? "m" : "rad") + " at time 0: must be within " +
                              quantity_text(tolerance, is_length ? "m" : "rad") +
                              "; change its values or the pose, or add it with enabled = false");
    }
  }
}

namespace {

/// Position of a parameter; throws for unknown names.
size_t parameter_index(const ActuatorDescription& actuator, const Actuator& law, const std::string& name) {
  std::vector<std::string> names;
  for (const ActuatorParameter& parameter : law.parameters()) {
    if (parameter.name == name) return names.size();
    names.push_back(parameter.name);
  }
  throw InvalidArgument(owner_text(actuator) + ": unknown value '" + name + "'" +
                        nearest_name_hint(name, names) + ": must be an input of the formula");
}

}  // namespace

void Simulation::set_actuator_value(ActuatorId id, const std::string& name, double value) {
  const ActuatorDescription& actuator = scene_.actuator(id);
  const ModelActuator& place = model_->actuators()[id.index];
  const size_t k = parameter_index(actuator, *place.law, name);
  const ActuatorParameter& parameter = place.law->parameters()[k];
  check_number(owner_text(actuator), name, value, parameter.unit, parameter.rule,
               "it is the " + parameter.doc);
  std::map<std::string, double> values;
  for (size_t p = 0; p < place.law->parameters().size(); ++p)
    values[place.law->parameters()[p].name] = state_.actuator_value[place.value + p];
  values[name] = value;
  check_order(owner_text(actuator), *actuator.definition, values);
  state_.actuator_value[place.value + k] = value;
}

double Simulation::actuator_value(ActuatorId id, const std::string& name) const {
  const ActuatorDescription& actuator = scene_.actuator(id);
  const ModelActuator& place = model_->actuators()[id.index];
  return state_.actuator_value[place.value + parameter_index(actuator, *place.law, name)];
}

void Simulation::set_actuator_enabled(ActuatorId id, bool enabled) {
  scene_.actuator(id);
  state_.actuator_enabled[id.index] = enabled ? 1.0 : 0.0;
}

bool Simulation::actuator_enabled(ActuatorId id) const {
  scene_.actuator(id);
  return state_.actuator_enabled[id.index] != 0.0;
}

double Simulation::actuator_effort(ActuatorId id) const {
  scene_.actuator(id);
  return state_.actuator_effort[model_->actuators()[id.index].effort];
}

double Simulation::actuator_power(ActuatorId id) const {
  scene_.actuator(id);
  const ModelActuator& actuator = model_->actuators()[id.index];
  double power = 0.0;
  for (size_t c = 0; c < actuator.coordinates.size(); ++c)
    power += state_.actuator_effort[actuator.effort + c] * state_.joint_rate[actuator.coordinates[c]];
  return power;
}

}  // namespace stark
