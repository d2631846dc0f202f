// Straight-line code over lanes: what every back end executes. One instruction is one IEEE operation (or one
// bitwise or integer operation on 64-bit lanes), so all back ends give the same bits. Phase: kernel building.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace stark::symbolic {

enum class Code : uint8_t {
  Add,
  Sub,
  Mul,
  Div,
  Min,
  Max,  // a < b ? a : b and a > b ? a : b, also for NaN and zeros
  MulAdd,
  MulSub,
  NegMulAdd,  // a b + c, a b - c, c - a b, one rounding
  Sqrt,
  Round,  // Round: to the nearest integer, ties to even
  Less,
  LessEqual,  // all ones or all zeros; false for NaN
  Select,     // a ? b : c with a full mask a
  And,
  Or,
  Xor,
  AndNot,  // AndNot: ~a & b
  AddInt,
  SubInt,
  ShiftLeft,
  ShiftRight  // 64-bit integers; shifts by `shift`, logical
};

constexpr int operand_count(Code code) {
  if (code == Code::Sqrt || code == Code::Round || code >= Code::ShiftLeft) return 1;
  return (code >= Code::MulAdd && code <= Code::NegMulAdd) || code == Code::Select ? 3 : 2;
}

enum class Space : uint8_t { None, Value, Constant, Unknown, Element, Uniform };

struct Operand {
  Space space = Space::None;
  int32_t index = 0;
  bool operator==(const Operand&) const = default;
};

/// Computes value number i, where i is its place in Program::instructions.
struct Instruction {
  Code code = Code::Add;
  uint8_t shift = 0;
  Operand operands[3];
};

struct Program {
  std::vector<Instruction> instructions;
  std::vector<uint64_t> constants;  // bits
  std::vector<Operand> outputs;
  int unknown_count = 0, element_count = 0, uniform_count = 0;
};

/// Changes the order of the instructions so that fewer values are alive at once; results keep their bits.
void reorder(Program& program);

using LowId = int32_t;

/// Hash-consing builder of programs. Ids are in topological order; leaves are ids too.
class ProgramBuilder {
 public:
  ProgramBuilder();

  LowId constant(double value);
  LowId bits(uint64_t value);
  LowId input(Space space, int index);
  LowId emit(Code code, LowId a, LowId b = -1, LowId c = -1, int shift = 0);

  LowId add(LowId a, LowId b) { return emit(Code::Add, a, b); }
  LowId sub(LowId a, LowId b) { return emit(Code::Sub, a, b); }
  LowId mul(LowId a, LowId b) { return emit(Code::Mul, a, b); }
  LowId div(LowId a, LowId b) { return emit(Code::Div, a, b); }
  LowId mul_add(LowId a, LowId b, LowId c) { return emit(Code::MulAdd, a, b, c); }
  LowId mul_sub(LowId a, LowId b, LowId c) { return emit(Code::MulSub, a, b, c); }
  LowId neg_mul_add(LowId a, LowId b, LowId c) { return emit(Code::NegMulAdd, a, b, c); }
  LowId negate(LowId a) { return emit(Code::Xor, a, bits(0x8000000000000000ull)); }
  LowId select(LowId mask, LowId a, LowId b);

  /// Puts the needed operations in an order that keeps few values alive.
  Program finish(std::span<const LowId> outputs) const;

 private:
  struct Item {
    Space space = Space::None;  // Value: an operation
    Code code = Code::Add;
    uint8_t shift = 0;
    LowId operands[3] = {-1, -1, -1};
    uint64_t payload = 0;  // bits of a constant or number of an input
    bool operator==(const Item&) const = default;
  };
  LowId intern(const Item& item);
  static uint64_t hash(const Item& item);

  std::vector<Item> items_;
  std::vector<LowId> table_;
};

}  // namespace stark::symbolic
