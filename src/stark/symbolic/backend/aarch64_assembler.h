// Encoder of the AArch64 instructions that kernels use: Advanced SIMD on two doubles, and the few on general
// registers that a loop takes. [Arm Architecture Reference Manual for A-profile, C6 and C7] Phase: kernel
// building.
#pragma once

#include <cstdint>
#include <vector>

namespace stark::symbolic::aarch64 {

/// A general register by its number, 0 to 30.
enum class X : uint8_t {};

/// Instructions on vector registers Vd, Vn and Vm of two 64-bit lanes.
enum class Vector : uint32_t {
  Add = 0x4e60d400,
  Sub = 0x4ee0d400,
  Mul = 0x6e60dc00,
  Div = 0x6e60fc00,
  MulAdd = 0x4e60cc00,  ///< Vd += Vn Vm, one rounding
  MulSub = 0x4ee0cc00,  ///< Vd -= Vn Vm, one rounding
  Greater = 0x6ee0e400,
  GreaterEqual = 0x6e60e400,
  And = 0x4e201c00,
  AndNot = 0x4e601c00,  ///< Vn & ~Vm
  Or = 0x4ea01c00,
  Xor = 0x6e201c00,
  SelectByTarget = 0x6e601c00,  ///< Vd = Vd ? Vn : Vm
  InsertIfTrue = 0x6ea01c00,    ///< Vd = Vm ? Vn : Vd
  InsertIfFalse = 0x6ee01c00,   ///< Vd = Vm ? Vd : Vn
  AddInt = 0x4ee08400,
  SubInt = 0x6ee08400,
};

/// Instructions with one source, Vn.
enum class Unary : uint32_t {
  Sqrt = 0x6ee1f800,
  Negate = 0x6ee0f800,
  Round = 0x4e618800,  ///< to the nearest integer, ties to even
};

class Assembler {
 public:
  const std::vector<uint8_t>& bytes() const { return bytes_; }
  int size() const { return static_cast<int>(bytes_.size()); }

  void vector(Vector op, int d, int n, int m);
  void vector(Unary op, int d, int n);
  void move(int d, int n);
  /// Each lane by `count` bits, 1 to 63.
  void shift_left(int d, int n, int count);
  void shift_right(int d, int n, int count);

  /// Vd from or to [base + offset], 16 bytes; `offset` is a multiple of 16, not negative. Far ones use
  /// `scratch`.
  void load(int d, X base, int offset, X scratch);
  void store(int d, X base, int offset, X scratch);

  /// base += value; large values use `scratch`.
  void add_immediate(X base, int64_t value, X scratch);
  void move_immediate(X d, uint32_t value);
  void compare_zero(X n);
  void return_if_not_positive();  ///< of what was compared
  void branch_if_not_zero(X n, int target);
  void ret();
  void align(int alignment);
  void quad(uint64_t value);

 private:
  void word(uint32_t value);
  void access(uint32_t scaled, uint32_t indexed, int d, X base, int offset, X scratch);

  std::vector<uint8_t> bytes_;
};

}  // namespace stark::symbolic::aarch64
