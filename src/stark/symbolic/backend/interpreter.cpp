// Interpreter: executes a program one instruction at a time over one block of lanes. Always available; same bits as
// machine code, because every instruction is one IEEE operation per lane and the library is compiled without
// contraction.
// Phase: assembly.
#include <stark/symbolic/backend/executable.h>

#include <array>
#include <bit>
#include <cmath>
#include <vector>

namespace stark::symbolic {

namespace {

double from_bits(uint64_t x) { return std::bit_cast<double>(x); }
uint64_t to_bits(double x) { return std::bit_cast<uint64_t>(x); }
double mask(bool x) { return from_bits(x ? ~0ull : 0ull); }

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

template <typename F>
void for_lanes(double* r, const double* a, F f) {
  for (int l = 0; l < kLanes; ++l) r[l] = f(a[l]);
}
template <typename F>
void for_lanes(double* r, const double* a, const double* b, F f) {
  for (int l = 0; l < kLanes; ++l) r[l] = f(a[l], b[l]);
}
template <typename F>
void for_lanes(double* r, const double* a, const double* b, const double* c, F f) {
  for (int l = 0; l < kLanes; ++l) r[l] = f(a[l], b[l], c[l]);
}

class Interpreter final : public Executable {
 public:
  explicit Interpreter(const Program& program);
  void run(const double* unknowns, const double* elements, const double* uniforms, double* out_values,
           int64_t block_count) const override;

 private:
  void run_block(const std::array<const double*, kBaseCount>& bases, double* slots) const;

  std::vector<Step> steps_;
  std::vector<Copy> copies_;        // outputs that are inputs or constants, or were kept to the end
  std::vector<double> constants_;   // one block each
  int slot_count_ = 0;
  int unknown_count_, element_count_, uniform_count_, output_count_;
};

Interpreter::Interpreter(const Program& program)
    : unknown_count_(program.unknown_count), element_count_(program.element_count), uniform_count_(program.uniform_count),
      output_count_(static_cast<int>(program.outputs.size())) {
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
      case Space::Value: base = kSlots; offset = slot[o.index] * kLanes; break;
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
    step.slot = slot[i] * kLanes;
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
  double* scratch = thread_scratch(static_cast<size_t>(slot_count_ + uniform_count_) * kLanes);
  double* uniform_lanes = scratch + static_cast<size_t>(slot_count_) * kLanes;
  for (int i = 0; i < uniform_count_; ++i) {
    for (int l = 0; l < kLanes; ++l) uniform_lanes[i * kLanes + l] = uniforms[i];
  }
  std::array<const double*, kBaseCount> bases{scratch, unknowns, elements, constants_.data(), uniform_lanes};
  for (int64_t block = 0; block < block_count; ++block) {
    run_block(bases, scratch);
    for (const Copy& c : copies_) {
      for (int l = 0; l < kLanes; ++l) out_values[c.output + l] = bases[c.base][c.offset + l];
    }
    bases[kUnknowns] += unknown_count_ * kLanes;
    bases[kElements] += element_count_ * kLanes;
    out_values += output_count_ * kLanes;
  }
}

void Interpreter::run_block(const std::array<const double*, kBaseCount>& bases, double* slots) const {
  for (const Step& s : steps_) {
    double* r = slots + s.slot;
    const double* a = bases[s.base[0]] + s.offset[0];
    const double* b = bases[s.base[1]] + s.offset[1];
    const double* c = bases[s.base[2]] + s.offset[2];
    switch (s.code) {
      case Code::Add: for_lanes(r, a, b, [](double x, double y) { return x + y; }); break;
      case Code::Sub: for_lanes(r, a, b, [](double x, double y) { return x - y; }); break;
      case Code::Mul: for_lanes(r, a, b, [](double x, double y) { return x * y; }); break;
      case Code::Div: for_lanes(r, a, b, [](double x, double y) { return x / y; }); break;
      case Code::Min: for_lanes(r, a, b, [](double x, double y) { return x < y ? x : y; }); break;
      case Code::Max: for_lanes(r, a, b, [](double x, double y) { return x > y ? x : y; }); break;
      case Code::MulAdd: for_lanes(r, a, b, c, [](double x, double y, double z) { return std::fma(x, y, z); }); break;
      case Code::MulSub: for_lanes(r, a, b, c, [](double x, double y, double z) { return std::fma(x, y, -z); }); break;
      case Code::NegMulAdd: for_lanes(r, a, b, c, [](double x, double y, double z) { return std::fma(-x, y, z); }); break;
      case Code::Sqrt: for_lanes(r, a, [](double x) { return std::sqrt(x); }); break;
      case Code::Round: for_lanes(r, a, [](double x) { return std::nearbyint(x); }); break;
      case Code::Less: for_lanes(r, a, b, [](double x, double y) { return mask(x < y); }); break;
      case Code::LessEqual: for_lanes(r, a, b, [](double x, double y) { return mask(x <= y); }); break;
      case Code::Select:
        for_lanes(r, a, b, c, [](double x, double y, double z) {
          return from_bits((to_bits(x) & to_bits(y)) | (~to_bits(x) & to_bits(z)));
        });
        break;
      case Code::And: for_lanes(r, a, b, [](double x, double y) { return from_bits(to_bits(x) & to_bits(y)); }); break;
      case Code::Or: for_lanes(r, a, b, [](double x, double y) { return from_bits(to_bits(x) | to_bits(y)); }); break;
      case Code::Xor: for_lanes(r, a, b, [](double x, double y) { return from_bits(to_bits(x) ^ to_bits(y)); }); break;
      case Code::AndNot: for_lanes(r, a, b, [](double x, double y) { return from_bits(~to_bits(x) & to_bits(y)); }); break;
      case Code::AddInt: for_lanes(r, a, b, [](double x, double y) { return from_bits(to_bits(x) + to_bits(y)); }); break;
      case Code::SubInt: for_lanes(r, a, b, [](double x, double y) { return from_bits(to_bits(x) - to_bits(y)); }); break;
      case Code::ShiftLeft: {
        const int n = s.shift;
        for_lanes(r, a, [n](double x) { return from_bits(to_bits(x) << n); });
        break;
      }
      case Code::ShiftRight: {
        const int n = s.shift;
        for_lanes(r, a, [n](double x) { return from_bits(to_bits(x) >> n); });
        break;
      }
    }
  }
}

}  // namespace

std::unique_ptr<Executable> make_interpreter(const Program& program) { return std::make_unique<Interpreter>(program); }

}  // namespace stark::symbolic
