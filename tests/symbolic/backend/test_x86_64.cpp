// Machine code as bytes, also for processors that are not here. With STARK_MACHINE_CODE_DUMP set to a file
// name the second case writes some whole kernels with their expected results as JSON, which
// tests/python/test_encoder.py disassembles and executes with an independent decoder.
#include <doctest/doctest.h>

#include <stark/symbolic/backend/register_allocation.h>
#include <stark/symbolic/backend/x86_64.h>
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

TEST_CASE("kernels are written for the independent decoder") {
  const char* path = std::getenv("STARK_MACHINE_CODE_DUMP");
  if (!path) return;
  std::ofstream out(path);
  out << "{\"kernels\": [";
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
