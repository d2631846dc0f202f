// Machine code of a program for x86-64, as bytes. Phase: kernel building.
#pragma once

#include <stark/symbolic/backend/machine_code.h>
#include <stark/symbolic/kernel.h>
#include <stark/symbolic/program.h>

namespace stark::symbolic {

/// Function of the System V convention: unknowns, elements, uniforms (AVX2: four copies of each; AVX-512:
/// one), outputs, block count, spill slots.
MachineCode assemble_x86_64(const Program& program, Backend backend);

}  // namespace stark::symbolic
