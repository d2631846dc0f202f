// Time per element of every registered potential on every back end of this machine, and time to build its
// kernel. usage: bench_potentials [--json]
#include <stark/sim/scene/registry.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <ctime>

#include <support/potential_sample.h>

namespace {

using namespace stark;
using symbolic::Backend;
using symbolic::kLanes;
using symbolic::Order;
using Clock = std::chrono::steady_clock;

constexpr int kBlocks = 8;        // 64 elements: everything stays in the first caches
constexpr double kBudget = 0.03;  // seconds of measuring per number

/// Fewest nanoseconds per element over many repetitions: the machine may be shared.
double time_kernel(const Potential& potential, const test::FilledSample& sample, Order order) {
  const symbolic::Kernel& kernel = potential.kernel();
  AlignedVector<double> unknowns(kBlocks * kernel.unknown_count() * kLanes);
  AlignedVector<double> elements(kBlocks * potential.element_width() * kLanes + 1);
  AlignedVector<double> uniforms(potential.uniform_width() + 1),
      out(kBlocks * kernel.output_count(order) * kLanes);
  for (int block = 0; block < kBlocks; ++block)
    test::fill_inputs(potential, sample, sample.x, unknowns.data() + block * kernel.unknown_count() * kLanes,
                      elements.data() + block * potential.element_width() * kLanes, uniforms.data());
  double best = 1e9;
  const auto begin = Clock::now();
  do {
    const auto start = Clock::now();
    for (int k = 0; k < 10; ++k)
      kernel.evaluate(order, unknowns.data(), elements.data(), uniforms.data(), out.data(), kBlocks);
    best = std::min(best,
                    std::chrono::duration<double>(Clock::now() - start).count() / (10.0 * kBlocks * kLanes));
  } while (std::chrono::duration<double>(Clock::now() - begin).count() < kBudget);
  return 1e9 * best;
}

/// Processor time to define, differentiate and compile the Hessian kernel, least of three [ms].
double time_build(const PotentialDefinition& definition, Backend backend) {
  double best = 1e9;
  for (int k = 0; k < 3; ++k) {
    const std::clock_t start = std::clock();
    const Potential potential(definition, backend);
    potential.kernel().prepare(Order::Hessian);
    best = std::min(best, 1e3 * static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC);
  }
  return best;
}

}  // namespace

int main(int argc, char** argv) {
  const bool json = argc > 1 && !std::strcmp(argv[1], "--json");
  std::vector<Backend> backends{Backend::Interpreter};
  for (const Backend backend : {Backend::Avx2, Backend::Avx512})
    if (backend <= symbolic::best_backend()) backends.push_back(backend);
  if (!json)
    std::printf("| potential | back end | E | EG | EGH | build EGH [ms] |\n|---|---|--:|--:|--:|--:|\n");
  const char* separator = "[\n  ";
  for (const PotentialDefinition& definition : registered_potentials())
    for (const Backend backend : backends) {
      const double build = time_build(definition, backend);
      const Potential potential(definition, backend);
      std::mt19937_64 random(7);
      const test::FilledSample sample = test::fill_sample(definition, potential, random);
      double ns[3];
      for (int order = 0; order < 3; ++order)
        ns[order] = time_kernel(potential, sample, static_cast<Order>(order));
      std::printf(json ? "%s{\"potential\": \"%s\", \"backend\": \"%s\", \"ns\": [%.2f, %.2f, %.2f], "
                         "\"build_ms\": %.3f}"
                       : "%s| %s | %s | %.1f | %.1f | %.1f | %.2f |\n",
                  json ? separator : "", definition.name.c_str(), to_string(backend).c_str(), ns[0], ns[1],
                  ns[2], build);
      separator = ",\n  ";
    }
  if (json) std::printf("\n]\n");
  return 0;
}
