#include <stark/symbolic/traced_scalar.h>

#include <limits>
#include <utility>

#include <stark/base/error.h>
#include <stark/symbolic/evaluate.h>
#include <stark/symbolic/lower.h>
#include <stark/symbolic/partial_derivatives.h>

namespace stark::symbolic {

namespace {

TracedScalar in_graph(std::shared_ptr<Graph> graph, const Scalar& value) {
  return {value.graph() ? std::move(graph) : nullptr, value};
}

std::vector<NodeId> symbols_of(const std::vector<TracedScalar>& values, const TracedScalar& anchor,
                               const std::string& name) {
  std::vector<NodeId> ids;
  for (const TracedScalar& value : values) {
    common_graph(anchor, value, name);
    require_kind(value, false, name);
    // Simplification may dissolve intermediate values, as in (2 x) (2 x) = 4 (x x); symbols stay.
    if (value.value.is_constant() || !operands_of(value).empty())
      throw TraceError(name + ": cannot differentiate with respect to " + short_text(value) +
                       ", only with respect to symbols; make the formula a function of that value with "
                       "@stark.symbolic.function and call its gradient, jacobian or hessian");
    ids.push_back(value.value.id());
  }
  return ids;
}

std::vector<TracedScalar> traced(const std::shared_ptr<Graph>& graph, const std::vector<NodeId>& ids) {
  std::vector<TracedScalar> result;
  for (const NodeId id : ids) result.push_back({graph, Scalar(graph.get(), id)});
  return result;
}

}  // namespace

std::shared_ptr<Graph> common_graph(const TracedScalar& a, const TracedScalar& b,
                                    const std::string& operation) {
  if (a.graph && b.graph && a.graph != b.graph)
    throw TraceError(
        operation +
        ": the operands come from two different formulas; every value of a formula has to be made "
        "from its own arguments. Do not keep traced values for later.");
  return a.graph ? a.graph : b.graph;
}

std::string short_text(const TracedScalar& x) { return to_string(x.value, 60); }

void require_kind(const TracedScalar& x, bool condition, const std::string& operation) {
  if (x.value.is_condition() == condition) return;
  if (condition)
    throw TraceError(operation + ": " + short_text(x) +
                     " is a number, not a condition; compare it first, as in x > 0.0");
  throw TraceError(operation + ": " + short_text(x) +
                   " is a condition, not a number; turn it into one by stark.where(condition, a, b)");
}

double constant_value(const TracedScalar& x, const std::string& conversion) {
  if (x.value.is_constant() && !x.value.is_condition()) return x.value.value();
  throw TraceError(conversion + " of the traced value " + short_text(x) +
                   ": a formula is recorded once and then run for many inputs, so its values are not numbers "
                   "yet; use the functions of stark (stark.sqrt, stark.sin, ...) instead of those of math, "
                   "and only fixed numbers as indices, lengths and counts");
}

bool constant_truth(const TracedScalar& x) {
  if (x.value.is_constant()) return x.value.value() != 0.0;
  throw TraceError(
      "the truth of the traced value " + short_text(x) +
      " was asked for (if, while, and, or, not, min, max, sorted): a formula is recorded once and "
      "then run for many inputs, so its values cannot steer Python code: write "
      "stark.where(condition, a, b) for if, `&`, `|`, `~` for and, or, not, and stark.minimum, "
      "stark.maximum for min, max; write both bounds of a < x < b with `&`");
}

void refuse_equality(const TracedScalar& x) {
  throw TraceError("== or != of the traced value " + short_text(x) +
                   ": equality of computed numbers is not part of formulas; compare with <= and >=, or use "
                   "stark.symbolic.is_same(a, b) to ask whether two expressions are the same");
}

void refuse_rounding(const TracedScalar& x) {
  throw TraceError("// and % of the traced value " + short_text(x) +
                   ": rounding has no derivative and is not part of formulas");
}

void refuse_index(const TracedScalar& x) {
  throw TraceError("the traced value " + short_text(x) +
                   " was used as an index or a count; only fixed integers can be");
}

TracedScalar apply(UnaryOperation function, const TracedScalar& a, const char* operation) {
  require_kind(a, false, operation);
  return in_graph(a.graph, function(a.value));
}

TracedScalar apply(BinaryOperation function, const TracedScalar& a, const TracedScalar& b, bool conditions,
                   const char* operation) {
  require_kind(a, conditions, operation);
  require_kind(b, conditions, operation);
  auto graph = common_graph(a, b, operation);
  return in_graph(std::move(graph), function(a.value, b.value));
}

TracedScalar negative(const TracedScalar& a) { return apply(static_cast<UnaryOperation>(operator-), a, "-"); }

TracedScalar inverted(const TracedScalar& a) {
  require_kind(a, true, "~");
  return {a.graph, !a.value};
}

TracedScalar power(const TracedScalar& a, long long exponent) {
  if (exponent > std::numeric_limits<int>::max() || exponent < -std::numeric_limits<int>::max())
    throw TraceError("power: the exponent " + std::to_string(exponent) +
                     " is too large; write it as a float");
  require_kind(a, false, "power");
  return in_graph(a.graph, pow(a.value, static_cast<int>(exponent)));
}

TracedScalar where(const TracedScalar& condition, const TracedScalar& a, const TracedScalar& b) {
  require_kind(condition, true, "where");
  require_kind(a, false, "where");
  require_kind(b, false, "where");
  common_graph(a, b, "where");
  common_graph(condition, a, "where");
  auto graph = common_graph(condition, b, "where");
  if (!graph) graph = a.graph;
  return in_graph(std::move(graph), select(condition.value, a.value, b.value));
}

TracedScalar fused_multiply_add(const TracedScalar& a, const TracedScalar& b, const TracedScalar& c) {
  for (const auto* operand : {&a, &b, &c}) require_kind(*operand, false, "fma");
  common_graph(a, b, "fma");
  common_graph(a, c, "fma");
  auto graph = common_graph(b, c, "fma");
  if (!graph) graph = a.graph;
  return in_graph(std::move(graph), fma(a.value, b.value, c.value));
}

std::string operation_of(const TracedScalar& x) {
  if (!x.graph) return "constant";
  const Op op = x.graph->node(x.value.id()).op;
  if (op == Op::Constant) return "constant";
  return operand_count(op) == 0 ? "input" : name_of(op);
}

std::vector<TracedScalar> operands_of(const TracedScalar& x) {
  std::vector<TracedScalar> result;
  if (!x.graph) return result;
  const Node& n = x.graph->node(x.value.id());
  for (int k = 0; k < operand_count(n.op); ++k)
    result.push_back({x.graph, Scalar(x.graph.get(), n.operands[k])});
  return result;
}

std::string name_of(const TracedScalar& x) { return x.graph ? x.graph->name(x.value.id()) : ""; }

std::vector<std::vector<TracedScalar>> jacobian(const std::vector<TracedScalar>& outputs,
                                                const std::vector<TracedScalar>& wrt) {
  std::vector<std::vector<TracedScalar>> rows;
  for (const TracedScalar& y : outputs) {
    require_kind(y, false, "jacobian");
    if (!y.graph) {
      rows.emplace_back(wrt.size(), TracedScalar{nullptr, Scalar(0.0)});
      continue;
    }
    const auto ids = symbols_of(wrt, y, "jacobian");
    rows.push_back(traced(y.graph, partial_derivatives(*y.graph, y.value.id(), ids)));
  }
  return rows;
}

std::vector<std::vector<TracedScalar>> hessian(const TracedScalar& y, const std::vector<TracedScalar>& wrt) {
  require_kind(y, false, "hessian");
  const size_t n = wrt.size();
  std::vector<std::vector<TracedScalar>> rows(n, std::vector<TracedScalar>(n, {nullptr, Scalar(0.0)}));
  if (!y.graph) return rows;
  const auto entries = second_partial_derivatives(*y.graph, y.value.id(), symbols_of(wrt, y, "hessian"));
  for (size_t i = 0, k = 0; i < n; ++i)
    for (size_t j = i; j < n; ++j, ++k)
      rows[i][j] = rows[j][i] = {y.graph, Scalar(y.graph.get(), entries[k])};
  return rows;
}

std::vector<TracedScalar> substitute(const std::vector<TracedScalar>& expressions,
                                     const std::vector<TracedScalar>& inputs,
                                     const std::vector<TracedScalar>& values) {
  STARK_CHECK(inputs.size() == values.size());
  TracedScalar source, target;
  for (const TracedScalar& y : expressions) source.graph = common_graph(source, y, "substitute");
  if (!source.graph) return expressions;
  for (const TracedScalar& value : values) {
    require_kind(value, false, "argument");
    target.graph = common_graph(target, value, "arguments");
  }
  if (!target.graph) target.graph = std::make_shared<Graph>();
  STARK_CHECK(source.graph != target.graph);
  std::vector<NodeId> image(source.graph->size(), -1), roots;
  for (size_t k = 0; k < inputs.size(); ++k) {
    const Scalar& value = values[k].value;
    image[inputs[k].value.id()] = value.is_literal() ? target.graph->constant(value.value()) : value.id();
  }
  for (const TracedScalar& y : expressions)
    roots.push_back(y.graph ? y.value.id() : source.graph->constant(y.value.value()));
  image.resize(source.graph->size(), -1);
  return traced(target.graph, import_expressions(*source.graph, roots, *target.graph, std::move(image)));
}

}  // namespace stark::symbolic
