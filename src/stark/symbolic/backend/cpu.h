// What this processor and operating system can execute. Phase: kernel building.
#pragma once

#include <stark/symbolic/kernel.h>

namespace stark::symbolic {

/// Whether the instructions of a machine-code back end exist here and the system saves their registers.
bool cpu_supports(Backend backend);

}  // namespace stark::symbolic
