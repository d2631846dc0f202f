// Functions of arrays: strides, broadcasting, unused entries, orders of derivatives, equal bits, errors.
#include <doctest/doctest.h>

#include <stark/base/error.h>
#include <stark/symbolic/array_function.h>

#include <cmath>
#include <cstring>
#include <numeric>
#include <thread>

using namespace stark;
using namespace stark::symbolic;

namespace {

struct Sample {
  Graph graph;
  std::vector<Scalar> x;
  Scalar a;
  Sample() {
    for (int i = 0; i < 3; ++i) x.push_back(graph.input(InputKind::Element));
    a = graph.input(InputKind::Element);
  }
  std::vector<ArrayArgument> arguments(bool by_x = true, bool by_a = false) const {
    return {{"x", x, by_x}, {"a", {a}, by_a}};
  }
};

std::vector<double> ramp(size_t count) {
  std::vector<double> values(count);
  for (size_t i = 0; i < count; ++i) values[i] = 0.25 + 0.01 * static_cast<double>(i);
  return values;
}

}  // namespace

TEST_CASE("value, gradient and Hessian over batches of every length") {
  Sample s;
  // x[1] is not used: its derivatives are zero.
  const Scalar f[] = {s.a * s.x[0] * s.x[0] * s.x[2] + sin(s.x[2])};
  for (const Backend backend : {Backend::Interpreter, Backend::Automatic}) {
    const ArrayFunction function(f, s.arguments(), backend);
    CHECK(function.output_count() == 1);
    CHECK(function.variable_count() == 3);
    CHECK(function.uses(0));
    CHECK(function.uses(1));
    for (const int64_t count : {0, 1, 7, 8, 9, 63, 64, 65, 200}) {
      const auto x = ramp(static_cast<size_t>(3 * count)), a = ramp(1);
      const StridedArray arrays[] = {{x.data(), {3}, {0, 1, 2}}, {a.data(), {0}, {0}}};
      std::vector<double> values(count, -1.0), first(3 * count), second(9 * count);
      function.evaluate(Order::Hessian, arrays, std::array{count},
                        {values.data(), first.data(), second.data()});
      for (int64_t e = 0; e < count; ++e) {
        const double X = x[3 * e], Z = x[3 * e + 2], A = a[0];
        const double g[] = {2 * A * X * Z, 0.0, A * X * X + std::cos(Z)};
        const double h[] = {2 * A * Z, 0, 2 * A * X, 0, 0, 0, 2 * A * X, 0, -std::sin(Z)};
        CHECK(values[e] == doctest::Approx(A * X * X * Z + std::sin(Z)).epsilon(1e-14));
        for (int i = 0; i < 3; ++i) CHECK(first[3 * e + i] == doctest::Approx(g[i]).epsilon(1e-14));
        for (int i = 0; i < 9; ++i) CHECK(second[9 * e + i] == doctest::Approx(h[i]).epsilon(1e-14));
      }
    }
  }
}

TEST_CASE("several dimensions with broadcast and transposed arrays") {
  Sample s;
  const Scalar f[] = {s.x[0] + 10.0 * s.x[1] + 100.0 * s.x[2] + 1000.0 * s.a};
  const ArrayFunction function(f, s.arguments());
  // x has the batch shape (5, 1) and its components are far apart; a has (5, 7), stored by columns.
  std::vector<double> x(15), a(35);
  std::iota(x.begin(), x.end(), 1.0);
  std::iota(a.begin(), a.end(), 1.0);
  const StridedArray arrays[] = {{x.data(), {1, 0}, {0, 5, 10}}, {a.data(), {1, 5}, {0}}};
  std::vector<double> values(35);
  function.evaluate(Order::Energy, arrays, std::array<int64_t, 2>{5, 7}, {values.data()});
  for (int i = 0; i < 5; ++i) {
    for (int j = 0; j < 7; ++j)
      CHECK(values[7 * i + j] == x[i] + 10 * x[5 + i] + 100 * x[10 + i] + 1000 * a[i + 5 * j]);
  }
}

