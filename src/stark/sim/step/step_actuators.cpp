// Actuators in a step: inputs at its start, efforts and memories at its end.
#include <algorithm>

#include <stark/base/rotation.h>
#include <stark/sim/step/step_joints.h>

namespace stark {

namespace {

/// Way beyond a stop, over the tolerance of joints, from which it is hit: what rests there moves by less.
constexpr double kArrival = 5.0;

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

bool StepJoints::is_of_actuators(const ConstraintGroup& group) const {
  const size_t number = group.joints.front(), joints = scene_.joints().size();
  return number >= joints && number < joints + scene_.actuators().size();
}

void StepJoints::begin_actuators(double h) {
  if (scene_.actuators().empty()) return;
  const std::vector<double> on = acting();
  // What rates are measured from: the start of the step, or what BDF2 takes for it.
  const std::vector<double> raw = motion_.coordinates(),
                            start = energies_.constraints.coordinates(step_start_);
  const auto joints = static_cast<int32_t>(scene_.joints().size());
  for (ConstraintGroup& group : energies_.constraints.groups()) {
    if (!is_of_actuators(group)) continue;
    const ActuatorFields fields(group);
    for (int64_t e = 0; e < group.batch.size(); ++e) {
      const int32_t number = group.joints[e];
      const ModelActuator& actuator = model_.actuators()[number - joints];
      set(group.batch, fields.active, e, on[number]);
      set(group.batch, fields.duration, e, h);
      for (size_t c = 0; c < actuator.coordinates.size(); ++c) {
        const int64_t q = actuator.coordinates[c];
        set(group.batch, fields.raw_start[c], e, raw[q]);
        const double change = raw[q] - start[q];
        set(group.batch, fields.start[c], e,
            state_.joint_coordinate[q] + (actuator.is_angle[c] ? shortest_turn(change) : change));
        set(group.batch, fields.rate[c], e, motion_.reference().joint_rate[q]);
      }
      for (size_t v = 0; v < fields.values.size(); ++v)
        set(group.batch, fields.values[v], e, state_.actuator_value[actuator.value + v]);
      for (size_t m = 0; m < fields.memories.size(); ++m)
        set(group.batch, fields.memories[m], e, state_.actuator_memory[actuator.memory + m]);
    }
  }
}

bool StepJoints::hits_stop(double h) const {
  if (!has_history(settings_.time.integrator)) return false;
  const MotionReference& r = motion_.reference();
  const ConstraintTolerance tolerance = joint_tolerance(settings_.joints);
  std::vector<double> on;
  std::vector<Vec3> other;  // where the sites were a step ago, or where they go
  for (const ConstraintGroup& group : energies_.constraints.groups()) {
    if (!has_stops(group)) continue;
    if (on.empty()) {
      on = acting();
      other = r.before.empty() ? motion_.free_motion(h) : r.before;
    }
    const std::vector<double> now = group.batch.evaluate(group.joint->values(), step_start_),
                              then = group.batch.evaluate(group.joint->values(), other);
    const size_t outputs = now.size() / group.batch.size(), rows = group.joint->units().size();
    for (size_t k = 0; k < outputs * group.joints.size(); ++k) {
      const size_t row = k % outputs;
      if (row >= rows || group.joint->one_sided()[row] == 0 || on[group.joints[k / outputs]] == 0.0) continue;
      const double least = kArrival * tolerance.of(group.joint->units()[row]);
      // Differences of the last step, not velocities: on a taut rope those have an error of second order that
      // leads through the stop in every step. Without a last step only a stop that is open may be hit.
      const bool is_hit = r.before.empty() ? now[k] < -least && then[k] > least
                                           : now[k] + (now[k] - then[k]) * (h / r.since_before) > least;
      if (is_hit) return true;
    }
  }
  return false;
}

void StepJoints::commit_actuators(std::span<const Vec3> x) {
  const auto joints = static_cast<int32_t>(scene_.joints().size());
  for (const ConstraintGroup& group : energies_.constraints.groups()) {
    if (!is_of_actuators(group)) continue;
    const std::vector<double> values = group.batch.evaluate(group.joint->values(), x);
    const size_t outputs = values.size() / group.batch.size(), rows = group.joint->units().size();
    for (int64_t e = 0; e < group.batch.size(); ++e) {
      const ModelActuator& actuator = model_.actuators()[group.joints[e] - joints];
      const double* value = values.data() + e * outputs + rows;
      const size_t efforts = actuator.coordinates.size(), memories = actuator.law->memories().size();
      std::copy_n(value, efforts, state_.actuator_effort.begin() + actuator.effort);
      std::copy_n(value + efforts, memories, state_.actuator_memory.begin() + actuator.memory);
    }
  }
}

double actuator_power(const ModelActuator& actuator, const State& state) {
  double power = 0.0;
  for (size_t c = 0; c < actuator.coordinates.size(); ++c)
    power += state.actuator_effort[actuator.effort + c] * state.joint_rate[actuator.coordinates[c]];
  return power;
}

double actuator_work(const ModelActuator& actuator, const State& state, std::span<const double> before) {
  double work = 0.0;
  for (size_t c = 0; c < actuator.coordinates.size(); ++c) {
    const int64_t q = actuator.coordinates[c];
    work += state.actuator_effort[actuator.effort + c] * (state.joint_coordinate[q] - before[q]);
  }
  return work;
}

}  // namespace stark
