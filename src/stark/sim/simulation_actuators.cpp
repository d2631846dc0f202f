// Simulation: actuators. Inputs of a step, efforts and memories at its end, live values.
#include <algorithm>
#include <cmath>
#include <utility>

#include <stark/base/error.h>
#include <stark/sim/scene/joint_wrench.h>
#include <stark/sim/scene/validation.h>
#include <stark/sim/simulation_parts.h>

namespace stark {

namespace {

std::string owner_text(const ActuatorDescription& actuator) { return "actuator '" + actuator.name + "'"; }

std::map<std::string, double> values_of(const State& state, const ModelActuator& place) {
  std::map<std::string, double> values;
  for (size_t p = 0; p < place.law->parameters().size(); ++p)
    values[place.law->parameters()[p].name] = state.actuator_value[place.value + p];
  return values;
}

/// Throws for an actuator that acts on a rate, where nothing has one, unless it is capped at zero.
void require_no_rates(const ActuatorDescription& actuator, const std::map<std::string, double>& values) {
  if (!actuator.definition->needs_rates) return;
  if (const auto cap = values.find("cap"); cap != values.end() && cap->second == 0.0) return;
  throw InvalidArgument(owner_text(actuator) + ": " + actuator.definition->name +
                        " acts on a rate, and quasistatic steps have none: must be used with "
                        "time.integrator = implicit_euler or bdf2; use position_servo, effort or brake here");
}

}  // namespace

void Simulation::check_actuators() {
  if (scene_.actuators().empty()) return;
  const std::vector<Vec3> x = site_positions();
  step_start_ = x;
  parts_->motion.begin(settings_.time.step);
  parts_->joints.begin_actuators(settings_.time.step);
  step_start_.clear();  // no step has been taken yet
  const std::vector<double> C = energies_.constraints.residuals(x);
  const auto joints = static_cast<int32_t>(scene_.joints().size());
  for (int32_t k = 0; k < static_cast<int32_t>(scene_.actuators().size()); ++k) {
    const ActuatorDescription& actuator = scene_.actuators()[k];
    const Actuator& law = *model_->actuators()[k].law;
    if (actuator.enabled && !has_inertia(settings_.time.integrator))
      require_no_rates(actuator, values_of(state_, model_->actuators()[k]));
    const int64_t first = energies_.constraints.place(joints + k).residual;
    for (size_t r = 0; actuator.enabled && r < law.units().size(); ++r) {
      const bool is_length = law.units()[r] == ResidualUnit::Length;
      const double off = law.one_sided()[r] != 0 ? C[first + r] : std::fabs(C[first + r]);
      const double tolerance =
          is_length ? joint_tolerance(settings_.joints).length : joint_tolerance(settings_.joints).angle;
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
  std::map<std::string, double> values = values_of(state_, place);
  values[name] = value;
  check_order(owner_text(actuator), *actuator.definition, values);
  if (!has_inertia(settings_.time.integrator) && name == "cap") require_no_rates(actuator, values);
  state_.actuator_value[place.value + k] = value;
}

double Simulation::actuator_value(ActuatorId id, const std::string& name) const {
  const ActuatorDescription& actuator = scene_.actuator(id);
  const ModelActuator& place = model_->actuators()[id.index];
  return state_.actuator_value[place.value + parameter_index(actuator, *place.law, name)];
}

void Simulation::set_actuator_enabled(ActuatorId id, bool enabled) {
  const ActuatorDescription& actuator = scene_.actuator(id);
  if (enabled && !has_inertia(settings_.time.integrator))
    require_no_rates(actuator, values_of(state_, model_->actuators()[id.index]));
  const double before = std::exchange(state_.actuator_enabled[id.index], enabled ? 1.0 : 0.0);
  const size_t count = model_->actuators()[id.index].law->units().size();
  if ((before != 0.0) == enabled || count == 0) return;
  const auto constraint = static_cast<int32_t>(scene_.joints().size()) + id.index;
  if (enabled && !is_placing()) {
    const std::string text = parts_->placing.misfit_text([&](int32_t j) { return j == constraint; });
    if (!text.empty()) {
      state_.actuator_enabled[id.index] = before;
      throw InvalidArgument(text +
                            " now: must be held to act again, as the next step would throw what it is on "
                            "there; change its values (offset, lower, upper), or place the bodies first");
    }
  }
  parts_->joints.forget_history();
  let_go(state_, energies_.constraints.place(constraint).residual, count);
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
  return stark::actuator_power(model_->actuators()[id.index], state_);
}

}  // namespace stark
