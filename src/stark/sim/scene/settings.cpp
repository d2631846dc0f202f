// The descriptor tables of all settings, the rules between them and the short names. See settings.h.
#include <stark/sim/scene/settings.h>

#include <stark/base/error.h>

namespace stark {

const FieldTable& TimeSettings::fields() {
  static const FieldTable table("time", TableKind::Settings,
                                {
#define STARK_SETTING(type, name, value, unit, rule, meaning) \
  field(&TimeSettings::name, #name, unit, rule, meaning),
#include <stark/sim/scene/time_settings.inc>
#undef STARK_SETTING
                                });
  return table;
}

const FieldTable& JointSettings::fields() {
  static const FieldTable table("joints", TableKind::Settings,
                                {
#define STARK_SETTING(type, name, value, unit, rule, meaning) \
  field(&JointSettings::name, #name, unit, rule, meaning),
#include <stark/sim/scene/joint_settings.inc>
#undef STARK_SETTING
                                });
  return table;
}

const FieldTable& ExecutionSettings::fields() {
  static const FieldTable table("execution", TableKind::Settings,
                                {
#define STARK_SETTING(type, name, value, unit, rule, meaning) \
  field(&ExecutionSettings::name, #name, unit, rule, meaning),
#include <stark/sim/scene/execution_settings.inc>
#undef STARK_SETTING
                                });
  return table;
}

const FieldTable& Settings::fields() {
  using S = Settings;
  static const FieldTable table = [] {
    std::vector<Field> all;
    for (auto fields : {group(&S::time, "time", TimeSettings::fields()),
                        group(&S::newton, "newton", NewtonSettings::fields()),
                        group(&S::linear, "linear", LinearSettings::fields()),
                        group(&S::contact, "contact", ContactSettings::fields()),
                        group(&S::joints, "joints", JointSettings::fields()),
                        group(&S::execution, "execution", ExecutionSettings::fields())})
      all.insert(all.end(), fields.begin(), fields.end());
    all.push_back(field(&S::gravity, "gravity", "m/s^2", any_number(), "acceleration of gravity"));
    return FieldTable("the settings", TableKind::Settings, std::move(all));
  }();
  return table;
}

namespace {

/// Short forms that scripts use for the settings that nearly every scene sets.
std::string full_name(std::string_view name) {
  if (name == "time_step") return "time.step";
  if (name == "contact_distance") return "contact.distance";
  if (name == "threads") return "execution.threads";
  return std::string(name);
}

}  // namespace

void validate(const Settings& settings) {
  const FieldTable& table = Settings::fields();
  table.validate(&settings);
  if (settings.time.min_step > settings.time.step)
    table.fail("time.min_step = " + quantity_text(settings.time.min_step, "s") +
               ": must not exceed time.step = " + quantity_text(settings.time.step, "s") +
               "; lower time.min_step or raise time.step");
  const NewtonSettings& newton = settings.newton;
  if (newton.acceleration_tolerance == 0.0 && newton.residual_tolerance == 0.0 &&
      newton.step_tolerance == 0.0)
    table.fail(
        "newton.acceleration_tolerance, newton.residual_tolerance and newton.step_tolerance are all 0: no "
        "step could "
        "converge; set at least one, for instance newton.acceleration_tolerance = 0.01 m/s^2");
  if (!has_inertia(settings.time.integrator) && newton.residual_tolerance == 0.0 &&
      newton.step_tolerance == 0.0)
    table.fail(
        "time.integrator = 'quasistatic' with only newton.acceleration_tolerance: accelerations mean nothing "
        "without inertia; set newton.residual_tolerance [N] or newton.step_tolerance [m/s]");
}

void set(Settings& settings, std::string_view name, const FieldValue& value) {
  Settings::fields().set(&settings, full_name(name), value);
}

void set_from_text(Settings& settings, std::string_view name, std::string_view text) {
  Settings::fields().set_from_text(&settings, full_name(name), text);
}

FieldValue get(const Settings& settings, std::string_view name) {
  return Settings::fields().get(&settings, full_name(name));
}

std::string changed_from_default(const Settings& settings) {
  std::string text;
  for (const auto& [name, value] : Settings::fields().changed_from_default(&settings))
    text += (text.empty() ? "" : ", ") + name + " = " + Settings::fields().find(name).value_text(value);
  return text.empty() ? "all defaults" : text;
}

}  // namespace stark
