// Time per element of energy, gradient and Hessian kernels on every back end of this machine, and time to
// build them. usage: bench_kernels [--json] [--filter NAME] [--milliseconds N]
#include "energies.h"

#include <stark/symbolic/kernel.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <string>
#include <vector>

namespace {

using namespace stark::symbolic;
using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

struct AlignedArray {
  std::vector<double> memory;
  double* data = nullptr;
  explicit AlignedArray(size_t n) : memory(n + 8, 0.0) {
    data = memory.data() + (64 - reinterpret_cast<uintptr_t>(memory.data()) % 64) % 64 / sizeof(double);
  }
};

constexpr int kBlocks = 8;  // 64 elements: everything stays in the first caches

// Fewest nanoseconds per element over many repetitions: the machine may be shared.
double time_kernel(const Kernel& kernel, Order order, const bench::Energy& energy, double budget) {
  AlignedArray u(static_cast<size_t>(kBlocks * kernel.unknown_count() * kLanes));
  AlignedArray e(static_cast<size_t>(kBlocks * kernel.element_count() * kLanes));
  AlignedArray out(static_cast<size_t>(kBlocks * kernel.output_count(order) * kLanes));
  bench::Random random(7);
  for (int block = 0; block < kBlocks; ++block) {
    for (int lane = 0; lane < kLanes; ++lane) {
      std::vector<double> unknowns, elements;
      energy.sample(random, unknowns, elements);
      for (size_t i = 0; i < unknowns.size(); ++i)
        u.data[(block * unknowns.size() + i) * kLanes + lane] = unknowns[i];
      for (size_t i = 0; i < elements.size(); ++i)
        e.data[(block * elements.size() + i) * kLanes + lane] = elements[i];
    }
  }
  double best = 1e9;
  const auto begin = Clock::now();
  do {
    const auto start = Clock::now();
    for (int k = 0; k < 10; ++k)
      kernel.evaluate(order, u.data, e.data, energy.uniforms.data(), out.data, kBlocks);
    best = std::min(best, seconds_since(start) / (10.0 * kBlocks * kLanes));
  } while (seconds_since(begin) < budget);
  return 1e9 * best;
}

}  // namespace

int main(int argc, char** argv) {
  bool json = false;
  std::string filter;
  double budget = 0.05;
  for (int k = 1; k < argc; ++k) {
    if (!std::strcmp(argv[k], "--json"))
      json = true;
    else if (!std::strcmp(argv[k], "--filter") && k + 1 < argc)
      filter = argv[++k];
    else if (!std::strcmp(argv[k], "--milliseconds") && k + 1 < argc)
      budget = 1e-3 * std::atof(argv[++k]);
    else {
      std::fprintf(stderr, "usage: bench_kernels [--json] [--filter NAME] [--milliseconds N]\n");
      return 2;
    }
  }
  std::vector<Backend> backends{Backend::Interpreter};
  for (const Backend b : {Backend::Avx2, Backend::Avx512}) {
    if (b <= best_backend()) backends.push_back(b);
  }
  if (!json) {
    std::printf("%-9s %-11s %7s %7s %7s | %5s %5s %6s | %6s %6s %6s | %13s | %s\n", "energy", "back end",
                "E ns", "EG ns", "EGH ns", "ops", "instr", "spills", "E ms", "EG ms", "EGH ms", "bytes",
                "algorithm");
  }
  bool first = true;
  if (json) std::printf("[");
  for (const auto& energy : bench::all_energies()) {
    if (!filter.empty() && energy.name != filter) continue;
    for (const Backend backend : backends) {
      Kernel kernel;
      double b[3] = {1e9, 1e9, 1e9};  // processor time: the machine may be shared
      for (int k = 0; k < 5; ++k) {
        kernel = Kernel();  // else the next one would be shared with it
        Graph graph;
        kernel = compile(energy.build(graph), backend);
        for (int order = 0; order < 3; ++order) {
          const std::clock_t start = std::clock();
          kernel.prepare(static_cast<Order>(order));
          b[order] = std::min(b[order], static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC);
        }
      }
      const KernelStatistics& s = kernel.statistics();
      double ns[3];
      for (int order = 0; order < 3; ++order)
        ns[order] = time_kernel(kernel, static_cast<Order>(order), energy, budget);
      if (json) {
        std::printf(
            "%s\n  {\"energy\": \"%s\", \"backend\": \"%s\", \"ns\": [%.2f, %.2f, %.2f], \"build_ms\": "
            "[%.3f, %.3f, %.3f], "
            "\"operations\": [%d, %d, %d], \"instructions\": [%d, %d, %d], \"algorithm\": \"%s\"}",
            first ? "" : ",", energy.name.c_str(), to_string(s.backend).c_str(), ns[0], ns[1], ns[2],
            1e3 * b[0], 1e3 * b[1], 1e3 * b[2], s.operations[0], s.operations[1], s.operations[2],
            s.instructions[0], s.instructions[1], s.instructions[2], s.algorithm.c_str());
      } else {
        std::printf("%-9s %-11s %7.1f %7.1f %7.1f | %5d %5d %6d | %6.2f %6.2f %6.2f | %13zu | %s\n",
                    energy.name.c_str(), to_string(s.backend).c_str(), ns[0], ns[1], ns[2], s.operations[2],
                    s.instructions[2], s.spill_slots[2], 1e3 * b[0], 1e3 * b[1], 1e3 * b[2], s.code_bytes[2],
                    s.algorithm.c_str());
      }
      first = false;
      std::fflush(stdout);
    }
  }
  if (json) std::printf("\n]\n");
  return 0;
}