TEST_CASE("several outputs: Jacobian, zeros and numbers among the outputs") {
  Sample s;
  const Scalar f[] = {s.x[0] * s.a, Scalar(4.0), exp(s.x[2]) * s.a};
  const ArrayFunction function(f, s.arguments(true, true));
  CHECK(function.variable_count() == 4);
  const std::vector<double> x{2.0, 3.0, 0.5}, a{7.0};
  const StridedArray arrays[] = {{x.data(), {}, {0, 1, 2}}, {a.data(), {}, {0}}};
  std::vector<double> values(3), first(12);
  function.evaluate(Order::Gradient, arrays, {}, {values.data(), first.data()});
  const double e = std::exp(0.5);
  const double expected[] = {7, 0, 0, 2, 0, 0, 0, 0, 0, 0, 7 * e, e};
  CHECK(values[0] == 14.0);
  CHECK(values[1] == 4.0);
  CHECK(values[2] == doctest::Approx(7 * e).epsilon(1e-15));
  for (int i = 0; i < 12; ++i) CHECK(first[i] == doctest::Approx(expected[i]).epsilon(1e-15));
  CHECK_THROWS_AS(function.evaluate(Order::Hessian, arrays, {}, {}), InvalidArgument);
  CHECK(function.statistics(Order::Gradient).operations > function.statistics(Order::Energy).operations - 1);
}

TEST_CASE("values have the same bits in every order and on every back end") {
  Sample s;
  const Scalar q = s.x[0] / (s.x[1] + s.a) + log(s.x[2]) * s.x[0];
  const Scalar one[] = {q * q}, two[] = {q * q, q * s.x[1] / s.a};
  for (const std::span<const Scalar> outputs : {std::span<const Scalar>(one), std::span<const Scalar>(two)}) {
    const size_t m = outputs.size();
    const auto x = ramp(3 * 40), a = ramp(40);
    const StridedArray arrays[] = {{x.data(), {3}, {0, 1, 2}}, {a.data(), {1}, {0}}};
    std::vector<double> reference;
    for (const Backend backend : {Backend::Interpreter, Backend::Automatic}) {
      const ArrayFunction function(outputs, s.arguments(), backend);
      for (const Order order : {Order::Energy, Order::Gradient}) {
        std::vector<double> values(40 * m), first(120 * m);
        function.evaluate(order, arrays, std::array<int64_t, 1>{40}, {values.data(), first.data()});
        if (reference.empty()) reference = values;
        CHECK(std::memcmp(values.data(), reference.data(), values.size() * sizeof(double)) == 0);
      }
    }
  }
}

TEST_CASE("several threads use one function") {
  Sample s;
  const Scalar f[] = {s.x[0] * s.x[1], s.x[2] * s.a};
  const ArrayFunction function(f, s.arguments());
  const auto x = ramp(300), a = ramp(1);
  const StridedArray arrays[] = {{x.data(), {3}, {0, 1, 2}}, {a.data(), {0}, {0}}};
  std::vector<std::vector<double>> results(4, std::vector<double>(600));
  std::vector<std::thread> threads;
  for (auto& result : results) {
    threads.emplace_back([&] {
      function.evaluate(Order::Gradient, arrays, std::array<int64_t, 1>{100}, {nullptr, result.data()});
    });
  }
  for (auto& thread : threads) thread.join();
  for (const auto& result : results) CHECK(result == results[0]);
  CHECK(results[0][0] == x[1]);
}

TEST_CASE("what cannot be compiled is refused") {
  Sample s;
  Graph other;
  const Scalar foreign = other.input(InputKind::Element);
  const auto compile = [&](const Scalar& f, std::vector<ArrayArgument> arguments) {
    return ArrayFunction(std::span(&f, 1), arguments);
  };
  CHECK_THROWS_WITH_AS(compile(s.x[0] < s.a, s.arguments()), doctest::Contains("is a condition"), TraceError);
  CHECK_THROWS_WITH_AS(compile(s.x[0] * s.a, {{"x", s.x, true}}), doctest::Contains("is in no argument"),
                       TraceError);
  CHECK_THROWS_WITH_AS(compile(s.a, {{"a", {2.0 * s.a}, true}}), doctest::Contains("is not a symbol"),
                       TraceError);
  CHECK_THROWS_WITH_AS(compile(s.a, {{"a", {s.a}, true}, {"b", {s.a}, false}}), doctest::Contains("twice"),
                       TraceError);
  const ArrayFunction unused = compile(s.a, {{"a", {s.a}, true}, {"b", {foreign}, false}});
  CHECK(unused.uses(0));
  CHECK(!unused.uses(1));
  CHECK_THROWS_AS(unused.evaluate(Order::Energy, {}, {}, {}), InvalidArgument);
}

TEST_CASE("leading dimensions of an array broadcast to the batch, its last ones are the argument's") {
  // An array of shape (3, 1, 2) as an argument of two numbers over a batch (4, 3, 5).
  const int64_t shape[] = {3, 1, 2}, strides[] = {2, 2, 1};
  const StridedArray view = broadcast(nullptr, shape, strides, 1, 3);
  CHECK(view.strides == std::vector<int64_t>{0, 2, 0});
  CHECK(view.offsets == std::vector<int64_t>{0, 1});
}
