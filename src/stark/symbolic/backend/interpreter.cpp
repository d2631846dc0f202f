// Interpreter: executes a program one instruction at a time over a few blocks of lanes. Always available; same bits as
// machine code, because every instruction is one IEEE operation per lane and the library is compiled without
// contraction.
// Phase: assembly.
#include <stark/symbolic/backend/executable.h>

#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <vector>

namespace stark::symbolic {

namespace {

// A block of lanes as one vector type, so that every operation compiles to vector instructions whatever the compiler
// can prove about aliasing; accesses may be unaligned.
using Lanes = double __attribute__((vector_size(kLanes * 8), aligned(8), may_alias));
using Bits = int64_t __attribute__((vector_size(kLanes * 8), aligned(8), may_alias));
using UnsignedBits = uint64_t __attribute__((vector_size(kLanes * 8)));

double from_bits(uint64_t x) { return std::bit_cast<double>(x); }
Lanes load(const double* a) { return *reinterpret_cast<const Lanes*>(a); }
Bits load_bits(const double* a) { return *reinterpret_cast<const Bits*>(a); }
void store(double* r, const Lanes& x) { *reinterpret_cast<Lanes*>(r) = x; }
void store(double* r, const Bits& x) { *reinterpret_cast<Bits*>(r) = x; }

enum Base : uint8_t { kSlots, kUnknowns, kElements, kConstants, kUniforms, kBaseCount };

struct Step {
  Code code;
  uint8_t shift;
  uint8_t base[3];
  int32_t slot;       // of the result, in doubles
  int32_t offset[3];  // in doubles
};
struct Copy {
  uint8_t base;
  int32_t offset, output;
};

// Blocks per dispatch: one instruction runs over all of them, which pays for finding it.
constexpr int kChunk = 4;

template <typename F>
Lanes by_lane(F f) {
  double t[kLanes];
  for (int l = 0; l < kLanes; ++l) t[l] = f(l);
  return load(t);
}

class Interpreter final : public Executable {
 public:
  explicit Interpreter(const Program& program);
  void run(const double* unknowns, const double* elements, const double* uniforms, double* out_values,
           int64_t block_count) const override;

 private:
  void run_chunk(const std::array<const double*, kBaseCount>& bases, double* slots, int blocks) const;

