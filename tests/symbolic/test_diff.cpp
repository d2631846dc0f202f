// Derivatives of random expressions and of the benchmark energies against second-order jets in extended
// precision; agreement of all algorithms; no NaN from branches that are not taken.
#include <doctest/doctest.h>

#include <stark/symbolic/diff.h>

#include "../../benchmarks/kernels/energies.h"
#include "symbolic/support.h"

#include <limits>

using namespace stark::symbolic;
using namespace stark::symbolic::test;

namespace {

// Largest error of gradient and Hessian relative to the largest entry of each.
struct Errors {
  double value = 0.0, gradient = 0.0, hessian = 0.0;
};

// NaN counts as larger than every number.
Real larger(Real a, Real b) { return a >= b || std::isnan(a) ? a : b; }

Errors compare(const std::vector<double>& out, const Jet& jet) {
  const size_t n = jet.g.size();
  Errors e;
  Real gradient_size = 1e-300L, hessian_size = 1e-300L, ge = 0, he = 0;
  for (const Real g : jet.g) gradient_size = std::max(gradient_size, std::fabs(g));
  for (const Real h : jet.h) hessian_size = std::max(hessian_size, std::fabs(h));
  e.value = static_cast<double>(std::fabs(out[0] - jet.v) / (std::fabs(jet.v) + 1e-3L));
  for (size_t i = 0; i < n; ++i) ge = larger(ge, std::fabs(out[1 + i] - jet.g[i]));
  size_t k = 1 + n;
  for (size_t i = 0; i < n; ++i) {
    for (size_t j = i; j < n; ++j) he = larger(he, std::fabs(out[k++] - jet.h[i * n + j]));
  }
  e.gradient = static_cast<double>(ge / gradient_size);
  e.hessian = static_cast<double>(he / hessian_size);
  return e;
}

std::vector<double> concatenated(const Derivatives& d, Graph& graph, const InputValues& values) {
  std::vector<double> out{evaluate(Scalar(&graph, d.value), values)};
  for (const NodeId id : d.gradient) out.push_back(evaluate(Scalar(&graph, id), values));
  for (const NodeId id : d.hessian) out.push_back(evaluate(Scalar(&graph, id), values));
  return out;
}

constexpr Algorithm kAll[] = {Algorithm::ForwardForward, Algorithm::ReverseForward, Algorithm::EdgePushing,
                              Algorithm::StagedOuter,    Algorithm::StagedInner,    Algorithm::StagedAll};

}  // namespace

TEST_CASE("random expressions agree with jets, kernel by kernel") {
  Random random(1);
  for (int trial = 0; trial < 60; ++trial) {
    Graph graph;
    const Scalar energy = random_expression(graph, random, 5, 3, 2, 10 + trial);
    const Kernel kernel = compile(energy);
    Samples s;
    for (int i = 0; i < 2; ++i) s.uniforms.push_back(uniform(random, -1.0, 1.0));
    for (int e = 0; e < 16; ++e) {
      s.unknowns.emplace_back();
      s.elements.emplace_back();
      for (int i = 0; i < 5; ++i) s.unknowns.back().push_back(uniform(random, -1.0, 1.0));
      for (int i = 0; i < 3; ++i) s.elements.back().push_back(uniform(random, -1.0, 1.0));
    }
    const auto energies = run(kernel, Order::Energy, s), gradients = run(kernel, Order::Gradient, s),
               hessians = run(kernel, Order::Hessian, s);
    for (size_t e = 0; e < s.unknowns.size(); ++e) {
      CAPTURE(trial);
      CAPTURE(e);
      const Errors error =
          compare(hessians[e], evaluate_jet(energy, {s.unknowns[e], s.elements[e], s.uniforms}));
      // Round-off of some hundred operations with mild cancellation.
      CHECK(error.value < 1e-11);
      CHECK(error.gradient < 1e-11);
      CHECK(error.hessian < 1e-10);
      CHECK(same_bits(energies[e][0], hessians[e][0]));
      CHECK(same_bits(energies[e][0], gradients[e][0]));
      for (size_t i = 1; i <= 5; ++i) CHECK(gradients[e][i] == doctest::Approx(hessians[e][i]).epsilon(1e-9));
    }
  }
}

