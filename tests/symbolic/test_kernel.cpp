// Interface of kernels and functions: counts, layout, constants, sharing, threads.
#include <doctest/doctest.h>

#include <stark/symbolic/evaluate.h>

#include "symbolic/support.h"

#include <thread>

using namespace stark::symbolic;
using namespace stark::symbolic::test;

TEST_CASE("outputs are energy, gradient and upper triangle, lane by lane") {
  for (const Backend backend : {Backend::Interpreter, Backend::Automatic}) {
    Graph graph;
    const Scalar x = graph.input(InputKind::Unknown), y = graph.input(InputKind::Unknown),
                 unused = graph.input(InputKind::Unknown);
    const Scalar e = graph.input(InputKind::Element), p = graph.input(InputKind::Uniform);
    const Kernel kernel = compile(p * x * x * y + e * log(x), backend);
    CHECK(kernel.unknown_count() == 3);
    CHECK(kernel.element_count() == 1);
    CHECK(kernel.uniform_count() == 1);
    CHECK(kernel.output_count(Order::Energy) == 1);
    CHECK(kernel.output_count(Order::Gradient) == 4);
    CHECK(kernel.output_count(Order::Hessian) == 10);
    Samples s;
    s.uniforms = {0.5};
    for (int k = 0; k < 24; ++k) {
      s.unknowns.push_back({1.0 + k, 2.0 - 0.1 * k, 77.0});
      s.elements.push_back({3.0 + k});
    }
    const auto out = run(kernel, Order::Hessian, s);
    for (size_t k = 0; k < 24; ++k) {
      const double X = s.unknowns[k][0], Y = s.unknowns[k][1], E = s.elements[k][0], P = 0.5;
      const double expected[] = {P * X * X * Y + E * std::log(X),
                                 2 * P * X * Y + E / X,
                                 P * X * X,
                                 0.0,
                                 2 * P * Y - E / (X * X),
                                 2 * P * X,
                                 0.0,
                                 0.0,
                                 0.0,
                                 0.0};
      for (size_t i = 0; i < 10; ++i) CHECK(out[k][i] == doctest::Approx(expected[i]).epsilon(1e-14));
    }
    static_cast<void>(unused);
  }
}

TEST_CASE("powers of zero have the same bits on every back end") {
  Graph graph;
  const Scalar x = graph.input(InputKind::Unknown), a = graph.input(InputKind::Unknown);
  const Scalar p = graph.input(InputKind::Element);
  Samples s;
  for (const double exponent : {0.0, 1.0, 1.5, 2.0, 2.5, 3.0})
    for (const double base : {0.0, -0.0, 1e-300, 0.7}) {
      s.unknowns.push_back({base, exponent});
      s.elements.push_back({exponent});
    }
  const auto out = run(compile(pow(x, a) + pow(x, p), Backend::Interpreter), Order::Hessian, s);
  const auto same = run(compile(pow(x, a) + pow(x, p), Backend::Automatic), Order::Hessian, s);
  for (size_t k = 0; k < out.size(); ++k) {
    CAPTURE(s.unknowns[k][1]);
    for (size_t i = 0; i < out[k].size(); ++i) CHECK(same_bits(out[k][i], same[k][i]));
    CHECK(std::isfinite(out[k][1]));
    if (s.unknowns[k][0] == 0.0 && s.unknowns[k][1] >= 1.0)
      CHECK(out[k][1] == (s.unknowns[k][1] == 1.0 ? 2.0 : 0.0));
  }
}

TEST_CASE("constants and linear energies") {
  Graph graph;
  const Scalar x = graph.input(InputKind::Unknown), p = graph.input(InputKind::Uniform);
  for (const Backend backend : {Backend::Interpreter, Backend::Automatic}) {
    Samples s;
    s.uniforms = {4.0};
    s.unknowns = {{2.0}, {3.0}};
    const auto linear = run(compile(p * x, backend), Order::Hessian, s);
    CHECK(linear[1] == std::vector<double>{12.0, 4.0, 0.0});
    const auto only_input = run(compile(x, backend), Order::Hessian, s);
    CHECK(only_input[1] == std::vector<double>{3.0, 1.0, 0.0});
    const auto constant =
        run(compile(x * 0.0 + Scalar(&graph, graph.constant(5.0)), backend), Order::Hessian, s);
    CHECK(constant[0] == std::vector<double>{5.0, 0.0, 0.0});
    const Kernel literal = compile(Scalar(2.5), backend);
    CHECK(literal.unknown_count() == 0);
    Lanes out(kLanes);
    literal.evaluate(Order::Hessian, nullptr, nullptr, nullptr, out.data(), 1);
    CHECK(out[7] == 2.5);
    compile(p * x, backend)
        .evaluate(Order::Energy, nullptr, nullptr, s.uniforms.data(), nullptr,
                  0);  // no blocks: nothing happens
  }
}

