// Machine code for AVX2 + FMA and for AVX-512. A block of eight lanes is one pass with 512-bit registers or
// two passes of four lanes with 256-bit registers. Every operation is the same IEEE operation on both and in
// the interpreter. Phase: kernel building.
#include <stark/symbolic/backend/x86_64.h>

#include <stark/base/error.h>
#include <stark/symbolic/backend/executable.h>
#include <stark/symbolic/backend/executable_memory.h>
#include <stark/symbolic/backend/register_allocation.h>
#include <stark/symbolic/backend/x86_64_assembler.h>

#include <utility>

namespace stark::symbolic {

namespace {

using Function = void (*)(const double* unknowns, const double* elements, const double* uniforms,
                          double* out_values, int64_t block_count, double* spills);

// Arguments of the System V calling convention, and registers that a callee may use.
constexpr Gpr kUnknowns = Gpr::Rdi, kElements = Gpr::Rsi, kUniforms = Gpr::Rdx, kOutputs = Gpr::Rcx,
              kBlocks = Gpr::R8, kSpills = Gpr::R9, kConstants = Gpr::Rax, kHalf = Gpr::R10;

constexpr int kBlockBytes = kLanes * 8;
// Bases point this far into their arrays, so that one-byte displacements reach entries on both sides.
constexpr int kBias = 128;
constexpr int kMaskRegister = 1;                // k1
constexpr int kLess = 0x11, kLessEqual = 0x12;  // ordered, quiet
constexpr int kNearestEven = 8;

class CodeWriter {
 public:
  CodeWriter(const Program& program, bool wide) : program_(program), code_(wide), wide_(wide) {}
  MachineCode write();

 private:
  VectorOperand operand(const Location& l) const;
  VectorOperand reg(int r) const { return VectorOperand::in_register(r); }
  void write_step(const MachineStep& s);
  void operate(const MachineStep& s);
  void fused(const MachineStep& s, Opcode op);
  void select(const MachineStep& s);

