// All settings of a simulation: plain aggregates, each member declared in one line of a list
// (*_settings.inc) from which its descriptor (base/settings.h), validation, assignment by dotted name, files,
// printing and the reference table derive. Phase: before the first time step.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include <stark/base/math.h>
#include <stark/base/settings.h>
#include <stark/contact/contact_settings.h>
#include <stark/linalg/linear_solver.h>
#include <stark/mechanics/time_integrator.h>
#include <stark/solve/newton_settings.h>
#include <stark/symbolic/kernel.h>

namespace stark {

struct TimeSettings {
#define STARK_SETTING(type, name, value, unit, rule, meaning) type name = value;
#include <stark/sim/scene/time_settings.inc>
#undef STARK_SETTING
  static const FieldTable& fields();
};

struct JointSettings {
#define STARK_SETTING(type, name, value, unit, rule, meaning) type name = value;
#include <stark/sim/scene/joint_settings.inc>
#undef STARK_SETTING
  static const FieldTable& fields();
};

struct ExecutionSettings {
#define STARK_SETTING(type, name, value, unit, rule, meaning) type name = value;
#include <stark/sim/scene/execution_settings.inc>
#undef STARK_SETTING
  static const FieldTable& fields();
};

struct Settings {
  TimeSettings time;
  NewtonSettings newton;
  LinearSettings linear;
  ContactSettings contact;
  JointSettings joints;
  ExecutionSettings execution;
  Vec3 gravity{0.0, 0.0, -9.81};  ///< [m/s^2]
  static const FieldTable& fields();
};

/// Ranges of all fields and the rules between them; throws InvalidSetting.
void validate(const Settings& settings);

/// Assigns by dotted name ("newton.step_tolerance"; also the short forms time_step, contact_distance,
/// threads) and checks the range; throws InvalidSetting with the nearest known name. The rules between fields
/// are left to validate().
void set(Settings& settings, std::string_view name, const FieldValue& value);
void set_from_text(Settings& settings, std::string_view name, std::string_view text);
FieldValue get(const Settings& settings, std::string_view name);

/// "newton.step_tolerance = 1e-06 m/s, threads = 2", or "all defaults".
std::string changed_from_default(const Settings& settings);

}  // namespace stark
