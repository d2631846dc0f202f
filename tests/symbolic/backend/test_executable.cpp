// All back ends of this machine give the same bits: random expressions, benchmark energies, every elementary
// function, special values; also kernels that are larger than the register file by far.
#include <doctest/doctest.h>

#include <stark/base/error.h>
#include <stark/symbolic/backend/cpu.h>

#include "../../../benchmarks/kernels/energies.h"
#include "symbolic/support.h"

#include <limits>

using namespace stark::symbolic;
using namespace stark::symbolic::test;

namespace {

std::vector<Backend> machine_backends() {
  std::vector<Backend> result;
  for (const Backend b : {Backend::Avx2, Backend::Avx512, Backend::Neon}) {
    if (cpu_supports(b)) result.push_back(b);
  }
  return result;
}

// Number of values that differ between the interpreter and machine code.
int differences(const Scalar& energy, const Samples& samples) {
  int count = 0;
  const Kernel reference = compile(energy, Backend::Interpreter);
  for (const Backend backend : machine_backends()) {
    const Kernel kernel = compile(energy, backend);
    REQUIRE(kernel.backend() == backend);
    for (const Order order : {Order::Energy, Order::Gradient, Order::Hessian}) {
      const auto a = run(reference, order, samples), b = run(kernel, order, samples);
      for (size_t e = 0; e < a.size(); ++e) {
        for (size_t i = 0; i < a[e].size(); ++i) count += !same_bits(a[e][i], b[e][i]);
      }
    }
  }
  return count;
}

}  // namespace

TEST_CASE("random expressions have the same bits on every back end") {
  Random random(21);
  for (int trial = 0; trial < 60; ++trial) {
    Graph graph;
    const Scalar energy = random_expression(graph, random, 6, 4, 3, 20 + 2 * trial);
    Samples s;
    for (int i = 0; i < 3; ++i) s.uniforms.push_back(uniform(random, -2.0, 2.0));
    for (int e = 0; e < 24; ++e) {
      s.unknowns.emplace_back();
      s.elements.emplace_back();
      for (int i = 0; i < 6; ++i) s.unknowns.back().push_back(uniform(random, -2.0, 2.0));
      for (int i = 0; i < 4; ++i) s.elements.back().push_back(uniform(random, -2.0, 2.0));
    }
    CAPTURE(trial);
    CHECK(differences(energy, s) == 0);
  }
}

TEST_CASE("benchmark energies have the same bits on every back end") {
  Random random(22);
  for (const auto& e : bench::all_energies()) {
    CAPTURE(e.name);
    Graph graph;
    Samples s;
    s.uniforms = e.uniforms;
    for (int k = 0; k < 64; ++k) {
      s.unknowns.emplace_back();
      s.elements.emplace_back();
      e.sample(random, s.unknowns.back(), s.elements.back());
    }
    CHECK(differences(e.build(graph), s) == 0);
  }
}

TEST_CASE("functions have the same bits at special values") {
  const double inf = std::numeric_limits<double>::infinity(), nan = std::numeric_limits<double>::quiet_NaN();
  const double special[] = {0.0,
                            -0.0,
                            1.0,
                            -1.0,
                            0.5,
                            -0.5,
                            inf,
                            -inf,
                            nan,
                            5e-324,
                            -5e-324,
                            1e-310,
                            1e308,
                            -1e308,
                            1e-16,
                            1.5707963267948966,
                            -3.141592653589793,
                            709.9,
                            -745.2,
                            22.5,
                            1e9,
                            0.9999999999999999,
                            2.5,
                            -3.5};
  Graph graph;
  const Scalar x = graph.input(InputKind::Unknown), y = graph.input(InputKind::Unknown);
  Samples s;
  for (const double a : special) {
    for (const double b : special) s.unknowns.push_back({a, b});
  }
  const Scalar functions[] = {exp(x),
                              log(x),
                              sin(x),
                              cos(x),
                              tan(x),
                              asin(x),
                              acos(x),
                              atan(x),
                              tanh(x),
                              sqrt(x),
                              abs(x),
                              atan2(x, y),
                              pow(x, y),
                              min(x, y),
                              max(x, y),
                              x / y,
                              fma(x, y, x),
                              x * y - x,
                              y - x * y,
                              select(x < y, x, y),
                              select(x <= y, 0.0, x),
                              select(!(x > y), y, 0.0),
                              select(x < 1.0 || y >= 2.0, x - y, 3.0)};
  for (const Scalar& f : functions) {
    CAPTURE(to_string(f));
    CHECK(differences(f, s) == 0);
  }
}

TEST_CASE("large kernels spill and keep their bits") {
  Random random(23);
  Graph graph;
  std::vector<Scalar> x;
  for (int i = 0; i < 30; ++i) x.push_back(graph.input(InputKind::Unknown));
  // Coupled in all pairs, so that many values are alive at once.
  Scalar energy = 0.0;
  for (size_t i = 0; i < x.size(); ++i) {
    for (size_t j = 0; j < i; ++j) energy += sin(x[i] * x[j]) / static_cast<double>(1 + i + j);
  }
  energy = energy * energy + log(1.0 + squared_norm(Vec<3>(x[0], x[1], x[2])));
  Samples s;
  for (int e = 0; e < 16; ++e) {
    s.unknowns.emplace_back();
    for (int i = 0; i < 30; ++i) s.unknowns.back().push_back(uniform(random, -1.0, 1.0));
  }
  CHECK(differences(energy, s) == 0);
  const Jet jet = evaluate_jet(energy, {s.unknowns[3]});
  const auto out = run(compile(energy), Order::Hessian, s)[3];
  size_t k = 31;
  Real error = 0, size = 0;
  for (size_t i = 0; i < 30; ++i) {
    for (size_t j = i; j < 30; ++j, ++k) {
      error = std::max(error, std::fabs(out[k] - jet.h[i * 30 + j]));
      size = std::max(size, std::fabs(jet.h[i * 30 + j]));
    }
  }
  CHECK(error < 1e-13L * size);
}

TEST_CASE("a back end that the machine lacks is refused") {
  Graph graph;
  const Scalar x = graph.input(InputKind::Unknown);
  for (const Backend b : {Backend::Avx2, Backend::Avx512, Backend::Neon}) {
    if (!cpu_supports(b)) CHECK_THROWS_AS(compile(x, b), stark::InvalidArgument);
  }
  CHECK(cpu_supports(best_backend()));
}
