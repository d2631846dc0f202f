// What the energies of elements store: the energy of a step from x to x, one too short for internal variables
// to change and for potentials of rates, which have its length as a factor, to count. [theory eq. 10c]
#pragma once

#include <algorithm>
#include <optional>
#include <span>

#include <stark/sim/model/energies.h>

namespace stark {

inline const PotentialBatch& law_of(const PotentialBatch& batch) { return batch; }
inline const PotentialBatch& law_of(const QuadratureBatch& batch) { return batch.law(); }

/// Whether an energy uses where its points were at the start of the step.
inline bool remembers(const PotentialBatch& batch) {
  return std::ranges::any_of(batch.potential().element_fields(), [](const ElementField& field) {
    return field.source == ElementField::Source::Previous;
  });
}

/// What a batch has as length of the step and time at its end; 0 where its energy does not use it [s].
struct StepClock {
  explicit StepClock(const PotentialBatch& law) {
    for (const UniformField& field : law.potential().uniform_fields()) {
      if (field.name == "time_step") step = law.uniform_values()[field.offset];
      if (field.name == "time") time = law.uniform_values()[field.offset];
    }
  }
  double step = 0.0, time = 0.0;
};

/// A batch has another time as long as this lives; nothing to do where its energy does not use it.
template <typename Batch>
class AtTime {
 public:
  AtTime(Batch& batch, double time) : batch_(batch), clock_(law_of(batch)) {
    batch_.set_time(clock_.step, time);
  }
  ~AtTime() { batch_.set_time(clock_.step, clock_.time); }
  AtTime(const AtTime&) = delete;
  AtTime& operator=(const AtTime&) = delete;

 private:
  Batch& batch_;
  StepClock clock_;
};

/// What internal variables can do in so short a step is below rounding, while rates of what does not change
/// stay zero. [s] of a step of one second or of more.
inline constexpr double kInstant = 0x1p-40;
/// The same where forces are asked for, to single precision: rounding of positions over the instant shall not
/// show as a force of dampers.
inline constexpr double kInstantOfForces = 0x1p-24;

/// A batch takes steps from x that are an instant long as long as this lives: its energy is what it stores.
/// It keeps the previous positions at x.
template <typename Batch>
class AtRest {
 public:
  AtRest(Batch& batch, std::span<const Vec3> x, double instant = kInstant) : batch_(batch) {
    batch_.set_previous(x);
    if (potential_of(batch).internal_width() == 0 && !remembers(law_of(batch))) return;  // no rates
    clock_.emplace(law_of(batch));
    const double step = clock_->step > 0.0 ? std::min(clock_->step, 1.0) : 1.0;  // 0 before the first one
    batch_.set_time(instant * step, clock_->time);
  }
  ~AtRest() {
    if (clock_) batch_.set_time(clock_->step, clock_->time);
  }
  AtRest(const AtRest&) = delete;
  AtRest& operator=(const AtRest&) = delete;

 private:
  Batch& batch_;
  std::optional<StepClock> clock_;  ///< of energies with rates
};

}  // namespace stark