  const Program& program_;
  Assembler code_;
  bool wide_;
};

VectorOperand CodeWriter::operand(const Location& l) const {
  const int bias = wide_ ? 0 : kBias;
  const int vector_bytes = wide_ ? 64 : 32;
  switch (l.home) {
    case Home::Register:
      return VectorOperand::in_register(l.index);
    case Home::Unknown:
      return VectorOperand::in_memory(kUnknowns, l.index * kBlockBytes - bias);
    case Home::Element:
      return VectorOperand::in_memory(kElements, l.index * kBlockBytes - bias);
    case Home::Output:
      return VectorOperand::in_memory(kOutputs, l.index * kBlockBytes - bias);
    case Home::Spill:
      return VectorOperand::in_memory(kSpills, l.index * vector_bytes - bias);
    case Home::Uniform:
      return VectorOperand::in_memory(kUniforms, l.index * (wide_ ? 8 : 32) - bias, wide_);
    case Home::Constant:
      return VectorOperand::in_memory(kConstants, l.index * (wide_ ? 8 : 32) - bias, wide_);
  }
  throw InternalError("CodeWriter: unknown location.");
}

void CodeWriter::write_step(const MachineStep& s) {
  const VectorOperand first = operand(s.operands[0]);
  switch (s.kind) {
    case MachineStep::Kind::Load:
      if (first.broadcast) {
        code_.vector(opcode::kBroadcast, s.target, 0,
                     VectorOperand::in_memory(first.base, first.displacement));
      } else {
        code_.vector(opcode::kLoad, s.target, 0, first);
      }
      break;
    case MachineStep::Kind::Store:
      code_.vector(opcode::kStore, s.target, 0, first);
      break;
    case MachineStep::Kind::Move:
      code_.vector(opcode::kMove, s.target, 0, first);
      break;
    case MachineStep::Kind::Operate:
      operate(s);
      break;
  }
}

void CodeWriter::operate(const MachineStep& s) {
  VectorOperand a = operand(s.operands[0]);
  VectorOperand b = operand(s.operands[1]);
  // Only commutative instructions come with their first operand in memory.
  if (a.is_memory && operand_count(s.code) == 2) std::swap(a, b);
  const auto binary = [&](Opcode op) { code_.vector(op, s.target, a.reg, b); };
  switch (s.code) {
    case Code::Add:
      binary(opcode::kAdd);
      break;
    case Code::Sub:
      binary(opcode::kSub);
      break;
    case Code::Mul:
      binary(opcode::kMul);
      break;
    case Code::Div:
      binary(opcode::kDiv);
      break;
    case Code::Min:
      binary(opcode::kMin);
      break;
    case Code::Max:
      binary(opcode::kMax);
      break;
    case Code::And:
      binary(opcode::kAnd);
      break;
    case Code::Or:
      binary(opcode::kOr);
      break;
    case Code::Xor:
      binary(opcode::kXor);
      break;
    case Code::AndNot:
      binary(opcode::kAndNot);
      break;
    case Code::AddInt:
      binary(opcode::kAddInt);
      break;
    case Code::SubInt:
      binary(opcode::kSubInt);
      break;
    case Code::MulAdd:
      fused(s, opcode::kMulAdd);
      break;
    case Code::MulSub:
      fused(s, opcode::kMulSub);
      break;
    case Code::NegMulAdd:
      fused(s, opcode::kNegMulAdd);
      break;
    case Code::Sqrt:
      code_.vector(opcode::kSqrt, s.target, 0, a);
      break;
    case Code::Round:
      code_.vector(opcode::kRound, s.target, 0, a, kNearestEven);
      break;
    case Code::ShiftLeft:
      code_.vector(opcode::kShiftImmediate, 6, s.target, a, s.shift);
      break;
    case Code::ShiftRight:
      code_.vector(opcode::kShiftImmediate, 2, s.target, a, s.shift);
      break;
    case Code::Less:
    case Code::LessEqual: {
      const int predicate = s.code == Code::Less ? kLess : kLessEqual;
      code_.vector(opcode::kCompare, wide_ ? kMaskRegister : s.target, a.reg, b, predicate);
      if (wide_) code_.vector(opcode::kMaskToVector, s.target, 0, reg(kMaskRegister));
      break;
    }
    case Code::Select:
      select(s);
      break;
  }
}

// a b + c in the form whose overwritten operand is the target: 213 (a), 132 (a, with b in memory), 231 (c).
void CodeWriter::fused(const MachineStep& s, Opcode op) {
  VectorOperand a = operand(s.operands[0]), b = operand(s.operands[1]);
  const VectorOperand c = operand(s.operands[2]);
  const auto form = [&](int offset) {
    Opcode o = op;
    o.code = static_cast<uint8_t>(o.code + offset);
    return o;
  };
  if (s.destroyed == 2) {
    if (a.is_memory) std::swap(a, b);
    code_.vector(form(0x20), s.target, a.reg, b);
    return;
  }
  if (s.destroyed == 1) std::swap(a, b);
  if (b.is_memory) {
    code_.vector(form(0x00), s.target, c.reg, b);
  } else {
    code_.vector(form(0x10), s.target, b.reg, c);
  }
}

void CodeWriter::select(const MachineStep& s) {
  const VectorOperand x[3] = {operand(s.operands[0]), operand(s.operands[1]), operand(s.operands[2])};
  if (!wide_) {
    code_.vector(opcode::kBlend, s.target, x[2].reg, x[1], x[0].reg << 4);
    return;
  }
  // Bitwise choice by truth table: the overwritten operand counts 4, then the register, then the last source.
  int place[3], next = 1;  // operand -> 0 (overwritten), 1, 2
  place[s.destroyed] = 0;
  for (int k = 0; k < 3; ++k) {
    if (k != s.destroyed && !x[k].is_memory) place[k] = next++;
  }
  for (int k = 0; k < 3; ++k) {
    if (k != s.destroyed && x[k].is_memory) place[k] = next++;
  }
  int table = 0;
  for (int row = 0; row < 8; ++row) {
    const auto bit = [&](int k) { return row >> (2 - place[k]) & 1; };
    if (bit(0) ? bit(1) : bit(2)) table |= 1 << row;
  }
  VectorOperand first, second;
  for (int k = 0; k < 3; ++k) {
    if (place[k] == 1) first = x[k];
    if (place[k] == 2) second = x[k];
  }
  code_.vector(opcode::kTernary, s.target, first.reg, second, table);
}

MachineCode CodeWriter::write() {
  const Allocation allocation = allocate_registers(program_, wide_ ? 32 : 16, wide_);
  const int bias = wide_ ? 0 : kBias;
  code_.test(kBlocks);
  const int skip = code_.jump_if_not_positive_forward();
  code_.load_rip_relative(kConstants, 0);
  const int constants_place = code_.size() - 4;
  if (bias) {
    for (const Gpr base : {kUnknowns, kElements, kUniforms, kOutputs, kSpills})
      code_.add_immediate(base, bias);
    code_.clear(kHalf);
  }
  code_.align(32);
  const int loop = code_.size();
  for (const MachineStep& s : allocation.steps) write_step(s);

  const int strides[] = {program_.unknown_count * kBlockBytes, program_.element_count * kBlockBytes,
                         static_cast<int>(program_.outputs.size()) * kBlockBytes};
  const Gpr bases[] = {kUnknowns, kElements, kOutputs};
  if (wide_) {
    for (int k = 0; k < 3; ++k) code_.add_immediate(bases[k], strides[k]);
  } else {
    for (const Gpr base : bases) code_.add_immediate(base, 32);
    code_.toggle_bit(kHalf);
    code_.jump_if_not_zero(loop);
    for (int k = 0; k < 3; ++k) code_.add_immediate(bases[k], strides[k] - 64);
  }
  code_.decrement(kBlocks);
  code_.jump_if_not_zero(loop);
  code_.zero_upper();
  code_.patch(skip);
  code_.ret();

  MachineCode result;
  result.instruction_bytes = code_.size();
  code_.align(64);
  result.first_constant = code_.size();
  code_.patch_word(constants_place, code_.size() - (constants_place + 4) + bias);
  for (const uint64_t c : program_.constants) {
    for (int k = 0; k < (wide_ ? 1 : 4); ++k) code_.quad(c);
  }
  result.bytes = code_.bytes();
  result.spill_count = allocation.spill_count;
  return result;
}

class X86Code final : public Executable {
 public:
  X86Code(const Program& program, const MachineCode& code, bool wide)
      : memory_(code.bytes), wide_(wide), uniform_count_(program.uniform_count) {
    code_bytes = code.bytes.size();
    spill_slots = code.spill_count;
  }
  bool usable() const { return memory_.data() != nullptr; }