TEST_CASE("nothing is written outside of the output") {
  Random random(31);
  Graph graph;
  const Scalar energy = random_expression(graph, random, 4, 2, 1, 60);
  for (const Backend backend : {Backend::Interpreter, Backend::Automatic}) {
    const Kernel kernel = compile(energy, backend);
    const size_t n = static_cast<size_t>(kernel.output_count(Order::Hessian)) * kLanes * 3;
    Lanes u(4 * kLanes * 3), e(2 * kLanes * 3), guarded(n + 2 * kLanes);
    const double p[] = {0.3};
    for (size_t i = 0; i < guarded.size(); ++i) guarded[i] = -12345.0;
    kernel.evaluate(Order::Hessian, u.data(), e.data(), p, guarded.data() + kLanes, 3);
    for (size_t i = 0; i < kLanes; ++i) {
      CHECK(guarded[i] == -12345.0);
      CHECK(guarded[n + kLanes + i] == -12345.0);
    }
    int untouched = 0;
    for (size_t i = 0; i < n; ++i) untouched += guarded[kLanes + i] == -12345.0;
    CHECK(untouched == 0);
  }
}

TEST_CASE("a kernel outlives its graph, equal kernels are shared") {
  Kernel first, second, third;
  {
    Graph graph;
    const Scalar x = graph.input(InputKind::Unknown);
    first = compile(exp(x) * x);
  }
  {
    Graph graph;
    const Scalar x = graph.input(InputKind::Unknown);
    static_cast<void>(sin(x));  // another history of the graph does not matter
    second = compile(exp(x) * x);
    third = compile(exp(x) * x + 1.0);
  }
  CHECK(&first.statistics() == &second.statistics());
  CHECK(&first.statistics() != &third.statistics());
  CHECK(first.fingerprint() == second.fingerprint());
  CHECK(first.fingerprint() != third.fingerprint());
  Samples s;
  s.unknowns = {{0.25}};
  CHECK(run(first, Order::Gradient, s)[0][1] == doctest::Approx(std::exp(0.25) * 1.25).epsilon(1e-15));
}

TEST_CASE("the fingerprint is that of the formula, on every back end") {
  Graph graph;
  const Scalar x = graph.input(InputKind::Unknown), y = graph.input(InputKind::Unknown);
  const auto of = [](const Scalar& energy, Backend backend = Backend::Automatic) {
    return compile(energy, backend).fingerprint();
  };
  CHECK(of(x * y) == of(x * y, Backend::Interpreter));
  CHECK(of(x * y) != of(x * x));
  CHECK(of(2.0 * x) != of(2.5 * x));
  CHECK(of(sin(x)) != of(cos(x)));
}

TEST_CASE("kernels are built and called from several threads") {
  Random random(32);
  Graph graph;
  const Kernel kernel = compile(random_expression(graph, random, 5, 2, 1, 60));
  Samples s;
  s.uniforms = {0.7};
  for (int e = 0; e < 16; ++e) {
    s.unknowns.emplace_back();
    for (int i = 0; i < 5; ++i) s.unknowns.back().push_back(uniform(random, -1.0, 1.0));
    s.elements.push_back({0.1 * e, -0.2});
  }
  std::vector<std::vector<std::vector<double>>> results(4);
  std::vector<std::thread> threads;
  for (size_t t = 0; t < 4; ++t) {
    threads.emplace_back([&, t] {
      for (int k = 0; k < 50; ++k) results[t] = run(kernel, static_cast<Order>(k % 3), s);
      results[t] = run(kernel, Order::Hessian, s);
    });
  }
  for (auto& t : threads) t.join();
  for (size_t t = 1; t < 4; ++t) CHECK(results[t] == results[0]);
}

TEST_CASE("statistics describe the kernel") {
  Graph graph;
  const Vec3 a = input_vector<3>(graph, InputKind::Unknown), b = input_vector<3>(graph, InputKind::Unknown);
  const Kernel kernel = compile(norm(cross(a, b)) * exp(dot(a, b)));
  const KernelStatistics& s = kernel.statistics();
  CHECK(s.operations[0] > 10);
  CHECK(s.operations[2] > s.operations[1]);
  CHECK(s.instructions[2] > s.instructions[0]);
  CHECK_FALSE(s.algorithm.empty());
  CHECK(s.backend == best_backend());
  if (s.backend != Backend::Interpreter) CHECK(s.code_bytes[2] > 1000);
}

TEST_CASE("functions have several outputs and no derivatives") {
  Graph graph;
  const Vec3 a = input_vector<3>(graph, InputKind::Unknown);
  const Scalar p = graph.input(InputKind::Uniform);
  const Scalar outputs[] = {norm(a), a[1], 7.0, p * a[2], norm(a)};
  for (const Backend backend : {Backend::Interpreter, Backend::Automatic}) {
    const Function f = compile_function(outputs, backend);
    CHECK(f.output_count() == 5);
    CHECK(f.unknown_count() == 3);
    Lanes u(3 * kLanes), out(5 * kLanes);
    for (size_t l = 0; l < kLanes; ++l) {
      u[l] = 3.0;
      u[kLanes + l] = 4.0 + static_cast<double>(l);
      u[2 * kLanes + l] = 0.0;
    }
    const double uniforms[] = {2.0};
    f.evaluate(u.data(), nullptr, uniforms, out.data(), 1);
    CHECK(out[0] == 5.0);
    CHECK(out[kLanes + 2] == 6.0);
    CHECK(out[2 * kLanes + 3] == 7.0);
    CHECK(out[3 * kLanes] == 0.0);
    CHECK(out[4 * kLanes] == 5.0);
  }
}
