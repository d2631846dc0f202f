// All settings of a simulation: plain aggregates with a descriptor table each (base/settings.h), from which
// validation, assignment by dotted name, files, printing and the reference table derive. Phase: before the
// first time step.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include <stark/base/math.h>
#include <stark/base/settings.h>
#include <stark/linalg/linear_solver.h>
#include <stark/solve/newton_settings.h>

namespace stark {

/// Implicit Euler, backward differences of order 2, or a sequence of equilibria without inertia.
enum class Integrator : uint8_t { ImplicitEuler, Bdf2, Quasistatic };
/// What happens where joints and attachments release bodies that overlap: a caveat of every step until they
/// are apart, or an error.
enum class ReleasedOverlap : uint8_t { Report, Refuse };
/// How energies are evaluated; same order as symbolic::Backend. The interpreter gives the same bits as
/// machine code.
enum class KernelBackend : uint8_t { Automatic, Interpreter, Avx2, Avx512 };

template <>
struct EnumNames<Integrator> {
  static constexpr std::array<std::string_view, 3> kNames{"implicit_euler", "bdf2", "quasistatic"};
};
template <>
struct EnumNames<ReleasedOverlap> {
  static constexpr std::array<std::string_view, 2> kNames{"report", "refuse"};
};
template <>
struct EnumNames<KernelBackend> {
  static constexpr std::array<std::string_view, 4> kNames{"automatic", "interpreter", "avx2", "avx512"};
};
template <>
struct EnumNames<LinearSolverKind> {
  static constexpr std::array<std::string_view, 4> kNames{"automatic", "cholesky", "cholesky_float", "pcg"};
};

struct TimeSettings {
  double step = 1.0 / 60.0;  ///< [s] length of a time step
  double min_step = 1e-6;    ///< [s] a failing step is halved down to this, then reported as failed
  double growth = 2.0;       ///< factor by which a halved step grows again after an accepted one
  Integrator integrator = Integrator::ImplicitEuler;
  static const FieldTable& fields();
};

struct LinearSettings {
  LinearSolverKind solver = LinearSolverKind::Automatic;
  double pcg_tolerance = 1e-4;  ///< relative residual
  int pcg_max_iterations = 10000;
  static const FieldTable& fields();
};

struct ContactSettings {
  bool enabled = true;
  bool self_contact = true;  ///< false switches the self-contact of all bodies off
  bool friction = true;
  double distance =
      0.0;  ///< [m] of bodies without their own, 0: automatic; a pair acts within the sum of the two
  /// [Pa] pressure at half the contact distance of bodies without their own; 0: by their weight
  double stiffness = 0.0;
  double stiffness_factor = 100.0;  ///< automatic stiffness over the weight of a body per area
  double min_separation_factor =
      1e-3;  ///< distance kept by the collision detection, over the pair's contact distance
  double stick_velocity = 1e-3;  ///< [m/s] below it friction is sticking, regularised
  int friction_updates = 8;      ///< most refreshes of normal forces and tangents of friction in a step
  ReleasedOverlap released_overlap = ReleasedOverlap::Report;
  static const FieldTable& fields();
};

struct JointSettings {
  double length_tolerance = 1e-6;  ///< [m] by which joints may be apart in an accepted step
  double angle_tolerance = 1e-5;   ///< [rad] by which the axes of joints may differ
  static const FieldTable& fields();
};

struct ExecutionSettings {
  int threads = 1;             ///< 0: one for each core; results have the same bits for any number
  bool oversubscribe = false;  ///< more threads than cores
  KernelBackend backend = KernelBackend::Automatic;
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
