// Every instruction form with its operands. With STARK_INSTRUCTION_DUMP set to a file name the second case
// writes one line per instruction, "wide name reg first second immediate bytes", which
// tests/python/test_encoder.py compares with an independent disassembler.
#include <doctest/doctest.h>

#include <stark/symbolic/backend/x86_64_assembler.h>

#include <cstdlib>
#include <fstream>
#include <limits>
#include <string>

using namespace stark::symbolic;

namespace {

const char* gpr_name(Gpr r) {
  static const char* names[] = {"rax", "rcx", "rdx", "rbx", "rsp", "rbp", "rsi", "rdi",
                                "r8",  "r9",  "r10", "r11", "r12", "r13", "r14", "r15"};
  return names[static_cast<int>(r)];
}

struct Form {
  const char* name;
  Opcode op;
  int sources;      // vector sources: 1 or 2
  int immediate;    // -1: none
  bool broadcasts;  // EVEX broadcast allowed
};

Opcode variant(Opcode op, int offset) {
  op.code = static_cast<uint8_t>(op.code + offset);
  return op;
}

// Around the ends of one-byte displacements: of bytes, of doubles (broadcast), of whole vectors.
constexpr int kDisplacements[] = {0,
                                  1,
                                  8,
                                  -8,
                                  32,
                                  63,
                                  64,
                                  -64,
                                  127,
                                  128,
                                  -128,
                                  -129,
                                  1016,
                                  1024,
                                  -1024,
                                  -1032,
                                  8064,
                                  8128,
                                  8129,
                                  8192,
                                  -8192,
                                  -8200,
                                  -8256,
                                  100000,
                                  std::numeric_limits<int>::max(),
                                  std::numeric_limits<int>::min()};
constexpr int kGprs = 16;

/// Writes instructions one by one, with what they should be.
class Writer {
 public:
  Writer(std::ostream& out, bool wide) : out_(out), wide_(wide) {}
  int registers() const { return wide_ ? 32 : 16; }
  bool wide() const { return wide_; }

  void vector(const char* name, Opcode op, int reg, int first, const VectorOperand& second, int immediate) {
    Assembler a(wide_);
    a.vector(op, reg, first, second, immediate);
    std::string last = std::to_string(second.reg);
    if (second.is_memory)
      last = std::string(gpr_name(second.base)) + ":" + std::to_string(second.displacement) +
             (second.broadcast ? ":b" : ":v");
    line(a, name, std::to_string(reg), std::to_string(first), last, immediate);
  }

  /// General instruction `name first, second`.
  void general(const char* name, const std::string& first, const std::string& second, const Assembler& a) {
    line(a, name, "general", first, second, -1);
  }

  /// Every base and displacement; the registers take turns.
  void memory(const Form& f) {
    int turn = 0;
    for (int base = 0; base < kGprs; ++base) {
      for (const int d : kDisplacements) {
        for (const bool broadcast : {false, true}) {
          if (broadcast && !(wide_ && f.broadcasts)) continue;
          const int reg = turn++ % registers(), first = f.sources == 2 ? 7 * turn % registers() : 0;
          vector(f.name, f.op, reg, first, VectorOperand::in_memory(static_cast<Gpr>(base), d, broadcast),
                 f.immediate);
        }
      }
    }
  }

  /// Every register in every place, beside every register in every other place.
  void in_registers(const Form& f) {
    const int n = registers();
    for (int x = 0; x < n; ++x) {
      for (int y = 0; y < n; ++y) {
        const int z = (5 * x + 3 * y + 1) % n;
        const auto emit = [&](int reg, int first, int second) {
          vector(f.name, f.op, reg, f.sources == 2 ? first : 0, VectorOperand::in_register(second),
                 f.immediate);
        };
        emit(x, z, y);
        if (f.sources == 1) continue;
        emit(x, y, z);
        emit(z, x, y);
      }
    }
  }

 private:
  void line(const Assembler& a, const std::string& name, const std::string& reg, const std::string& first,
            const std::string& second, int immediate) {
    static const char* digits = "0123456789abcdef";
    out_ << wide_ << ' ' << name << ' ' << reg << ' ' << first << ' ' << second << ' ' << immediate << ' ';
    for (const uint8_t byte : a.bytes()) out_ << digits[byte >> 4] << digits[byte & 15];
    out_ << '\n';
  }

