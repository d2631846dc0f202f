// Interpreter: executes a program one instruction at a time over a few blocks of lanes. Always available;
// same bits as machine code, because every instruction is one IEEE operation per lane and the library is
// compiled without contraction. Phase: assembly.
#include <stark/symbolic/backend/executable.h>

#if defined(__AVX2__) && defined(__FMA__)
#include <immintrin.h>
#endif

#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <vector>

namespace stark::symbolic {

namespace {

// Half a block as one vector, so that operations compile to vector instructions whatever the compiler can
// prove about aliasing; accesses may be unaligned.
constexpr int kHalf = 4;
using Half = double __attribute__((vector_size(kHalf * 8), aligned(8), may_alias));
using Bits = uint64_t __attribute__((vector_size(kHalf * 8), aligned(8), may_alias));

double from_bits(uint64_t x) { return std::bit_cast<double>(x); }
Half load(const double* a) { return *reinterpret_cast<const Half*>(a); }
Bits load_bits(const double* a) { return *reinterpret_cast<const Bits*>(a); }
void store(double* r, const Half& x) { *reinterpret_cast<Half*>(r) = x; }
void store(double* r, const Bits& x) { *reinterpret_cast<Bits*>(r) = x; }

// Operations that generic vectors lack. The portable versions are the definition; the others are the same by
// IEEE 754.
#if defined(__AVX2__) && defined(__FMA__)
Half fused(Half a, Half b, Half c) { return _mm256_fmadd_pd(a, b, c); }
Half square_root(Half a) { return _mm256_sqrt_pd(a); }
Half rounded(Half a) { return _mm256_round_pd(a, _MM_FROUND_TO_NEAREST_INT | _MM_FROUND_NO_EXC); }
Half smaller(Half a, Half b) { return _mm256_min_pd(a, b); }
Half larger(Half a, Half b) { return _mm256_max_pd(a, b); }
Half less(Half a, Half b) { return _mm256_cmp_pd(a, b, _CMP_LT_OQ); }
Half less_equal(Half a, Half b) { return _mm256_cmp_pd(a, b, _CMP_LE_OQ); }
#else
template <typename F>
Half by_lane(F f) {
  Half r;
  for (int l = 0; l < kHalf; ++l) r[l] = f(l);
  return r;
}
double mask(bool x) { return from_bits(x ? ~0ull : 0ull); }
Half fused(Half a, Half b, Half c) {
  return by_lane([&](int l) { return std::fma(a[l], b[l], c[l]); });
}
Half square_root(Half a) {
  return by_lane([&](int l) { return std::sqrt(a[l]); });
}
Half rounded(Half a) {
  return by_lane([&](int l) { return std::nearbyint(a[l]); });
}
Half smaller(Half a, Half b) {
  return by_lane([&](int l) { return a[l] < b[l] ? a[l] : b[l]; });
}
Half larger(Half a, Half b) {
  return by_lane([&](int l) { return a[l] > b[l] ? a[l] : b[l]; });
}
Half less(Half a, Half b) {
  return by_lane([&](int l) { return mask(a[l] < b[l]); });
}
Half less_equal(Half a, Half b) {
  return by_lane([&](int l) { return mask(a[l] <= b[l]); });
}
#endif

enum Base : uint8_t { kSlots, kUnknowns, kElements, kConstants, kUniforms, kBaseCount };

struct Step {
  Code code;
  uint8_t shift;
  uint8_t base[3];
  int32_t slot;                        // of the result, in doubles
  int32_t offset[3];                   // in doubles
  int32_t first_output, output_count;  // outputs that are this value: places in stored_outputs_
};
struct Copy {
  uint8_t base;
  int32_t offset, output;
};

// Blocks per dispatch: one instruction runs over all of them, which pays for finding it.
constexpr int kChunk = 4;

class Interpreter final : public Executable {
 public:
  explicit Interpreter(const Program& program);
  void run(const double* unknowns, const double* elements, const double* uniforms, double* out_values,
           int64_t block_count) const override;