  std::vector<Step> steps_;
  std::vector<Copy> copies_;        // outputs that are inputs or constants, or were kept to the end
  std::vector<double> constants_;   // one block each
  int slot_count_ = 0;
  int uniform_count_, output_count_;
  std::array<int64_t, kBaseCount> strides_{};  // from block to block, in doubles
};

Interpreter::Interpreter(const Program& program)
    : uniform_count_(program.uniform_count), output_count_(static_cast<int>(program.outputs.size())),
      strides_{kLanes, program.unknown_count * kLanes, program.element_count * kLanes, 0, 0} {
  const int count = static_cast<int>(program.instructions.size());
  for (const uint64_t c : program.constants) constants_.insert(constants_.end(), kLanes, from_bits(c));

  // Slots are reused after the last use; outputs are kept to the end.
  std::vector<int> last_use(count, -1), slot(count, -1), free_slots;
  for (int i = 0; i < count; ++i) {
    for (const Operand& o : program.instructions[i].operands) {
      if (o.space == Space::Value) last_use[o.index] = i;
    }
  }
  for (const Operand& o : program.outputs) {
    if (o.space == Space::Value) last_use[o.index] = count;
  }
  const auto place = [&](const Operand& o, uint8_t& base, int32_t& offset) {
    switch (o.space) {
      case Space::Value: base = kSlots; offset = slot[o.index] * kChunk * kLanes; break;
      case Space::Unknown: base = kUnknowns; offset = o.index * kLanes; break;
      case Space::Element: base = kElements; offset = o.index * kLanes; break;
      case Space::Uniform: base = kUniforms; offset = o.index * kLanes; break;
      default: base = kConstants; offset = o.index * kLanes; break;
    }
  };
  for (int i = 0; i < count; ++i) {
    const Instruction& in = program.instructions[i];
    Step step{in.code, in.shift, {0, 0, 0}, 0, {0, 0, 0}};
    const int operands = operand_count(in.code);
    for (int k = 0; k < operands; ++k) place(in.operands[k], step.base[k], step.offset[k]);
    for (int k = 0; k < operands; ++k) {
      const Operand& o = in.operands[k];
      bool repeated = false;
      for (int m = 0; m < k; ++m) repeated |= in.operands[m] == o;
      if (o.space == Space::Value && last_use[o.index] == i && !repeated) free_slots.push_back(slot[o.index]);
    }
    if (free_slots.empty()) {
      slot[i] = slot_count_++;
    } else {
      slot[i] = free_slots.back();
      free_slots.pop_back();
    }
    step.slot = slot[i] * kChunk * kLanes;
    steps_.push_back(step);
  }
  for (int k = 0; k < output_count_; ++k) {
    Copy copy{0, 0, k * kLanes};
    place(program.outputs[k], copy.base, copy.offset);
    copies_.push_back(copy);
  }
}

void Interpreter::run(const double* unknowns, const double* elements, const double* uniforms, double* out_values,
                      int64_t block_count) const {
  double* scratch = thread_scratch(static_cast<size_t>(slot_count_ * kChunk + uniform_count_) * kLanes);
  double* uniform_lanes = scratch + static_cast<size_t>(slot_count_) * kChunk * kLanes;
  for (int i = 0; i < uniform_count_; ++i) {
    for (int l = 0; l < kLanes; ++l) uniform_lanes[i * kLanes + l] = uniforms[i];
  }
  std::array<const double*, kBaseCount> bases{scratch, unknowns, elements, constants_.data(), uniform_lanes};
  for (int64_t first = 0; first < block_count; first += kChunk) {
    const int blocks = static_cast<int>(block_count - first < kChunk ? block_count - first : kChunk);
    run_chunk(bases, scratch, blocks);
    for (int g = 0; g < blocks; ++g) {
      for (const Copy& c : copies_) {
        std::memcpy(out_values + c.output, bases[c.base] + c.offset + g * strides_[c.base], kLanes * sizeof(double));
      }
      out_values += output_count_ * kLanes;
    }
    bases[kUnknowns] += blocks * strides_[kUnknowns];
    bases[kElements] += blocks * strides_[kElements];
  }
}

void Interpreter::run_chunk(const std::array<const double*, kBaseCount>& bases, double* slots, int blocks) const {
  for (const Step& s : steps_) {
    double* r = slots + s.slot;
    const double* a = bases[s.base[0]] + s.offset[0];
    const double* b = bases[s.base[1]] + s.offset[1];
    const double* c = bases[s.base[2]] + s.offset[2];
    const int64_t da = strides_[s.base[0]], db = strides_[s.base[1]], dc = strides_[s.base[2]];
    const auto each = [&](auto f) {
      for (int g = 0; g < blocks; ++g, r += kLanes, a += da, b += db, c += dc) store(r, f());
    };
    switch (s.code) {
      case Code::Add: each([&] { return load(a) + load(b); }); break;
      case Code::Sub: each([&] { return load(a) - load(b); }); break;
      case Code::Mul: each([&] { return load(a) * load(b); }); break;
      case Code::Div: each([&] { return load(a) / load(b); }); break;
      case Code::Min: each([&] { return load(a) < load(b) ? load(a) : load(b); }); break;
      case Code::Max: each([&] { return load(a) > load(b) ? load(a) : load(b); }); break;
      case Code::MulAdd: each([&] { return by_lane([&](int l) { return std::fma(a[l], b[l], c[l]); }); }); break;
      case Code::MulSub: each([&] { return by_lane([&](int l) { return std::fma(a[l], b[l], -c[l]); }); }); break;
      case Code::NegMulAdd: each([&] { return by_lane([&](int l) { return std::fma(-a[l], b[l], c[l]); }); }); break;
      case Code::Sqrt: each([&] { return by_lane([&](int l) { return std::sqrt(a[l]); }); }); break;
      case Code::Round: each([&] { return by_lane([&](int l) { return std::nearbyint(a[l]); }); }); break;
      case Code::Less: each([&] { return Bits(load(a) < load(b)); }); break;
      case Code::LessEqual: each([&] { return Bits(load(a) <= load(b)); }); break;
      case Code::Select: each([&] { return (load_bits(a) & load_bits(b)) | (~load_bits(a) & load_bits(c)); }); break;
      case Code::And: each([&] { return load_bits(a) & load_bits(b); }); break;
      case Code::Or: each([&] { return load_bits(a) | load_bits(b); }); break;
      case Code::Xor: each([&] { return load_bits(a) ^ load_bits(b); }); break;
      case Code::AndNot: each([&] { return ~load_bits(a) & load_bits(b); }); break;
      // Unsigned, because signed overflow is undefined.
      case Code::AddInt: each([&] { return Bits(UnsignedBits(load_bits(a)) + UnsignedBits(load_bits(b))); }); break;
      case Code::SubInt: each([&] { return Bits(UnsignedBits(load_bits(a)) - UnsignedBits(load_bits(b))); }); break;
      case Code::ShiftLeft: each([&] { return Bits(UnsignedBits(load_bits(a)) << s.shift); }); break;
      case Code::ShiftRight: each([&] { return Bits(UnsignedBits(load_bits(a)) >> s.shift); }); break;
    }
  }
}

}  // namespace

std::unique_ptr<Executable> make_interpreter(const Program& program) { return std::make_unique<Interpreter>(program); }

}  // namespace stark::symbolic
