// Machine code of a program as bytes, also for processors that are not here. Phase: kernel building.
#pragma once

#include <cstdint>
#include <vector>

namespace stark::symbolic {

struct MachineCode {
  std::vector<uint8_t> bytes;  ///< position independent: instructions, then constants
  int instruction_bytes = 0;
  int first_constant = 0;  ///< where constants start in `bytes`
  int spill_count = 0;
};

}  // namespace stark::symbolic
