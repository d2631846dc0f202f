// Derivatives with respect to any values: repeated targets, intermediate values, both ways to a Jacobian.
#include <doctest/doctest.h>

#include <stark/symbolic/evaluate.h>
#include <stark/symbolic/partial_derivatives.h>

#include <cmath>

using namespace stark::symbolic;

namespace {

double at(Graph& graph, NodeId id, std::vector<double> values) {
  return evaluate(Scalar(&graph, id), {.unknowns = {}, .elements = values});
}

}  // namespace

TEST_CASE("partial derivatives with respect to inputs of any kind, also given twice") {
  Graph graph;
  const Scalar x = graph.input(InputKind::Element), y = graph.input(InputKind::Element),
               unused = graph.input(InputKind::Element);
  const Scalar f = x * x * y + sin(y);
  const NodeId targets[] = {y.id(), x.id(), unused.id(), y.id()};
  const auto d = partial_derivatives(graph, f.id(), targets);
  const std::vector<double> values{3.0, 0.5, 0.0};
  CHECK(at(graph, d[0], values) == doctest::Approx(9.0 + std::cos(0.5)).epsilon(1e-15));
  CHECK(at(graph, d[1], values) == doctest::Approx(3.0).epsilon(1e-15));
  CHECK(graph.is_constant(d[2], 0.0));
  CHECK(d[3] == d[0]);

  const auto h = second_partial_derivatives(graph, f.id(), targets);
  REQUIRE(h.size() == 10);
  CHECK(at(graph, h[0], values) == doctest::Approx(-std::sin(0.5)).epsilon(1e-15));  // yy
  CHECK(at(graph, h[1], values) == doctest::Approx(6.0).epsilon(1e-15));             // yx
  CHECK(graph.is_constant(h[2], 0.0));
  CHECK(h[3] == h[0]);                                                    // y and y again
  CHECK(at(graph, h[4], values) == doctest::Approx(1.0).epsilon(1e-15));  // xx
}

TEST_CASE("a target in the middle is a variable: nothing behind it counts") {
  Graph graph;
  const Scalar x = graph.input(InputKind::Element);
  const Scalar p = exp(x);
  const Scalar f = p * p + x;
  const NodeId targets[] = {p.id(), x.id()};
  const auto d = partial_derivatives(graph, f.id(), targets);
  CHECK(at(graph, d[0], {0.5}) == doctest::Approx(2.0 * std::exp(0.5)).epsilon(1e-15));
  CHECK(at(graph, d[1], {0.5}) == 1.0);
}

TEST_CASE("Jacobian is the same in reverse and forward mode, and the cheaper one is chosen") {
  // One output of many inputs calls for the reverse sweep, many outputs of one input for the forward one.
  Graph graph;
  std::vector<Scalar> x;
  std::vector<NodeId> inputs;
  for (int i = 0; i < 6; ++i) {
    x.push_back(graph.input(InputKind::Element));
    inputs.push_back(x.back().id());
  }
  Scalar sum = x[0];
  for (int i = 1; i < 6; ++i) sum = sin(sum * x[i]);
  std::vector<NodeId> outputs;
  Scalar power = x[0];
  for (int i = 0; i < 6; ++i) {
    power = exp(0.1 * power);
    outputs.push_back((power * x[1]).id());
  }
  const std::vector<double> values{0.3, 0.7, 1.1, -0.4, 0.9, 0.2};
  for (const auto& roots : {std::vector<NodeId>{sum.id()}, outputs}) {
    const auto entries = jacobian(graph, roots, inputs);
    REQUIRE(entries.size() == roots.size() * 6);
    for (size_t i = 0; i < roots.size(); ++i) {
      const auto row = partial_derivatives(graph, roots[i], inputs);
      for (size_t j = 0; j < 6; ++j) {
        CHECK(at(graph, entries[i * 6 + j], values) ==
              doctest::Approx(at(graph, row[j], values)).epsilon(1e-13));
        std::vector<double> up = values, down = values;
        up[j] += 1e-6;
        down[j] -= 1e-6;
        CHECK(at(graph, entries[i * 6 + j], values) ==
              doctest::Approx((at(graph, roots[i], up) - at(graph, roots[i], down)) / 2e-6).epsilon(1e-7));
      }
    }
  }
}
