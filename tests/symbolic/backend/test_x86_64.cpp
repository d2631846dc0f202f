// Machine code as bytes, also for processors that are not here. With STARK_MACHINE_CODE_DUMP set to a file
// name the second case writes every instruction form and some whole kernels with their expected results as
// JSON, which tests/python/test_encoder.py disassembles and executes with an independent decoder.
#include <doctest/doctest.h>

#include <stark/symbolic/backend/register_allocation.h>
#include <stark/symbolic/backend/x86_64.h>
#include <stark/symbolic/backend/x86_64_assembler.h>
#include <stark/symbolic/diff.h>
#include <stark/symbolic/lower.h>

#include "../../../benchmarks/kernels/energies.h"
#include "symbolic/support.h"

#include <cstdlib>
#include <fstream>
#include <sstream>

using namespace stark::symbolic;
using namespace stark::symbolic::test;

namespace {

Program hessian_program(const Scalar& energy) {
  Graph graph;
  std::vector<NodeId> roots{energy.id()};
  const auto& marked = energy.graph()->stages();
  roots.insert(roots.end(), marked.begin(), marked.end());
  const auto images = import_expressions(*energy.graph(), roots, graph);
  const Derivatives d = cheapest_hessian(graph, images[0], std::span(images).subspan(1));
  std::vector<std::vector<NodeId>> groups{{images[0]}, d.gradient};
  groups[1].insert(groups[1].end(), d.hessian.begin(), d.hessian.end());
  return lower(graph, groups);
}

std::string hex(const uint8_t* bytes, size_t count) {
  static const char* digits = "0123456789abcdef";
  std::string text;
  for (size_t k = 0; k < count; ++k) {
    text += digits[bytes[k] >> 4];
    text += digits[bytes[k] & 15];
  }
  return text;
}

const char* gpr_name(Gpr r) {
  static const char* names[] = {"rax", "rcx", "rdx", "rbx", "rsp", "rbp", "rsi", "rdi",
                                "r8",  "r9",  "r10", "r11", "r12", "r13", "r14", "r15"};
  return names[static_cast<int>(r)];
}

std::string operand_json(const VectorOperand& o) {
  if (!o.is_memory) return "{\"reg\": " + std::to_string(o.reg) + "}";
  return std::string("{\"base\": \"") + gpr_name(o.base) +
         "\", \"displacement\": " + std::to_string(o.displacement) +
         ", \"broadcast\": " + (o.broadcast ? "true" : "false") + "}";
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

// Every form at many registers, bases and displacements.
void write_forms(std::ostream& out, bool wide) {
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
                        {wide ? "vrndscalepd" : "vroundpd", opcode::kRound, 1, 8, true},
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
  std::vector<int> registers{0, 1, 7, 8, 15};
  if (wide) registers.insert(registers.end(), {16, 23, 24, 31});
  const Gpr bases[] = {Gpr::Rax, Gpr::Rcx, Gpr::Rsp, Gpr::Rbp, Gpr::Rdi,
                       Gpr::R8,  Gpr::R9,  Gpr::R12, Gpr::R13};
  const int displacements[] = {0,   8,   -8,   64,   -64,  32,   1016,  1024,   -1024,  -1032,
                               127, 128, -128, -129, 8128, 8192, -8192, 100000, -100000};
  bool first = true;
  const auto emit = [&](const char* name, Opcode op, int reg, int vreg, const VectorOperand& second,
                        int immediate, int sources) {
    Assembler a(wide);
    a.vector(op, reg, vreg, second, immediate);
    out << (first ? "\n" : ",\n") << "{\"hex\": \"" << hex(a.bytes().data(), a.bytes().size())
        << "\", \"wide\": " << (wide ? "true" : "false") << ", \"name\": \"" << name << "\", \"regs\": ["
        << reg;
    if (sources == 2) out << ", " << vreg;
    out << "], \"last\": " << operand_json(second) << ", \"immediate\": " << immediate << "}";
    first = false;
  };
  for (const Form& f : forms) {
    for (const int r : registers) {
      for (const int v : f.sources == 2 ? registers : std::vector<int>{0}) {
        for (const int m : registers)
          emit(f.name, f.op, r, v, VectorOperand::in_register(m), f.immediate, f.sources);
      }
    }
    for (const Gpr base : bases) {
      for (const int d : displacements) {
        const int r = registers[static_cast<size_t>(d & 3)], v = f.sources == 2 ? registers.back() : 0;
        emit(f.name, f.op, r, v, VectorOperand::in_memory(base, d), f.immediate, f.sources);
        if (wide && f.broadcasts)
          emit(f.name, f.op, r, v, VectorOperand::in_memory(base, d, true), f.immediate, f.sources);
      }
    }
  }
  for (const Gpr base : bases) {
    for (const int d : displacements) {
      emit("vmovupd store", opcode::kStore, registers.back(), 0, VectorOperand::in_memory(base, d), -1, 1);
      emit("vbroadcastsd", opcode::kBroadcast, registers.back(), 0, VectorOperand::in_memory(base, d), -1, 1);
    }
  }
  for (const int r : registers) {
    for (const int v : registers) {
      // Shifts name their target in the second place.
      emit("vpsllq", opcode::kShiftImmediate, 6, r, VectorOperand::in_register(v), 52, 2);
      emit("vpsrlq", opcode::kShiftImmediate, 2, r, VectorOperand::in_register(v), 52, 2);
      if (wide) emit("vpternlogq", opcode::kTernary, r, v, VectorOperand::in_register(registers[3]), 0xca, 2);
      if (wide) emit("vcmppd", opcode::kCompare, 1, r, VectorOperand::in_register(v), 0x11, 2);
      if (!wide) emit("vcmppd", opcode::kCompare, r, v, VectorOperand::in_register(registers[4]), 0x12, 2);
      if (!wide) emit("vblendvpd", opcode::kBlend, r, v, VectorOperand::in_memory(Gpr::Rdi, 64), 9 << 4, 2);
    }
    if (wide) emit("vpmovm2q", opcode::kMaskToVector, r, 0, VectorOperand::in_register(1), -1, 1);
  }
}

void write_array(std::ostream& out, const std::vector<double>& values) {
  for (size_t k = 0; k < values.size(); ++k) out << (k ? ", " : "") << std::bit_cast<uint64_t>(values[k]);
}

void write_kernel(std::ostream& out, const std::string& name, const Scalar& energy, const Samples& s,
                  Backend backend) {
  const Program program = hessian_program(energy);
  const MachineCode code = assemble_x86_64(program, backend);
  const Kernel reference = compile(energy, Backend::Interpreter);
  const size_t outputs = static_cast<size_t>(reference.output_count(Order::Hessian)),
               blocks = s.unknowns.size() / kLanes;
  const Lanes u = pack(reference.unknown_count(), s.unknowns),
              e = pack(reference.element_count(), s.elements);
  Lanes expected(blocks * outputs * kLanes);
  reference.evaluate(Order::Hessian, u.data(), e.data(), s.uniforms.data(), expected.data(),
                     static_cast<int64_t>(blocks));
  const auto values = [](const Lanes& l) { return std::vector<double>(l.data(), l.data() + l.size()); };
  out << "{\"name\": \"" << name << "\", \"wide\": " << (backend == Backend::Avx512 ? "true" : "false")
      << ", \"blocks\": " << blocks << ", \"instruction_bytes\": " << code.instruction_bytes
      << ", \"spills\": " << code.spill_count << ", \"hex\": \"" << hex(code.bytes.data(), code.bytes.size())
      << "\", \"unknowns\": [";
  write_array(out, values(u));
  out << "], \"elements\": [";
  write_array(out, values(e));
  out << "], \"uniforms\": [";
  write_array(out, s.uniforms);
  out << "], \"expected\": [";
  write_array(out, values(expected));
  out << "]}";
}

}  // namespace

TEST_CASE("every energy assembles for both instruction sets") {
  for (const auto& e : bench::all_energies()) {
    CAPTURE(e.name);
    Graph graph;
    const Program program = hessian_program(e.build(graph));
    const MachineCode narrow = assemble_x86_64(program, Backend::Avx2),
                      wide = assemble_x86_64(program, Backend::Avx512);
    CHECK(narrow.instruction_bytes > 3 * static_cast<int>(program.instructions.size()));
    CHECK(wide.spill_count < narrow.spill_count);
    CHECK(wide.bytes.size() > static_cast<size_t>(wide.instruction_bytes));
  }
}

TEST_CASE("instruction forms and kernels are written for the independent decoder") {
  const char* path = std::getenv("STARK_MACHINE_CODE_DUMP");
  if (!path) return;
  std::ofstream out(path);
  out << "{\"forms\": [";
  write_forms(out, false);
  out << ",";
  write_forms(out, true);
  out << "],\n\"kernels\": [";
  Random random(41);
  bool first = true;
  const auto add = [&](const std::string& name, const Scalar& energy, const Samples& s) {
    for (const Backend backend : {Backend::Avx2, Backend::Avx512}) {
      out << (first ? "\n" : ",\n");
      write_kernel(out, name, energy, s, backend);
      first = false;
    }
  };
  for (const auto& e : bench::all_energies()) {
    Graph graph;
    Samples s;
    s.uniforms = e.uniforms;
    for (int k = 0; k < 2 * kLanes; ++k) {
      s.unknowns.emplace_back();
      s.elements.emplace_back();
      e.sample(random, s.unknowns.back(), s.elements.back());
    }
    add(e.name, e.build(graph), s);
  }
  for (int trial = 0; trial < 6; ++trial) {
    Graph graph;
    const Scalar energy = random_expression(graph, random, 5, 3, 2, 60);
    Samples s;
    s.uniforms = {0.3, -0.8};
    for (int k = 0; k < kLanes; ++k) {
      s.unknowns.emplace_back();
      s.elements.emplace_back();
      for (int i = 0; i < 5; ++i) s.unknowns.back().push_back(uniform(random, -2.0, 2.0));
      for (int i = 0; i < 3; ++i) s.elements.back().push_back(uniform(random, -2.0, 2.0));
    }
    add("random " + std::to_string(trial), energy, s);
  }
  out << "]}\n";
  CHECK(out.good());
}