TEST_CASE("all algorithms agree to round-off") {
  Random random(2);
  int staged = 0;
  for (int trial = 0; trial < 30; ++trial) {
    Graph graph;
    const Scalar energy = random_expression(graph, random, 4, 2, 1, 12 + trial);
    const std::vector<NodeId> stages = graph.stages();
    for (int point = 0; point < 4; ++point) {
      std::vector<double> u, el, un{0.37};
      for (int i = 0; i < 4; ++i) u.push_back(uniform(random, -1.0, 1.0));
      for (int i = 0; i < 2; ++i) el.push_back(uniform(random, -1.0, 1.0));
      const Jet jet = evaluate_jet(energy, {u, el, un});
      for (const Algorithm algorithm : kAll) {
        Derivatives d;
        if (!hessian(graph, energy.id(), stages, algorithm, d)) continue;
        staged += algorithm >= Algorithm::StagedOuter;
        CAPTURE(to_string(algorithm));
        CAPTURE(trial);
        const Errors error = compare(concatenated(d, graph, {u, el, un}), jet);
        CHECK(error.gradient < 1e-11);
        CHECK(error.hessian < 1e-10);
      }
    }
  }
  CHECK(staged > 50);  // the staged algorithms were really exercised
}

TEST_CASE("benchmark energies agree with jets") {
  Random random(3);
  for (const auto& e : bench::all_energies()) {
    CAPTURE(e.name);
    Graph graph;
    const Scalar energy = e.build(graph);
    const Kernel kernel = compile(energy);
    Samples s;
    s.uniforms = e.uniforms;
    for (int k = 0; k < 24; ++k) {
      s.unknowns.emplace_back();
      s.elements.emplace_back();
      e.sample(random, s.unknowns.back(), s.elements.back());
      REQUIRE(static_cast<int>(s.elements.back().size()) == kernel.element_count());
    }
    const auto out = run(kernel, Order::Hessian, s);
    for (size_t k = 0; k < out.size(); ++k) {
      const Errors error = compare(out[k], evaluate_jet(energy, {s.unknowns[k], s.elements[k], s.uniforms}));
      CHECK(error.gradient < 1e-10);
      CHECK(error.hessian < 1e-9);  // barriers and angles cancel some digits
    }
  }
}

TEST_CASE("untaken branches leak no NaN into derivatives") {
  Graph graph;
  const Scalar x = graph.input(InputKind::Unknown), y = graph.input(InputKind::Unknown);
  const Scalar root = sqrt(x - 1.0);  // NaN below 1, infinite slope at 1; shared by two selects only
  const Scalar nested = select(x > 1.0, select(y > 0.0, log(y) * root, y), x * y);
  const Scalar energies[] = {
      select(x > 1.0, x * root, x * x * y),
      select(x > 1.0, 2.0 * root, 0.0) + select(x > 1.0, 3.0 * root * y, y),
      nested,
      nested * nested + select(y <= 0.0, square(x), x / y),
      max(x, 1.0) + min(sqrt(x - 1.0), y) * 0.0 + select(!(x > 1.0), exp(y), pow(x - 1.0, 0.3)),
      square(select(x > 1.0 && y > 0.0, pow(x - 1.0, 1.5) * log(y), x + y)),
      select(y > 0.0, 1.0 / y, select(x > 1.0, acos(2.0 / (x + 1.0)), x)),
  };
  for (const Scalar& energy : energies) {
    for (const double px : {0.5, 1.0, 3.0}) {
      for (const double py : {-0.7, 0.0, 0.4}) {
        const std::vector<double> u{px, py};
        const Jet jet = evaluate_jet(energy, {u});
        CAPTURE(to_string(energy));
        CAPTURE(px);
        CAPTURE(py);
        for (const Algorithm algorithm : kAll) {
          Derivatives d;
          if (!hessian(graph, energy.id(), graph.stages(), algorithm, d)) continue;
          const auto out = concatenated(d, graph, {u});
          CAPTURE(to_string(algorithm));
          for (size_t i = 0; i < 2; ++i) CHECK(out[1 + i] == doctest::Approx(static_cast<double>(jet.g[i])));
          CHECK(out[3] == doctest::Approx(static_cast<double>(jet.h[0])));
          CHECK(out[4] == doctest::Approx(static_cast<double>(jet.h[1])));
          CHECK(out[5] == doctest::Approx(static_cast<double>(jet.h[3])));
        }
      }
    }
  }
}

