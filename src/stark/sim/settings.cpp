// The descriptor tables of all settings, the rules between them and the short names. See settings.h.
#include <stark/sim/settings.h>

#include <numbers>

#include <stark/base/error.h>

namespace stark {

const FieldTable& TimeSettings::fields() {
  using S = TimeSettings;
  static const FieldTable table(
      "time", TableKind::Settings,
      {field(&S::step, "step", "s", positive(), "length of a time step"),
       field(&S::min_step, "min_step", "s", positive(),
             "shortest step: a failing step is halved down to it, then reported as failed"),
       field(&S::growth, "growth", "1", at_least(1.0),
             "factor by which a halved step grows again after an accepted one"),
       field(&S::integrator, "integrator",
             "time integrator: implicit_euler (order 1, damps), bdf2 (order 2, damps little), or quasistatic "
             "for a sequence of equilibria without inertia")});
  return table;
}

const FieldTable& NewtonSettings::fields() {
  using S = NewtonSettings;
  static const FieldTable table(
      "newton", TableKind::Settings,
      {field(&S::acceleration_tolerance, "acceleration_tolerance", "m/s^2", non_negative(),
             "largest unbalanced force over the mass of its node or body, 0 for unused"),
       field(&S::residual_tolerance, "residual_tolerance", "N", non_negative(),
             "largest unbalanced force of a node or body, 0 for unused"),
       field(&S::step_tolerance, "step_tolerance", "m/s", non_negative(),
             "largest motion of a point in the next full Newton step over the time step, 0 for unused"),
       field(&S::termination, "termination", "number of active tolerances that must hold"),
       field(&S::max_iterations, "max_iterations", "1", at_least(1),
             "number of Newton iterations after which the step is retried with half the length"),
       field(&S::max_seconds, "max_seconds", "s", positive_or_infinity(),
             "time by the clock on the wall after which a step fails, looked at between iterations, infinity "
             "for no limit; whether a step fails then depends on the machine"),
       field(&S::projection, "projection", "choice of when element Hessians are made positive semidefinite"),
       field(&S::armijo, "armijo", "1", open_interval(0.0, 0.5),
             "share of the predicted decrease of the energy that the line search demands"),
       field(&S::max_backtracks, "max_backtracks", "1", at_least(1), "number of halvings of one line search"),
       field(
           &S::max_rotation, "max_rotation", "rad", open_interval(0.0, std::numbers::pi / 2),
           "largest rotation of a rigid body in one Newton iteration; collision detection needs less than a "
           "quarter turn")});
  return table;
}

const FieldTable& LinearSettings::fields() {
  using S = LinearSettings;
  static const FieldTable table(
      "linear", TableKind::Settings,
      {field(&S::solver, "solver", "linear solver of the Newton steps"),
       field(&S::pcg_tolerance, "pcg_tolerance", "1", open_interval(0.0, 1.0),
             "relative residual at which conjugate gradients stop"),
       field(&S::pcg_max_iterations, "pcg_max_iterations", "1", at_least(1),
             "number of conjugate gradient iterations after which a linear solve has failed")});
  return table;
}

const FieldTable& ContactSettings::fields() {
  using S = ContactSettings;
  static const FieldTable table(
      "contact", TableKind::Settings,
      {field(&S::enabled, "enabled", "switch of all contact"),
       field(&S::self_contact, "self_contact", "switch of the contact of deformable bodies with themselves"),
       field(&S::friction, "friction", "switch of all friction"),
       field(&S::distance, "distance", "m", at_least(0.0),
             "contact distance of bodies without their own; two bodies act on each other within the sum of "
             "theirs; 0: automatic, 1 mm but at most 1 % of the size of the body and half the smallest "
             "height of triangles that can touch their own body, of which no less than a tenth of the rest "
             "counts"),
       field(&S::stiffness, "stiffness", "Pa", at_least(0.0),
             "contact stiffness of bodies without their own: the pressure at which the gap is half of the "
             "contact distance; 0: automatic, by the weight of the body"),
       field(&S::stiffness_factor, "stiffness_factor", "1", positive(),
             "automatic contact stiffness over the weight of the body per area: weight under standard "
             "gravity, half of the surface"),
       field(&S::min_separation_factor, "min_separation_factor", "1", open_interval(0.0, 0.5),
             "least distance of two surfaces, over the contact distance of the pair; in scenes that nothing "
             "drives, impacts on soft contact may go below it"),
       field(&S::stick_velocity, "stick_velocity", "m/s", positive(),
             "sliding speed below which friction sticks; times the time step it is the most that a sticking "
             "contact gives way"),
       field(&S::friction_updates, "friction_updates", "1", at_least(1),
             "largest number of times in a step that normal forces and tangents of friction are refreshed; "
             "fewer do when limits of friction settle to 0.1 %"),
       field(&S::released_overlap, "released_overlap",
             "what to do where joints and attachments release bodies that overlap: report (a caveat of every "
             "step until they are apart; contact comes back then) or refuse (the step is an error)")});
  return table;
}

const FieldTable& JointSettings::fields() {
  using S = JointSettings;
  static const FieldTable table(
      "joints", TableKind::Settings,
      {field(&S::length_tolerance, "length_tolerance", "m", positive(),
             "largest distance by which joints may be apart at the end of a step"),
       field(&S::angle_tolerance, "angle_tolerance", "rad", positive(),
             "largest angle by which the axes of joints may differ at the end of a step")});
  return table;
}

const FieldTable& ExecutionSettings::fields() {
  using S = ExecutionSettings;
  static const FieldTable table(
      "execution", TableKind::Settings,
      {field(&S::threads, "threads", "1", closed_interval(0, 1024),
             "most threads, 0 for one on each core that the process may use; results have the same bits for "
             "any number"),
       field(&S::oversubscribe, "oversubscribe",
             "take more threads than there are cores, too, which is slower: to test that nothing depends on "
             "their number"),
       field(&S::backend, "backend",
             "way energies are evaluated: machine code or interpreter, with the same bits")});
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
  if (settings.time.integrator == Integrator::Quasistatic && newton.residual_tolerance == 0.0 &&
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