 private:
  void run_chunk(const std::array<const double*, kBaseCount>& bases, double* slots, double* out_values,
                 int blocks) const;

  std::vector<Step> steps_;
  std::vector<int32_t> stored_outputs_;
  std::vector<Copy> copies_;       // outputs that are inputs or constants
  std::vector<double> constants_;  // one block each
  int slot_count_ = 0;
  int uniform_count_, output_count_;
  std::array<int64_t, kBaseCount> strides_{};  // from block to block, in doubles
};

Interpreter::Interpreter(const Program& program)
    : uniform_count_(program.uniform_count),
      output_count_(static_cast<int>(program.outputs.size())),
      strides_{kLanes, program.unknown_count * kLanes, program.element_count * kLanes, 0, 0} {
  const int count = static_cast<int>(program.instructions.size());
  for (const uint64_t c : program.constants) constants_.insert(constants_.end(), kLanes, from_bits(c));

  // Slots are reused after the last use; outputs are stored as soon as they are known.
  std::vector<int> last_use(count, -1), slot(count, -1), free_slots;
  for (int i = 0; i < count; ++i) {
    for (const Operand& o : program.instructions[i].operands) {
      if (o.space == Space::Value) last_use[o.index] = i;
    }
  }
  std::vector<std::vector<int32_t>> outputs_of(count);
  for (int k = 0; k < output_count_; ++k) {
    if (program.outputs[k].space == Space::Value) outputs_of[program.outputs[k].index].push_back(k);
  }
  const auto place = [&](const Operand& o, uint8_t& base, int32_t& offset) {
    switch (o.space) {
      case Space::Value:
        base = kSlots;
        offset = slot[o.index] * kChunk * kLanes;
        break;
      case Space::Unknown:
        base = kUnknowns;
        offset = o.index * kLanes;
        break;
      case Space::Element:
        base = kElements;
        offset = o.index * kLanes;
        break;
      case Space::Uniform:
        base = kUniforms;
        offset = o.index * kLanes;
        break;
      default:
        base = kConstants;
        offset = o.index * kLanes;
        break;
    }
  };
  for (int i = 0; i < count; ++i) {
    const Instruction& in = program.instructions[i];
    Step step{in.code,
              in.shift,
              {0, 0, 0},
              0,
              {0, 0, 0},
              static_cast<int32_t>(stored_outputs_.size()),
              static_cast<int32_t>(outputs_of[i].size())};
    stored_outputs_.insert(stored_outputs_.end(), outputs_of[i].begin(), outputs_of[i].end());
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
    if (last_use[i] < 0) free_slots.push_back(slot[i]);
  }
  for (int k = 0; k < output_count_; ++k) {
    if (program.outputs[k].space == Space::Value) continue;
    Copy copy{0, 0, k * kLanes};
    place(program.outputs[k], copy.base, copy.offset);
    copies_.push_back(copy);
  }
}

void Interpreter::run(const double* unknowns, const double* elements, const double* uniforms,
                      double* out_values, int64_t block_count) const {
  double* scratch = thread_scratch(static_cast<size_t>(slot_count_ * kChunk + uniform_count_) * kLanes);
  double* uniform_lanes = scratch + static_cast<size_t>(slot_count_) * kChunk * kLanes;
  for (int i = 0; i < uniform_count_; ++i) {
    for (int l = 0; l < kLanes; ++l) uniform_lanes[i * kLanes + l] = uniforms[i];
  }
  std::array<const double*, kBaseCount> bases{scratch, unknowns, elements, constants_.data(), uniform_lanes};
  for (int64_t first = 0; first < block_count; first += kChunk) {
    const int blocks = static_cast<int>(block_count - first < kChunk ? block_count - first : kChunk);
    run_chunk(bases, scratch, out_values, blocks);
    for (int g = 0; g < blocks; ++g) {
      for (const Copy& c : copies_) {
        std::memcpy(out_values + c.output, bases[c.base] + c.offset + g * strides_[c.base],
                    kLanes * sizeof(double));
      }
      out_values += output_count_ * kLanes;
    }
    bases[kUnknowns] += blocks * strides_[kUnknowns];
    bases[kElements] += blocks * strides_[kElements];
  }
}

void Interpreter::run_chunk(const std::array<const double*, kBaseCount>& bases, double* slots,
                            double* out_values, int blocks) const {
  const int64_t out_stride = static_cast<int64_t>(output_count_) * kLanes;
  for (const Step& s : steps_) {
    double* r = slots + s.slot;
    const double* a = bases[s.base[0]] + s.offset[0];
    const double* b = bases[s.base[1]] + s.offset[1];
    const double* c = bases[s.base[2]] + s.offset[2];
    const int64_t da = strides_[s.base[0]], db = strides_[s.base[1]], dc = strides_[s.base[2]];
    const auto each = [&](auto f) {
      for (int g = 0; g < blocks; ++g, r += kLanes, a += da, b += db, c += dc) {
        for (int h = 0; h < kLanes; h += kHalf) store(r + h, f(a + h, b + h, c + h));
      }
    };
    using In = const double*;
    switch (s.code) {
      case Code::Add:
        each([](In x, In y, In) { return load(x) + load(y); });
        break;
      case Code::Sub:
        each([](In x, In y, In) { return load(x) - load(y); });
        break;
      case Code::Mul:
        each([](In x, In y, In) { return load(x) * load(y); });
        break;
      case Code::Div:
        each([](In x, In y, In) { return load(x) / load(y); });
        break;
      case Code::Min:
        each([](In x, In y, In) { return smaller(load(x), load(y)); });
        break;
      case Code::Max:
        each([](In x, In y, In) { return larger(load(x), load(y)); });
        break;
      case Code::MulAdd:
        each([](In x, In y, In z) { return fused(load(x), load(y), load(z)); });
        break;
      case Code::MulSub:
        each([](In x, In y, In z) { return fused(load(x), load(y), -load(z)); });
        break;
      case Code::NegMulAdd:
        each([](In x, In y, In z) { return fused(-load(x), load(y), load(z)); });
        break;
      case Code::Sqrt:
        each([](In x, In, In) { return square_root(load(x)); });
        break;
      case Code::Round:
        each([](In x, In, In) { return rounded(load(x)); });
        break;
      case Code::Less:
        each([](In x, In y, In) { return less(load(x), load(y)); });
        break;
      case Code::LessEqual:
        each([](In x, In y, In) { return less_equal(load(x), load(y)); });
        break;
      case Code::Select:
        each([](In x, In y, In z) { return (load_bits(x) & load_bits(y)) | (~load_bits(x) & load_bits(z)); });
        break;
      case Code::And:
        each([](In x, In y, In) { return load_bits(x) & load_bits(y); });
        break;
      case Code::Or:
        each([](In x, In y, In) { return load_bits(x) | load_bits(y); });
        break;
      case Code::Xor:
        each([](In x, In y, In) { return load_bits(x) ^ load_bits(y); });
        break;
      case Code::AndNot:
        each([](In x, In y, In) { return ~load_bits(x) & load_bits(y); });
        break;
      case Code::AddInt:
        each([](In x, In y, In) { return load_bits(x) + load_bits(y); });
        break;
      case Code::SubInt:
        each([](In x, In y, In) { return load_bits(x) - load_bits(y); });
        break;
      case Code::ShiftLeft:
        each([n = s.shift](In x, In, In) { return load_bits(x) << n; });
        break;
      case Code::ShiftRight:
        each([n = s.shift](In x, In, In) { return load_bits(x) >> n; });
        break;
    }
    for (int32_t k = s.first_output; k < s.first_output + s.output_count; ++k) {
      const double* value = slots + s.slot;
      double* target = out_values + stored_outputs_[k] * kLanes;
      for (int g = 0; g < blocks; ++g)
        std::memcpy(target + g * out_stride, value + g * kLanes, kLanes * sizeof(double));
    }
  }
}

}  // namespace

std::unique_ptr<Executable> make_interpreter(const Program& program) {
  return std::make_unique<Interpreter>(program);
}

}  // namespace stark::symbolic
