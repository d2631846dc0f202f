// Machine code for AArch64: a block of eight lanes is four passes with registers of two doubles. Every
// operation is the same IEEE operation as on the other back ends and in the interpreter. Phase: kernel
// building.
#include <stark/symbolic/backend/aarch64.h>

#include <stark/base/error.h>
#include <stark/symbolic/backend/aarch64_assembler.h>
#include <stark/symbolic/backend/executable.h>
#include <stark/symbolic/backend/executable_memory.h>
#include <stark/symbolic/backend/register_allocation.h>

namespace stark::symbolic {

namespace {

using aarch64::Assembler;
using aarch64::Unary;
using aarch64::Vector;
using aarch64::X;

using Function = void (*)(const double* unknowns, const double* elements, const double* uniforms,
                          double* out_values, int64_t block_count, double* spills, const void* constants);

// Arguments of the procedure call standard, and registers that a callee may use.
constexpr X kUnknowns{0}, kElements{1}, kUniforms{2}, kOutputs{3}, kBlocks{4}, kSpills{5}, kConstants{6},
    kPasses{7}, kAddress{9};

constexpr int kBlockBytes = kLanes * 8, kVectorBytes = 16, kPassCount = kBlockBytes / kVectorBytes;
// Registers v8 to v15 belong to the caller; the last two are for operands that are in memory and for results
// that may not overwrite an operand yet.
constexpr int kRegisterCount = 22, kKept = 8, kFirstScratch = 30, kSecondScratch = 31;

int in_file(int allocated) { return allocated < kKept ? allocated : allocated + 8; }

class CodeWriter {
 public:
  explicit CodeWriter(const Program& program) : program_(program) {}
  MachineCode write();

 private:
  struct Place {
    X base;
    int offset;
  };
  Place place(const Location& l) const;
  /// Register that has an operand; one that is in memory is loaded to the second scratch register.
  int source(const Location& l);
  void write_step(const MachineStep& s);
  void operate(const MachineStep& s);
  void choose_by_order(const MachineStep& s, int smaller, int larger);
  void fused(const MachineStep& s);
  void select(const MachineStep& s);