TEST_CASE("powers of zero have the derivatives that exist") {
  // By the base: a, a (a - 1); by the exponent none, as x^a log x vanishes with x. Also one-sided
  // differences.
  struct At {
    double a, value, dx, dxx;
  };
  for (const At at :
       {At{0, 1, 0, 0}, {1, 0, 1, 0}, {1.5, 0, 0, INFINITY}, {2, 0, 0, 2}, {2.5, 0, 0, 0}, {3, 0, 0, 0}}) {
    CAPTURE(at.a);
    Graph graph;
    const Scalar x = graph.input(InputKind::Unknown), a = graph.input(InputKind::Unknown);
    const Scalar p = graph.input(InputKind::Element);
    const std::vector<double> exponent{at.a}, zero{0.0, at.a};
    for (const Algorithm algorithm : kAll) {
      Derivatives d;
      if (!hessian(graph, pow(x, a).id(), graph.stages(), algorithm, d)) continue;
      CAPTURE(to_string(algorithm));
      const auto out = concatenated(d, graph, {zero, exponent});
      CHECK(out[0] == at.value);
      CHECK(out[1] == at.dx);
      CHECK(out[3] == at.dxx);
      if (at.a > 0.0) CHECK(out[2] == 0.0);
      if (at.a > 1.0) CHECK(out[4] == 0.0);
      if (at.a > 0.0) CHECK(out[5] == 0.0);
    }
    Derivatives d;
    REQUIRE(hessian(graph, pow(x, p).id(), graph.stages(), Algorithm::EdgePushing, d));
    const auto values = [&](const Scalar& of, double base) {
      const std::vector<double> unknowns{base, at.a};
      return evaluate(of, {unknowns, exponent});
    };
    const Scalar slope(&graph, d.gradient[0]), curvature(&graph, d.hessian[0]);
    CHECK(values(slope, 0.0) == at.dx);
    CHECK(values(curvature, 0.0) == at.dxx);
    const double h = 1e-6, first = (values(pow(x, p), h) - at.value) / h;
    CHECK(std::fabs(first - at.dx) <= 1.001 * std::sqrt(h));  // x^(a - 1) there, at most h^0.5
    const double second = (values(slope, h) - values(slope, 0.0)) / h;
    if (std::isfinite(at.dxx)) CHECK(std::fabs(second - at.dxx) <= 4.0 * std::sqrt(h));
  }
}

TEST_CASE("held values are constants to every algorithm") {
  Graph graph;
  const Scalar x = graph.input(InputKind::Unknown), y = graph.input(InputKind::Unknown);
  const Scalar h = held(x * sin(y));
  graph.mark_stage(h);
  const Scalar energy = h * square(x) + held(square(h) + y) * y + held(Scalar(2.0));
  const double at[] = {0.7, -1.3};
  const InputValues values{at, {}, {}};
  const double c = 0.7 * std::sin(-1.3);
  const std::vector<double> expected{
      c * 0.49 + (c * c - 1.3) * -1.3 + 2.0, 1.4 * c, c * c - 1.3, 2.0 * c, 0.0, 0.0};
  for (const Algorithm algorithm : kAll) {
    Derivatives d;
    if (!hessian(graph, energy.id(), graph.stages(), algorithm, d)) continue;
    const std::vector<double> out = concatenated(d, graph, values);
    REQUIRE(out.size() == expected.size());
    for (size_t k = 0; k < out.size(); ++k) CHECK(out[k] == doctest::Approx(expected[k]).epsilon(1e-14));
  }
}

TEST_CASE("a root needs derivatives of its last step alone where the energy is stationary in it") {
  // min over n of n^2/2 - x n + n^4/4, whose root n + n^3 = x Newton's method finds.
  Graph graph;
  const Scalar x = graph.input(InputKind::Unknown);
  const auto step = [&](const Scalar& n, const Scalar& of) {
    return n - (n + n * square(n) - of) / (1.0 + 3.0 * square(n));
  };
  Scalar n = 0.0, all = 0.0;
  for (int k = 0; k < 12; ++k) {
    all = step(all, x);
    n = step(n, held(x));
  }
  n = step(n, x);
  const auto energy = [&](const Scalar& at) { return 0.5 * square(at) - x * at + 0.25 * square(square(at)); };
  const double at[] = {1.7};
  const InputValues values{at, {}, {}};
  const auto derivatives = [&](const Scalar& of) {
    return concatenated(cheapest_hessian(graph, of.id(), {}), graph, values);
  };
  const std::vector<double> short_way = derivatives(energy(n)), long_way = derivatives(energy(all));
  for (size_t k = 0; k < 3; ++k) CHECK(short_way[k] == doctest::Approx(long_way[k]).epsilon(1e-12));
}

