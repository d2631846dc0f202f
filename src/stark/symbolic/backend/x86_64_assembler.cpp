// Bytes of VEX and EVEX instructions. Checked against an independent disassembler in
// tests/python/test_encoder.py. Phase: kernel building.
#include <stark/symbolic/backend/x86_64_assembler.h>

namespace stark::symbolic {

void Assembler::word(int32_t value) {
  for (int k = 0; k < 4; ++k) byte(static_cast<uint32_t>(value) >> (8 * k) & 0xff);
}

void Assembler::quad(uint64_t value) {
  for (int k = 0; k < 8; ++k) byte(static_cast<int>(value >> (8 * k) & 0xff));
}

void Assembler::vector(Opcode op, int reg, int first, const VectorOperand& second, int immediate) {
  if (wide_) {
    evex(op, reg, first, second);
  } else {
    vex(op, reg, first, second);
  }
  if (immediate >= 0) byte(immediate);
}

// ModRM, SIB and displacement. EVEX displacements of one byte count in units of `scale` bytes.
void Assembler::mod_rm(int reg, const VectorOperand& second, int scale) {
  const int r = (reg & 7) << 3;
  if (!second.is_memory) {
    byte(0xc0 | r | (second.reg & 7));
    return;
  }
  const int base = static_cast<int>(second.base) & 7, d = second.displacement;
  const bool needs_sib = base == 4, needs_displacement = base == 5;
  const bool fits = d % scale == 0 && d / scale >= -128 && d / scale <= 127;
  const int mod = d == 0 && !needs_displacement ? 0 : (fits ? 1 : 2);
  byte(mod << 6 | r | base);
  if (needs_sib) byte(0x24);
  if (mod == 1) byte(d / scale & 0xff);
  if (mod == 2) word(d);
}

void Assembler::vex(Opcode op, int reg, int first, const VectorOperand& second) {
  const int rm = second.is_memory ? static_cast<int>(second.base) : second.reg;
  const int not_r = reg & 8 ? 0 : 0x80, not_b = rm & 8 ? 0 : 0x20, not_v = (~first & 15) << 3;
  constexpr int kLength256 = 4;
  if (op.map == 1 && op.vex_w == 0 && not_b) {
    byte(0xc5);
    byte(not_r | not_v | kLength256 | op.prefix);
  } else {
    byte(0xc4);
    byte(not_r | 0x40 | not_b | op.map);
    byte(op.vex_w << 7 | not_v | kLength256 | op.prefix);
  }
  byte(op.code);
  mod_rm(reg, second, 1);
}

void Assembler::evex(Opcode op, int reg, int first, const VectorOperand& second) {
  const int rm = second.is_memory ? static_cast<int>(second.base) : second.reg;
  const int not_r = reg & 8 ? 0 : 0x80, not_r4 = reg & 16 ? 0 : 0x10, not_b = rm & 8 ? 0 : 0x20;
  const int not_x = !second.is_memory && rm & 16 ? 0 : 0x40;
  byte(0x62);
  byte(not_r | not_x | not_b | not_r4 | op.map);
  byte(0x80 | (~first & 15) << 3 | 4 | op.prefix);
  byte(2 << 5 | (second.broadcast ? 0x10 : 0) | (first & 16 ? 0 : 8));
  byte(op.code);
  // vbroadcastsd reads one double, everything else a whole vector unless it broadcasts.
  const bool one_double = second.broadcast || (op.map == 2 && op.code == opcode::kBroadcast.code);
  mod_rm(reg, second, one_double ? 8 : 64);
}

void Assembler::move_immediate(Gpr reg, uint64_t value) {
  const int r = static_cast<int>(reg);
  byte(0x48 | r >> 3);
  byte(0xb8 | (r & 7));
  quad(value);
}

void Assembler::load_rip_relative(Gpr reg, int32_t displacement) {
  const int r = static_cast<int>(reg);
  byte(0x48 | (r >> 3) << 2);
  byte(0x8d);
  byte((r & 7) << 3 | 5);
  word(displacement);
}

void Assembler::add_immediate(Gpr reg, int32_t value) {
  const int r = static_cast<int>(reg);
  byte(0x48 | r >> 3);
  byte(0x81);
  byte(0xc0 | (r & 7));
  word(value);
}

void Assembler::clear(Gpr reg) {
  const int r = static_cast<int>(reg);
  if (r >> 3) byte(0x45);
  byte(0x31);
  byte(0xc0 | (r & 7) << 3 | (r & 7));
}

void Assembler::toggle_bit(Gpr reg) {
  const int r = static_cast<int>(reg);
  if (r >> 3) byte(0x41);
  byte(0x83);
  byte(0xf0 | (r & 7));
  byte(1);
}

void Assembler::decrement(Gpr reg) {
  const int r = static_cast<int>(reg);
  byte(0x48 | r >> 3);
  byte(0xff);
  byte(0xc8 | (r & 7));
}

void Assembler::test(Gpr reg) {
  const int r = static_cast<int>(reg);
  byte(0x48 | (r >> 3) << 2 | r >> 3);
  byte(0x85);
  byte(0xc0 | (r & 7) << 3 | (r & 7));
}

void Assembler::jump_if_not_zero(int target) {
  byte(0x0f);
  byte(0x85);
  word(target - (size() + 4));
}

int Assembler::jump_if_not_positive_forward() {
  byte(0x0f);
  byte(0x8e);
  word(0);
  return size() - 4;
}

void Assembler::patch(int place) { patch_word(place, size() - (place + 4)); }

void Assembler::patch_word(int place, int32_t value) {
  for (int k = 0; k < 4; ++k)
    bytes_[place + k] = static_cast<uint8_t>(static_cast<uint32_t>(value) >> (8 * k));
}

void Assembler::zero_upper() {
  for (const int b : {0xc5, 0xf8, 0x77}) byte(b);
}

void Assembler::ret() { byte(0xc3); }

void Assembler::align(int alignment) {
  while (size() % alignment) byte(0x90);
}

}  // namespace stark::symbolic
