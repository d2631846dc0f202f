#include "stepping.h"

#include <map>
#include <string>

#include <stark/base/error.h>

#include "arrays.h"

namespace stark::bindings {

namespace {

namespace nb = nanobind;

/// Simulations inside a step, and the threads that step them. The GIL guards it.
std::map<const Simulation*, unsigned long>& under_way() {
  static std::map<const Simulation*, unsigned long> steps;
  return steps;
}

/// The simulation is inside a step of the thread `ident`.
[[noreturn]] void refuse(unsigned long ident) {
  if (ident == PyThread_get_thread_ident())
    throw Error(
        "the simulation is inside step(), which has called this function (a progress callback or a signal "
        "handler): leave it alone until the step is over; what is known of the step is in the callback's "
        "argument");
  for (const nb::handle thread : nb::module_::import_("threading").attr("enumerate")())
    if (nb::cast<unsigned long>(thread.attr("ident")) == ident)
      throw Error(
          "the simulation is inside step() of the thread '" + text(thread.attr("name")) +
          "': wait until it returns, or share a lock (with threading.Lock()); simulations of their own "
          "can be stepped by several threads at once");
  throw Error(
      "the simulation is inside step() of a thread that this process does not have, as it was forked "
      "meanwhile: "
      "make another simulation here, or fork between steps");
}

}  // namespace

void require_at_rest(const Simulation& simulation) {
  if (under_way().empty()) return;
  const auto step = under_way().find(&simulation);
  if (step != under_way().end()) refuse(step->second);
}

Stepping::Stepping(const Simulation& simulation) : simulation_(simulation) {
  under_way().emplace(&simulation, PyThread_get_thread_ident());
}

Stepping::~Stepping() { under_way().erase(&simulation_); }

}  // namespace stark::bindings
