// Machine code of a program for AArch64 with Advanced SIMD. Phase: kernel building.
#pragma once

#include <stark/symbolic/backend/machine_code.h>
#include <stark/symbolic/program.h>

namespace stark::symbolic {

/// Function of the procedure call standard: unknowns, elements, uniforms (two copies of each), outputs, block
/// count, spill slots of two doubles, constants (two copies of each).
MachineCode assemble_aarch64(const Program& program);

}  // namespace stark::symbolic