  void run(const double* unknowns, const double* elements, const double* uniforms, double* out_values,
           int64_t block_count) const override {
    const size_t spills = static_cast<size_t>(spill_slots) * (wide_ ? 8 : 4);
    double* scratch = thread_scratch(spills + (wide_ ? 0 : static_cast<size_t>(uniform_count_) * 4));
    if (!wide_) {
      for (int i = 0; i < uniform_count_; ++i) {
        for (int l = 0; l < 4; ++l) scratch[spills + static_cast<size_t>(4 * i + l)] = uniforms[i];
      }
      uniforms = scratch + spills;
    }
    reinterpret_cast<Function>(const_cast<void*>(memory_.data()))(unknowns, elements, uniforms, out_values,
                                                                  block_count, scratch);
  }

 private:
  ExecutableMemory memory_;
  bool wide_;
  int uniform_count_;
};

}  // namespace

MachineCode assemble_x86_64(const Program& program, Backend backend) {
  return CodeWriter(program, backend == Backend::Avx512).write();
}

std::unique_ptr<Executable> make_x86_64_code(const Program& program, Backend backend) {
#if defined(__x86_64__) && defined(__linux__)
  const bool wide = backend == Backend::Avx512;
  auto code = std::make_unique<X86Code>(program, assemble_x86_64(program, backend), wide);
  if (code->usable()) return code;
#else
  static_cast<void>(program);
  static_cast<void>(backend);
#endif
  return nullptr;
}

}  // namespace stark::symbolic