  const Program& program_;
  Assembler code_;
};

CodeWriter::Place CodeWriter::place(const Location& l) const {
  switch (l.home) {
    case Home::Unknown:
      return {kUnknowns, l.index * kBlockBytes};
    case Home::Element:
      return {kElements, l.index * kBlockBytes};
    case Home::Output:
      return {kOutputs, l.index * kBlockBytes};
    case Home::Spill:
      return {kSpills, l.index * kVectorBytes};
    case Home::Uniform:
      return {kUniforms, l.index * kVectorBytes};
    case Home::Constant:
      return {kConstants, l.index * kVectorBytes};
    case Home::Register:
      break;
  }
  throw InternalError("CodeWriter: unknown location.");
}

int CodeWriter::source(const Location& l) {
  if (!l.is_memory()) return in_file(l.index);
  const Place p = place(l);
  code_.load(kSecondScratch, p.base, p.offset, kAddress);
  return kSecondScratch;
}

void CodeWriter::write_step(const MachineStep& s) {
  const int target = in_file(s.target);
  if (s.kind == MachineStep::Kind::Operate) return operate(s);
  if (s.kind == MachineStep::Kind::Move) return code_.move(target, in_file(s.operands[0].index));
  const Place p = place(s.operands[0]);
  if (s.kind == MachineStep::Kind::Load)
    code_.load(target, p.base, p.offset, kAddress);
  else
    code_.store(target, p.base, p.offset, kAddress);
}

void CodeWriter::operate(const MachineStep& s) {
  if (s.code == Code::Select) return select(s);
  if (operand_count(s.code) == 3) return fused(s);
  const int target = in_file(s.target), a = source(s.operands[0]);
  const int b = operand_count(s.code) == 2 ? source(s.operands[1]) : a;
  const auto binary = [&](Vector op, int n, int m) { code_.vector(op, target, n, m); };
  switch (s.code) {
    case Code::Add:
      return binary(Vector::Add, a, b);
    case Code::Sub:
      return binary(Vector::Sub, a, b);
    case Code::Mul:
      return binary(Vector::Mul, a, b);
    case Code::Div:
      return binary(Vector::Div, a, b);
    case Code::Min:
      return choose_by_order(s, a, b);
    case Code::Max:
      return choose_by_order(s, b, a);
    case Code::Less:
      return binary(Vector::Greater, b, a);
    case Code::LessEqual:
      return binary(Vector::GreaterEqual, b, a);
    case Code::And:
      return binary(Vector::And, a, b);
    case Code::Or:
      return binary(Vector::Or, a, b);
    case Code::Xor:
      return binary(Vector::Xor, a, b);
    case Code::AndNot:
      return binary(Vector::AndNot, b, a);
    case Code::AddInt:
      return binary(Vector::AddInt, a, b);
    case Code::SubInt:
      return binary(Vector::SubInt, a, b);
    case Code::Sqrt:
      return code_.vector(Unary::Sqrt, target, a);
    case Code::Round:
      return code_.vector(Unary::Round, target, a);
    case Code::ShiftLeft:
      return s.shift == 0 ? code_.move(target, a) : code_.shift_left(target, a, s.shift);
    case Code::ShiftRight:
      return s.shift == 0 ? code_.move(target, a) : code_.shift_right(target, a, s.shift);
    default:
      throw InternalError("CodeWriter: unknown operation.");
  }
}

// Minimum and maximum as comparisons, which is what they are for NaN and zeros of either sign.
void CodeWriter::choose_by_order(const MachineStep& s, int smaller, int larger) {
  const int a = s.operands[0].is_memory() ? kSecondScratch : in_file(s.operands[0].index);
  const int b = s.operands[1].is_memory() ? kSecondScratch : in_file(s.operands[1].index);
  code_.vector(Vector::Greater, kFirstScratch, larger, smaller);
  code_.vector(Vector::SelectByTarget, kFirstScratch, a, b);
  code_.move(in_file(s.target), kFirstScratch);
}

// Vd += Vn Vm and Vd -= Vn Vm overwrite what is added to.
void CodeWriter::fused(const MachineStep& s) {
  const int target = in_file(s.target);
  const bool in_place = s.destroyed == 2;
  const int sum = in_place ? target : kFirstScratch;
  if (!in_place) {
    const Location& c = s.operands[2];
    if (c.is_memory()) {
      const Place p = place(c);
      code_.load(sum, p.base, p.offset, kAddress);
    } else {
      code_.move(sum, in_file(c.index));
    }
  }
  if (s.code == Code::MulSub) code_.vector(Unary::Negate, sum, sum);
  const int a = source(s.operands[0]), b = source(s.operands[1]);
  code_.vector(s.code == Code::NegMulAdd ? Vector::MulSub : Vector::MulAdd, sum, a, b);
  if (!in_place) code_.move(target, sum);
}

// The operand that is overwritten decides which of three instructions says the same.
void CodeWriter::select(const MachineStep& s) {
  const int target = in_file(s.target);
  int x[3];
  for (int k = 0; k < 3; ++k) x[k] = k == s.destroyed ? target : source(s.operands[k]);
  if (s.destroyed == 0) code_.vector(Vector::SelectByTarget, target, x[1], x[2]);
  if (s.destroyed == 1) code_.vector(Vector::InsertIfFalse, target, x[2], x[0]);
  if (s.destroyed == 2) code_.vector(Vector::InsertIfTrue, target, x[1], x[0]);
}

MachineCode CodeWriter::write() {
  const Allocation allocation = allocate_registers(program_, kRegisterCount, true);
  code_.compare_zero(kBlocks);
  code_.return_if_not_positive();
  const int block = code_.size();
  code_.move_immediate(kPasses, kPassCount);
  const int pass = code_.size();
  for (const MachineStep& s : allocation.steps) write_step(s);
  const X bases[] = {kUnknowns, kElements, kOutputs};
  for (const X base : bases) code_.add_immediate(base, kVectorBytes, kAddress);
  code_.add_immediate(kPasses, -1, kAddress);
  code_.branch_if_not_zero(kPasses, pass);
  const int64_t counts[] = {program_.unknown_count, program_.element_count,
                            static_cast<int64_t>(program_.outputs.size())};
  for (int k = 0; k < 3; ++k) code_.add_immediate(bases[k], (counts[k] - 1) * kBlockBytes, kAddress);
  code_.add_immediate(kBlocks, -1, kAddress);
  code_.branch_if_not_zero(kBlocks, block);
  code_.ret();

  MachineCode result;
  result.instruction_bytes = code_.size();
  code_.align(64);
  result.first_constant = code_.size();
  for (const uint64_t c : program_.constants)
    for (int k = 0; k < kVectorBytes / 8; ++k) code_.quad(c);
  result.bytes = code_.bytes();
  result.spill_count = allocation.spill_count;
  return result;
}

#if defined(__aarch64__) && defined(__linux__)

class NeonCode final : public Executable {
 public:
  NeonCode(const Program& program, const MachineCode& code)
      : memory_(code.bytes), first_constant_(code.first_constant), uniform_count_(program.uniform_count) {
    code_bytes = code.bytes.size();
    spill_slots = code.spill_count;
  }
  bool usable() const { return memory_.data() != nullptr; }

  void run(const double* unknowns, const double* elements, const double* uniforms, double* out_values,
           int64_t block_count) const override {
    const size_t spills = static_cast<size_t>(spill_slots) * 2;
    double* scratch = thread_scratch(spills + static_cast<size_t>(uniform_count_) * 2);
    for (int i = 0; i < uniform_count_; ++i)
      scratch[spills + static_cast<size_t>(2 * i)] = scratch[spills + static_cast<size_t>(2 * i + 1)] =
          uniforms[i];
    reinterpret_cast<Function>(const_cast<void*>(memory_.data()))(
        unknowns, elements, scratch + spills, out_values, block_count, scratch,
        static_cast<const uint8_t*>(memory_.data()) + first_constant_);
  }

 private:
  ExecutableMemory memory_;
  int first_constant_;
  int uniform_count_;
};

#endif

}  // namespace

MachineCode assemble_aarch64(const Program& program) { return CodeWriter(program).write(); }

std::unique_ptr<Executable> make_neon_code(const Program& program) {
#if defined(__aarch64__) && defined(__linux__)
  auto code = std::make_unique<NeonCode>(program, assemble_aarch64(program));
  if (code->usable()) return code;
#else
  static_cast<void>(program);
#endif
  return nullptr;
}

}  // namespace stark::symbolic
