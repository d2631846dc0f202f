// Machine code for AArch64 as bytes, on any processor; tests/symbolic/backend/test_executable.cpp runs it
// where it can be run, which tools/aarch64.sh does under emulation.
#include <stark/symbolic/backend/aarch64.h>

#include <doctest/doctest.h>
#include <stark/symbolic/diff.h>
#include <stark/symbolic/lower.h>

#include "../../../benchmarks/kernels/energies.h"
#include "symbolic/support.h"

using namespace stark::symbolic;
using namespace stark::symbolic::test;

TEST_CASE("every energy assembles for AArch64") {
  for (const auto& e : bench::all_energies()) {
    CAPTURE(e.name);
    Graph graph;
    const Scalar energy = e.build(graph);
    const std::vector<std::vector<NodeId>> roots{{energy.id()}};
    const Program program = lower(graph, roots);
    const MachineCode code = assemble_aarch64(program);
    const auto instructions = static_cast<int>(program.instructions.size());
    CHECK(code.instruction_bytes % 4 == 0);
    CHECK(code.instruction_bytes > 4 * instructions);
    CHECK(code.first_constant % 64 == 0);
    CHECK(code.bytes.size() ==
          static_cast<size_t>(code.first_constant) + 2 * sizeof(uint64_t) * program.constants.size());
  }
}
