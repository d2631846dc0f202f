// Words of AArch64 instructions. Checked against an independent disassembler in
// tests/python/test_encoder.py. Phase: kernel building.
#include <stark/symbolic/backend/aarch64_assembler.h>

namespace stark::symbolic::aarch64 {

namespace {

constexpr uint32_t kLargestScaled = 4095;  // of the 12-bit offsets and immediates

uint32_t number(X x) { return static_cast<uint32_t>(x); }
uint32_t at(int reg, int shift) { return static_cast<uint32_t>(reg) << shift; }

}  // namespace

void Assembler::word(uint32_t value) {
  for (int k = 0; k < 4; ++k) bytes_.push_back(static_cast<uint8_t>(value >> (8 * k)));
}

void Assembler::quad(uint64_t value) {
  word(static_cast<uint32_t>(value));
  word(static_cast<uint32_t>(value >> 32));
}

void Assembler::vector(Vector op, int d, int n, int m) {
  word(static_cast<uint32_t>(op) | at(m, 16) | at(n, 5) | at(d, 0));
}

void Assembler::vector(Unary op, int d, int n) { word(static_cast<uint32_t>(op) | at(n, 5) | at(d, 0)); }

void Assembler::move(int d, int n) { vector(Vector::Or, d, n, n); }

void Assembler::shift_left(int d, int n, int count) {
  word(0x4f005400 | at(64 + count, 16) | at(n, 5) | at(d, 0));
}

void Assembler::shift_right(int d, int n, int count) {
  word(0x6f000400 | at(128 - count, 16) | at(n, 5) | at(d, 0));
}

void Assembler::access(uint32_t scaled, uint32_t indexed, int d, X base, int offset, X scratch) {
  const uint32_t places = number(base) << 5 | at(d, 0), units = static_cast<uint32_t>(offset) / 16;
  if (units <= kLargestScaled) {
    word(scaled | units << 10 | places);
    return;
  }
  move_immediate(scratch, static_cast<uint32_t>(offset));
  word(indexed | number(scratch) << 16 | places);
}

void Assembler::load(int d, X base, int offset, X scratch) {
  access(0x3dc00000, 0x3ce06800, d, base, offset, scratch);
}

void Assembler::store(int d, X base, int offset, X scratch) {
  access(0x3d800000, 0x3ca06800, d, base, offset, scratch);
}

void Assembler::move_immediate(X d, uint32_t value) {
  word(0xd2800000 | (value & 0xffff) << 5 | number(d));                // movz
  if (value >> 16) word(0xf2a00000 | (value >> 16) << 5 | number(d));  // movk, lsl 16
}

void Assembler::add_immediate(X base, int64_t value, X scratch) {
  const bool is_negative = value < 0;
  const auto size = static_cast<uint32_t>(is_negative ? -value : value);
  const uint32_t places = number(base) << 5 | number(base);
  if (size <= kLargestScaled) {
    word((is_negative ? 0xd1000000 : 0x91000000) | size << 10 | places);
    return;
  }
  move_immediate(scratch, size);
  word((is_negative ? 0xcb000000 : 0x8b000000) | number(scratch) << 16 | places);
}

void Assembler::compare_zero(X n) { word(0xf100001f | number(n) << 5); }

void Assembler::return_if_not_positive() {
  word(0x5400004c);  // b.gt, past the return
  ret();
}

void Assembler::branch_if_not_zero(X n, int target) {
  word(0xb4000040 | number(n));  // cbz, past the branch, which reaches 128 MB
  word(0x14000000 | (static_cast<uint32_t>((target - size()) / 4) & 0x3ffffff));
}

void Assembler::ret() { word(0xd65f03c0); }

void Assembler::align(int alignment) {
  while (size() % alignment) word(0xd503201f);  // nop
}

}  // namespace stark::symbolic::aarch64
