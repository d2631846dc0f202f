// Scalars of formulas that are recorded: they keep their graph alive, derivatives are those of the
// expressions, and what cannot be recorded is refused.
#include <doctest/doctest.h>

#include <stark/base/error.h>
#include <stark/symbolic/traced_scalar.h>

using namespace stark;
using namespace stark::symbolic;

namespace {

using Shared = std::shared_ptr<Graph>;

TracedScalar symbol(const Shared& graph) { return {graph, graph->input(InputKind::Unknown)}; }

Scalar plus(const Scalar& a, const Scalar& b) { return a + b; }
Scalar times(const Scalar& a, const Scalar& b) { return a * b; }
Scalar is_less(const Scalar& a, const Scalar& b) { return a < b; }

TracedScalar product(const TracedScalar& a, const TracedScalar& b) { return apply(times, a, b, false, "*"); }

const TracedScalar kTwo{nullptr, Scalar(2.0)};

}  // namespace

TEST_CASE("a traced scalar keeps its graph, numbers have none") {
  auto graph = std::make_shared<Graph>();
  const TracedScalar x = symbol(graph);
  const std::weak_ptr<Graph> watched = graph;
  TracedScalar sum = apply(plus, x, kTwo, false, "+");
  CHECK(sum.graph == graph);
  CHECK(operation_of(sum) == "+");
  REQUIRE(operands_of(sum).size() == 2);
  CHECK(operation_of(x) == "input");
  const TracedScalar four = apply(times, kTwo, kTwo, false, "*");
  CHECK(four.graph == nullptr);
  CHECK(four.value.value() == 4.0);
  graph.reset();
  CHECK_FALSE(watched.expired());
}

TEST_CASE("values of two formulas do not mix") {
  const TracedScalar x = symbol(std::make_shared<Graph>()), y = symbol(std::make_shared<Graph>());
  CHECK_THROWS_AS(product(x, y), TraceError);
  CHECK_THROWS_AS(fused_multiply_add(kTwo, x, y), TraceError);
  CHECK_THROWS_AS(where(apply(is_less, x, kTwo, false, "<"), kTwo, y), TraceError);
  CHECK_THROWS_AS(jacobian({x}, {y}), TraceError);
}

TEST_CASE("conditions are no numbers, and numbers no conditions") {
  const TracedScalar x = symbol(std::make_shared<Graph>());
  const TracedScalar condition = apply(is_less, x, kTwo, false, "<");
  CHECK_THROWS_AS(product(x, condition), TraceError);
  CHECK_THROWS_AS(where(x, x, x), TraceError);
  CHECK_THROWS_AS(hessian(condition, {x}), TraceError);
  CHECK(where(condition, x, kTwo).graph == x.graph);
  CHECK_THROWS_AS(negative(condition), TraceError);
  CHECK_THROWS_AS(inverted(x), TraceError);
  CHECK(negative(kTwo).value.value() == -2.0);
  CHECK(inverted(condition).graph == x.graph);
}

TEST_CASE("powers with integer exponents are products, too large ones are refused") {
  const TracedScalar x = symbol(std::make_shared<Graph>());
  CHECK(is_same(power(x, 2).value, product(x, x).value));
  CHECK_THROWS_AS(power(x, 1LL << 40), TraceError);
}

TEST_CASE("derivatives of x x y") {
  const auto graph = std::make_shared<Graph>();
  const TracedScalar x = symbol(graph), y = symbol(graph), f = product(product(x, x), y);
  const auto rows = jacobian({f, kTwo}, {x, y});
  REQUIRE(rows.size() == 2);
  CHECK(is_same(rows[0][1].value, product(x, x).value));
  CHECK(rows[1][0].value.value() == 0.0);
  const auto second = hessian(f, {x, y});
  CHECK(is_same(second[0][1].value, second[1][0].value));
  CHECK(is_same(second[0][1].value, product(kTwo, x).value));
  CHECK(second[1][1].value.value() == 0.0);
  CHECK_THROWS_AS(jacobian({f}, {product(x, x)}), TraceError);  // only symbols
}

TEST_CASE("expressions of one graph with values of another in place of inputs") {
  const auto graph = std::make_shared<Graph>(), other = std::make_shared<Graph>();
  const TracedScalar x = symbol(graph), y = symbol(graph), u = symbol(other);
  const auto result = substitute({product(x, y), kTwo}, {x, y}, {u, kTwo});
  REQUIRE(result.size() == 2);
  CHECK(result[0].graph == other);
  CHECK(is_same(result[0].value, product(u, kTwo).value));
  CHECK(result[1].value.value() == 2.0);
}

TEST_CASE("values of formulas are not numbers of the language that records them") {
  const TracedScalar x = symbol(std::make_shared<Graph>());
  CHECK(constant_value(kTwo, "float()") == 2.0);
  CHECK(constant_truth(kTwo));
  CHECK_THROWS_AS(constant_value(x, "float()"), TraceError);
  CHECK_THROWS_AS(constant_truth(x), TraceError);
  CHECK_THROWS_AS(refuse_equality(x), TraceError);
  CHECK_THROWS_AS(refuse_rounding(x), TraceError);
  CHECK_THROWS_AS(refuse_index(x), TraceError);
}