  std::ostream& out_;
  bool wide_;
};

void write_arithmetic(Writer& w) {
  const Form forms[] = {{"vaddpd", opcode::kAdd, 2, -1, true},
                        {"vmulpd", opcode::kMul, 2, -1, true},
                        {"vsubpd", opcode::kSub, 2, -1, true},
                        {"vdivpd", opcode::kDiv, 2, -1, true},
                        {"vminpd", opcode::kMin, 2, -1, true},
                        {"vmaxpd", opcode::kMax, 2, -1, true},
                        {"vandpd", opcode::kAnd, 2, -1, true},
                        {"vandnpd", opcode::kAndNot, 2, -1, true},
                        {"vorpd", opcode::kOr, 2, -1, true},
                        {"vxorpd", opcode::kXor, 2, -1, true},
                        {"vpaddq", opcode::kAddInt, 2, -1, true},
                        {"vpsubq", opcode::kSubInt, 2, -1, true},
                        {"vsqrtpd", opcode::kSqrt, 1, -1, true},
                        {w.wide() ? "vrndscalepd" : "vroundpd", opcode::kRound, 1, 8, true},
                        {"vmovupd", opcode::kLoad, 1, -1, false},
                        {"vmovapd", opcode::kMove, 1, -1, false},
                        {"vfmadd132pd", variant(opcode::kMulAdd, 0), 2, -1, true},
                        {"vfmadd213pd", variant(opcode::kMulAdd, 0x10), 2, -1, true},
                        {"vfmadd231pd", variant(opcode::kMulAdd, 0x20), 2, -1, true},
                        {"vfmsub132pd", variant(opcode::kMulSub, 0), 2, -1, true},
                        {"vfmsub213pd", variant(opcode::kMulSub, 0x10), 2, -1, true},
                        {"vfmsub231pd", variant(opcode::kMulSub, 0x20), 2, -1, true},
                        {"vfnmadd132pd", variant(opcode::kNegMulAdd, 0), 2, -1, true},
                        {"vfnmadd213pd", variant(opcode::kNegMulAdd, 0x10), 2, -1, true},
                        {"vfnmadd231pd", variant(opcode::kNegMulAdd, 0x20), 2, -1, true}};
  for (const Form& f : forms) {
    w.in_registers(f);
    w.memory(f);
  }
  w.memory({"store", opcode::kStore, 1, -1, false});
  w.memory({"vbroadcastsd", opcode::kBroadcast, 1, -1, false});
}

// One opcode of each map with every triple of registers, and with every register beside every base.
void write_cubes(Writer& w) {
  const Form forms[] = {{"vaddpd", opcode::kAdd, 2, -1, true},
                        {"vfmadd213pd", variant(opcode::kMulAdd, 0x10), 2, -1, true}};
  for (const Form& f : forms) {
    for (int reg = 0; reg < w.registers(); ++reg) {
      for (int first = 0; first < w.registers(); ++first) {
        for (int second = 0; second < w.registers(); ++second)
          w.vector(f.name, f.op, reg, first, VectorOperand::in_register(second), -1);
        for (int base = 0; base < kGprs; ++base)
          w.vector(f.name, f.op, reg, first, VectorOperand::in_memory(static_cast<Gpr>(base), 64), -1);
      }
    }
  }
}

// Comparisons, choices and shifts: the masks, truth tables and counts.
void write_choices(Writer& w) {
  const int n = w.registers();
  for (const int predicate : {0x11, 0x12}) {
    const Form compare{"vcmppd", opcode::kCompare, 2, predicate, true};
    if (!w.wide()) {
      w.in_registers(compare);
      w.memory(compare);
      continue;
    }
    for (int x = 0; x < n; ++x) {
      for (int y = 0; y < n; ++y)
        w.vector("vcmppd", opcode::kCompare, (x + y) % 8, x, VectorOperand::in_register(y), predicate);
    }
    int turn = 0;
    for (int base = 0; base < kGprs; ++base) {
      for (const int d : kDisplacements) {
        for (const bool broadcast : {false, true}) {
          w.vector("vcmppd", opcode::kCompare, turn % 8, turn % n,
                   VectorOperand::in_memory(static_cast<Gpr>(base), d, broadcast), predicate);
          ++turn;
        }
      }
    }
  }
  for (int x = 0; x < n; ++x) {
    for (int y = 0; y < n; ++y) {
      const int count = (2 * x + y) % 64;
      w.vector("vpsllq", opcode::kShiftImmediate, 6, x, VectorOperand::in_register(y), count);
      w.vector("vpsrlq", opcode::kShiftImmediate, 2, x, VectorOperand::in_register(y), count);
    }
  }
  if (w.wide()) {
    w.in_registers({"vpternlogq", opcode::kTernary, 2, 0xca, true});
    for (int table = 0; table < 256; ++table)
      w.vector("vpternlogq", opcode::kTernary, table % n, 7 * table % n,
               VectorOperand::in_register(13 * table % n), table);
    w.memory({"vpternlogq", opcode::kTernary, 2, 0xca, true});
    for (int reg = 0; reg < n; ++reg) {
      for (int mask = 0; mask < 8; ++mask)
        w.vector("vpmovm2q", opcode::kMaskToVector, reg, 0, VectorOperand::in_register(mask), -1);
    }
  } else {
    for (int mask = 0; mask < n; ++mask) {
      w.in_registers({"vblendvpd", opcode::kBlend, 2, mask << 4, false});
      w.memory({"vblendvpd", opcode::kBlend, 2, mask << 4, false});
    }
  }
}

void write_general(Writer& w) {
  static const char* low[] = {"eax", "ecx", "edx",  "ebx",  "esp",  "ebp",  "esi",  "edi",
                              "r8d", "r9d", "r10d", "r11d", "r12d", "r13d", "r14d", "r15d"};
  for (int k = 0; k < kGprs; ++k) {
    const Gpr r = static_cast<Gpr>(k);
    const std::string name = gpr_name(r);
    const auto emit = [&](const char* operation, const std::string& first, const std::string& second,
                          const auto& write) {
      Assembler a(w.wide());
      write(a);
      w.general(operation, first, second, a);
    };
    for (const int d : kDisplacements) {
      emit("add", name, std::to_string(d), [&](Assembler& a) { a.add_immediate(r, d); });
      emit("lea", name, "rip:" + std::to_string(d), [&](Assembler& a) { a.load_rip_relative(r, d); });
      emit("movabs", name, std::to_string(0x123456789abcdefll + d),
           [&](Assembler& a) { a.move_immediate(r, static_cast<uint64_t>(0x123456789abcdefll + d)); });
    }
    emit("xor", low[k], low[k], [&](Assembler& a) { a.clear(r); });
    emit("xor", low[k], "1", [&](Assembler& a) { a.toggle_bit(r); });
    emit("dec", name, "-", [&](Assembler& a) { a.decrement(r); });
    emit("test", name, name, [&](Assembler& a) { a.test(r); });
  }
}

int encoded_size(bool wide, const VectorOperand& second) {
  Assembler a(wide);
  a.vector(opcode::kAdd, 0, 0, second);
  return a.size();
}

}  // namespace

