// From values to registers and memory: furthest next use [Belady 1966] over one straight line of code.
// Phase: kernel building.
#pragma once

#include <stark/symbolic/program.h>

#include <cstdint>
#include <vector>

namespace stark::symbolic {

enum class Home : uint8_t { Register, Constant, Unknown, Element, Uniform, Spill, Output };

struct Location {
  Home home = Home::Register;
  int32_t index = 0;
  bool is_memory() const { return home != Home::Register; }
};

struct MachineStep {
  enum class Kind : uint8_t { Load, Store, Move, Operate };
  Kind kind = Kind::Operate;
  Code code = Code::Add;
  uint8_t shift = 0;
  uint8_t target = 0;     // register (Load, Move, Operate)
  int8_t destroyed = -1;  // operand whose register is the target, where the instruction overwrites one
  Location operands[3];   // Load: [0] memory; Store: [0] memory, register in target; Move: [0] register
};

struct Allocation {
  std::vector<MachineStep> steps;
  int spill_count = 0;
};

/// At most one operand of a step is in memory. select_overwrites: Select overwrites one of its operands.
Allocation allocate_registers(const Program& program, int register_count, bool select_overwrites);

}  // namespace stark::symbolic