TEST_CASE("values shared by many branches leak no NaN") {
  // Roots that are NaN below 1, each used under more different conditions than guards keep apart.
  Graph graph;
  const Scalar x = graph.input(InputKind::Unknown), y = graph.input(InputKind::Unknown);
  const Scalar root = sqrt(x - 1.0), other = log(y - 1.0) * root;
  Scalar energy = 0.0;
  for (int k = 0; k < 20; ++k) {
    const Scalar arm = k % 2 ? root * y : other;
    energy += select(x > 1.0 + 0.1 * k && y > 2.0 - 0.01 * k, static_cast<double>(k + 1) * arm, x * y);
    energy += select(x * y > 8.0 + 0.1 * k && x > 1.5 && y > 1.5, root * other, x);
  }
  for (const double px : {0.5, 1.0, 1.35, 2.95, 4.0}) {
    for (const double py : {0.5, 1.0, 1.85, 4.0}) {
      const std::vector<double> u{px, py};
      const Jet jet = evaluate_jet(energy, {u});
      CAPTURE(px);
      CAPTURE(py);
      for (const Algorithm algorithm : kAll) {
        Derivatives d;
        if (!hessian(graph, energy.id(), graph.stages(), algorithm, d)) continue;
        CAPTURE(to_string(algorithm));
        const Errors error = compare(concatenated(d, graph, {u}), jet);
        CHECK(error.gradient < 1e-13);
        CHECK(error.hessian < 1e-13);
      }
    }
  }
}

TEST_CASE("stages behind branches are handled") {
  // The direction of a zero vector is NaN; it is a marked stage and used only where the vector is long.
  Graph graph;
  const Vec3 v = input_vector<3>(graph, InputKind::Unknown);
  const Vec3 n = normalized(v);
  mark_stage(graph, n);
  const Scalar energy = select(squared_norm(v) > 1e-6, n[0] * n[1] + v[2], squared_norm(v));
  const Kernel kernel = compile(energy);
  Samples s;
  s.unknowns = {{0.0, 0.0, 0.0}, {1.0, 2.0, -1.0}};
  const auto out = run(kernel, Order::Hessian, s);
  CHECK(out[0][0] == 0.0);
  for (size_t i = 1; i < 4; ++i) CHECK(out[0][i] == 0.0);
  const double expected[] = {2.0, 0.0, 0.0, 2.0, 0.0, 2.0};
  for (size_t i = 0; i < 6; ++i) CHECK(out[0][4 + i] == expected[i]);
  const Errors error = compare(out[1], evaluate_jet(energy, {s.unknowns[1]}));
  CHECK(error.gradient < 1e-14);
  CHECK(error.hessian < 1e-14);
}

TEST_CASE("finite differences confirm the jets") {
  // An oracle that shares nothing with the engine, on one energy with every kind of node.
  Random random(4);
  for (int trial = 0; trial < 5; ++trial) {
    Graph graph;
    const Scalar energy = random_expression(graph, random, 3, 0, 0, 25);
    std::vector<double> u;
    for (int i = 0; i < 3; ++i) u.push_back(uniform(random, -1.0, 1.0));
    const Jet jet = evaluate_jet(energy, {u});
    const double h = 1e-6;
    for (size_t i = 0; i < 3; ++i) {
      auto plus = u, minus = u;
      plus[i] += h;
      minus[i] -= h;
      const double slope = (evaluate(energy, {plus}) - evaluate(energy, {minus})) / (2.0 * h);
      // Truncation h^2 and cancellation 1e-16 / h, times third derivatives of some tens.
      CHECK(slope == doctest::Approx(static_cast<double>(jet.g[i])).epsilon(1e-5));
    }
  }
}