TEST_CASE("displacements take one byte where they can") {
  const auto at = [](int d, bool broadcast = false) {
    return VectorOperand::in_memory(Gpr::Rdi, d, broadcast);
  };
  CHECK(encoded_size(false, at(0)) == 4);
  CHECK(encoded_size(false, at(127)) == 5);
  CHECK(encoded_size(false, at(-128)) == 5);
  CHECK(encoded_size(false, at(128)) == 8);
  CHECK(encoded_size(true, at(0)) == 6);
  CHECK(encoded_size(true, at(127 * 64)) == 7);  // in units of a vector
  CHECK(encoded_size(true, at(-128 * 64)) == 7);
  CHECK(encoded_size(true, at(128 * 64)) == 10);
  CHECK(encoded_size(true, at(8)) == 10);
  CHECK(encoded_size(true, at(127 * 8, true)) == 7);  // in units of a double
  CHECK(encoded_size(true, at(128 * 8, true)) == 10);
}

TEST_CASE("instruction forms are written for the independent decoder") {
  const char* path = std::getenv("STARK_INSTRUCTION_DUMP");
  if (!path) return;
  std::ofstream out(path);
  for (const bool wide : {false, true}) {
    Writer writer(out, wide);
    write_arithmetic(writer);
    write_cubes(writer);
    write_choices(writer);
    write_general(writer);
  }
  CHECK(out.good());
}
