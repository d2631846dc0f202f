// One thread at a time. A step runs without the GIL, so that other threads of Python go on; whatever they ask
// of the simulation meanwhile is refused, as it would read and write what the step works on. Arrays that were
// handed out are copies and do not change. Every file that binds functions of simulations includes this one:
// the caster at its end is the door that all of their calls go through.
#pragma once

#include <nanobind/nanobind.h>

#include <stark/sim/simulation.h>

namespace stark::bindings {

/// Throws Error while a step of the simulation is under way; names its thread. Call it with the GIL.
void require_at_rest(const Simulation& simulation);

/// While it lives, a step of the simulation is under way. Made and destroyed with the GIL.
class Stepping {
 public:
  explicit Stepping(const Simulation& simulation);
  ~Stepping();
  Stepping(const Stepping&) = delete;
  Stepping& operator=(const Stepping&) = delete;

 private:
  const Simulation& simulation_;
};

}  // namespace stark::bindings

namespace nanobind::detail {

template <>
struct type_caster<stark::Simulation> : type_caster_base<stark::Simulation> {
  using Base = type_caster_base<stark::Simulation>;
  operator stark::Simulation*() { return &checked(); }
  operator stark::Simulation&() { return checked(); }
  operator stark::Simulation&&() { return std::move(checked()); }

 private:
  stark::Simulation& checked() {
    auto& simulation = Base::operator stark::Simulation&();
    stark::bindings::require_at_rest(simulation);
    return simulation;
  }
};

}  // namespace nanobind::detail
