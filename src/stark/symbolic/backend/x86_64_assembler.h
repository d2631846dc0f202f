// Encoder of the vector instructions that kernels use: VEX (AVX2, FMA; 256 bits) and EVEX (AVX-512 F and DQ;
// 512 bits). [Intel SDM vol. 2, 2.3 and 2.7] Phase: kernel building.
#pragma once

#include <cstdint>
#include <vector>

namespace stark::symbolic {

/// General registers by their number in the instruction set.
enum class Gpr : uint8_t { Rax, Rcx, Rdx, Rbx, Rsp, Rbp, Rsi, Rdi, R8, R9, R10, R11, R12, R13, R14, R15 };

/// Vector register or memory [base + displacement]; broadcast: one double for all lanes (EVEX only).
struct VectorOperand {
  bool is_memory = false;
  uint8_t reg = 0;
  Gpr base = Gpr::Rax;
  int32_t displacement = 0;
  bool broadcast = false;

  static VectorOperand in_register(int reg) { return {false, static_cast<uint8_t>(reg), Gpr::Rax, 0, false}; }
  static VectorOperand in_memory(Gpr base, int32_t displacement, bool broadcast = false) {
    return {true, 0, base, displacement, broadcast};
  }
};

/// Opcode with its map (1: 0F, 2: 0F38, 3: 0F3A) and prefix (0: none, 1: 66, 2: F3, 3: F2). EVEX.W is vex_w
/// or 1.
struct Opcode {
  uint8_t map, prefix, code;
  uint8_t vex_w = 0;
};

namespace opcode {
inline constexpr Opcode kAdd{1, 1, 0x58}, kMul{1, 1, 0x59}, kSub{1, 1, 0x5c}, kMin{1, 1, 0x5d},
    kDiv{1, 1, 0x5e}, kMax{1, 1, 0x5f}, kSqrt{1, 1, 0x51}, kAnd{1, 1, 0x54}, kAndNot{1, 1, 0x55},
    kOr{1, 1, 0x56}, kXor{1, 1, 0x57}, kLoad{1, 1, 0x10}, kStore{1, 1, 0x11}, kMove{1, 1, 0x28},
    kCompare{1, 1, 0xc2}, kAddInt{1, 1, 0xd4}, kSubInt{1, 1, 0xfb}, kShiftImmediate{1, 1, 0x73},
    kRound{3, 1, 0x09}, kBlend{3, 1, 0x4b}, kTernary{3, 1, 0x25, 1}, kBroadcast{2, 1, 0x19},
    kMaskToVector{2, 2, 0x38, 1};
/// Fused multiply-add families: 132 is the base code, 213 is base + 0x10, 231 is base + 0x20.
inline constexpr Opcode kMulAdd{2, 1, 0x98, 1}, kMulSub{2, 1, 0x9a, 1}, kNegMulAdd{2, 1, 0x9c, 1};
}  // namespace opcode

class Assembler {
 public:
  /// wide: EVEX with 512 bits and registers 0-31; else VEX with 256 bits and registers 0-15.
  explicit Assembler(bool wide) : wide_(wide) {}

  const std::vector<uint8_t>& bytes() const { return bytes_; }
  int size() const { return static_cast<int>(bytes_.size()); }
  bool wide() const { return wide_; }

  /// reg <- op(first, second), with an immediate byte where immediate >= 0. first = 0 where the instruction
  /// has only one source.
  void vector(Opcode op, int reg, int first, const VectorOperand& second, int immediate = -1);

  void move_immediate(Gpr reg, uint64_t value);
  void load_rip_relative(Gpr reg, int32_t displacement);  // lea reg, [rip + displacement]
  void add_immediate(Gpr reg, int32_t value);
  void clear(Gpr reg);                 // xor r32, r32
  void toggle_bit(Gpr reg);            // xor r32, 1; sets the zero flag
  void decrement(Gpr reg);             // sets the zero flag
  void test(Gpr reg);                  // test r64, r64
  void jump_if_not_zero(int target);   // to an earlier position
  int jump_if_not_positive_forward();  // returns the place of the displacement, for patch()
  void patch(int place);               // makes the jump land here
  void zero_upper();
  void ret();
  void align(int alignment);
  void quad(uint64_t value);
  void patch_word(int place, int32_t value);

 private:
  void byte(int value) { bytes_.push_back(static_cast<uint8_t>(value)); }
  void word(int32_t value);
  void vex(Opcode op, int reg, int first, const VectorOperand& second);
  void evex(Opcode op, int reg, int first, const VectorOperand& second);
  void mod_rm(int reg, const VectorOperand& second, int scale);

  bool wide_;
  std::vector<uint8_t> bytes_;
};

}  // namespace stark::symbolic
