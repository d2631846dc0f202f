// Operators and functions of Scalar: literals are computed at once, everything else becomes a node.
// Phase: model building.
#include <stark/base/error.h>
#include <stark/symbolic/expr.h>

#include <cmath>
#include <numbers>
#include <string>

namespace stark::symbolic {

namespace {

Graph* common_graph(const Scalar& a, const Scalar& b, const char* what) {
  if (a.graph() && b.graph() && a.graph() != b.graph()) {
    throw InvalidArgument(
        std::string(what) +
        ": the operands belong to two different graphs; build one expression in one graph.");
  }
  return a.graph() ? a.graph() : b.graph();
}

void require_number(const Scalar& a, const char* what) {
  if (a.is_condition()) {
    throw InvalidArgument(std::string(what) +
                          ": the operand is a condition, not a number; use select(condition, a, b).");
  }
}

void require_condition(const Scalar& a, const char* what) {
  if (!a.is_condition()) {
    throw InvalidArgument(std::string(what) +
                          ": the operand is a number, not a condition; compare it first, as in x > 0.0.");
  }
}

NodeId node_in(Graph* graph, const Scalar& a) { return a.is_literal() ? graph->constant(a.value()) : a.id(); }

Scalar apply(Op op, const Scalar& a, const Scalar& b, const char* what) {
  require_number(a, what);
  require_number(b, what);
  if (a.is_literal() && b.is_literal()) {
    // Two literals: a throwaway graph folds them by the one set of rules.
    Graph graph;
    return graph.node(graph.binary(op, graph.constant(a.value()), graph.constant(b.value()))).value;
  }
  Graph* graph = common_graph(a, b, what);
  return Scalar(graph, graph->binary(op, node_in(graph, a), node_in(graph, b)));
}

Scalar apply(Op op, const Scalar& a, const char* what) {
  require_number(a, what);
  if (a.is_literal()) {
    Graph graph;
    return graph.node(graph.unary(op, graph.constant(a.value()))).value;
  }
  return Scalar(a.graph(), a.graph()->unary(op, a.id()));
}

Scalar compare(Op op, const Scalar& a, const Scalar& b) {
  require_number(a, "comparison");
  require_number(b, "comparison");
  if (a.is_constant() && b.is_constant()) {
    return Scalar::literal_condition(op == Op::Less ? a.value() < b.value() : a.value() <= b.value());
  }
  Graph* graph = common_graph(a, b, "comparison");
  return Scalar(graph, graph->binary(op, node_in(graph, a), node_in(graph, b)));
}

}  // namespace

double Scalar::value() const { return graph_ ? graph_->node(id_).value : value_; }
bool Scalar::is_constant() const { return graph_ ? graph_->is_constant(id_) : true; }
bool Scalar::is_condition() const {
  return graph_ ? symbolic::is_condition(graph_->node(id_).op) : condition_;
}

Scalar operator+(const Scalar& a, const Scalar& b) {
  if (a.is_literal() && b.is_literal() && !a.is_condition() && !b.is_condition())
    return a.value() + b.value();
  return apply(Op::Add, a, b, "operator +");
}
Scalar operator-(const Scalar& a, const Scalar& b) {
  if (a.is_literal() && b.is_literal() && !a.is_condition() && !b.is_condition())
    return a.value() - b.value();
  return apply(Op::Sub, a, b, "operator -");
}
Scalar operator*(const Scalar& a, const Scalar& b) {
  if (a.is_literal() && b.is_literal() && !a.is_condition() && !b.is_condition())
    return a.value() * b.value();
  return apply(Op::Mul, a, b, "operator *");
}
Scalar operator/(const Scalar& a, const Scalar& b) {
  if (a.is_literal() && b.is_literal() && !a.is_condition() && !b.is_condition())
    return a.value() / b.value();
  return apply(Op::Div, a, b, "operator /");
}
Scalar operator-(const Scalar& a) { return apply(Op::Neg, a, "operator -"); }
Scalar& Scalar::operator+=(const Scalar& b) { return *this = *this + b; }
Scalar& Scalar::operator-=(const Scalar& b) { return *this = *this - b; }
Scalar& Scalar::operator*=(const Scalar& b) { return *this = *this * b; }
Scalar& Scalar::operator/=(const Scalar& b) { return *this = *this / b; }

Scalar operator<(const Scalar& a, const Scalar& b) { return compare(Op::Less, a, b); }
Scalar operator<=(const Scalar& a, const Scalar& b) { return compare(Op::LessEqual, a, b); }
Scalar operator>(const Scalar& a, const Scalar& b) { return compare(Op::Less, b, a); }
Scalar operator>=(const Scalar& a, const Scalar& b) { return compare(Op::LessEqual, b, a); }

Scalar operator&&(const Scalar& a, const Scalar& b) {
  require_condition(a, "operator &&");
  require_condition(b, "operator &&");
  if (a.is_literal()) return a.value() != 0.0 ? b : a;
  if (b.is_literal()) return b.value() != 0.0 ? a : b;
  Graph* graph = common_graph(a, b, "operator &&");
  return Scalar(graph, graph->binary(Op::And, a.id(), b.id()));
}
Scalar operator||(const Scalar& a, const Scalar& b) {
  require_condition(a, "operator ||");
  require_condition(b, "operator ||");
  if (a.is_literal()) return a.value() != 0.0 ? a : b;
  if (b.is_literal()) return b.value() != 0.0 ? b : a;
  Graph* graph = common_graph(a, b, "operator ||");
  return Scalar(graph, graph->binary(Op::Or, a.id(), b.id()));
}
Scalar operator!(const Scalar& a) {
  require_condition(a, "operator !");
  if (a.is_literal()) return Scalar::literal_condition(a.value() == 0.0);
  return Scalar(a.graph(), a.graph()->unary(Op::Not, a.id()));
}

Scalar select(const Scalar& condition, const Scalar& a, const Scalar& b) {
  require_condition(condition, "select");
  require_number(a, "select");
  require_number(b, "select");
  if (condition.is_literal()) return condition.value() != 0.0 ? a : b;
  Graph* graph = common_graph(condition, a, "select");
  common_graph(condition, b, "select");
  return Scalar(graph, graph->select(condition.id(), node_in(graph, a), node_in(graph, b)));
}

Scalar min(const Scalar& a, const Scalar& b) { return apply(Op::Min, a, b, "min"); }
Scalar max(const Scalar& a, const Scalar& b) { return apply(Op::Max, a, b, "max"); }
Scalar abs(const Scalar& a) { return apply(Op::Abs, a, "abs"); }
Scalar sqrt(const Scalar& a) { return apply(Op::Sqrt, a, "sqrt"); }
Scalar square(const Scalar& a) { return a * a; }
Scalar exp(const Scalar& a) { return apply(Op::Exp, a, "exp"); }
Scalar log(const Scalar& a) { return apply(Op::Log, a, "log"); }
Scalar sin(const Scalar& a) { return apply(Op::Sin, a, "sin"); }
Scalar cos(const Scalar& a) { return apply(Op::Cos, a, "cos"); }
Scalar tan(const Scalar& a) { return apply(Op::Tan, a, "tan"); }
Scalar asin(const Scalar& a) { return apply(Op::Asin, a, "asin"); }
Scalar acos(const Scalar& a) { return apply(Op::Acos, a, "acos"); }
Scalar atan(const Scalar& a) { return apply(Op::Atan, a, "atan"); }
Scalar atan2(const Scalar& y, const Scalar& x) { return apply(Op::Atan2, y, x, "atan2"); }
Scalar sinh(const Scalar& a) {
  // Near zero the difference of exponentials cancels: sinh a = 2 t / (1 - t^2), t = tanh(a / 2). Far away
  // exp(a) is infinite before exp(a) / 2 is: e / 2 exp(a - 1), where a - 1 is exact.
  const Scalar t = tanh(0.5 * a);
  const Scalar far = 0.5 * std::numbers::e * (exp(a - 1.0) - exp(-a - 1.0));
  return select(abs(a) < 1.0, 2.0 * t / (1.0 - t * t), far);
}
Scalar cosh(const Scalar& a) {
  // The same for its derivative, with cosh a = (1 + t^2) / (1 - t^2).
  const Scalar t = tanh(0.5 * a);
  const Scalar far = 0.5 * std::numbers::e * (exp(a - 1.0) + exp(-a - 1.0));
  return select(abs(a) < 1.0, (1.0 + t * t) / (1.0 - t * t), far);
}
Scalar tanh(const Scalar& a) { return apply(Op::Tanh, a, "tanh"); }
Scalar held(const Scalar& a) { return apply(Op::Held, a, "held"); }

Scalar fma(const Scalar& a, const Scalar& b, const Scalar& c) {
  require_number(a, "fma");
  require_number(b, "fma");
  require_number(c, "fma");
  Graph* graph = common_graph(a, b, "fma");
  if (!graph) graph = c.graph();
  if (!graph) return std::fma(a.value(), b.value(), c.value());
  common_graph(Scalar(graph, 0), c, "fma");
  return Scalar(graph, graph->fma(node_in(graph, a), node_in(graph, b), node_in(graph, c)));
}

Scalar pow(const Scalar& a, int exponent) {
  require_number(a, "pow");
  if (exponent == 0) return 1.0;
  unsigned n = exponent < 0 ? 0u - static_cast<unsigned>(exponent) : static_cast<unsigned>(exponent);
  Scalar power = 1.0, base = a;
  for (; n; n >>= 1) {
    if (n & 1u) power *= base;
    if (n > 1) base *= base;
  }
  return exponent < 0 ? 1.0 / power : power;
}

Scalar pow(const Scalar& a, double exponent) {
  if (exponent == std::floor(exponent) && std::fabs(exponent) <= 64.0)
    return pow(a, static_cast<int>(exponent));
  if (exponent == 0.5) return sqrt(a);
  return apply(Op::Pow, a, Scalar(exponent), "pow");
}

Scalar pow(const Scalar& a, const Scalar& exponent) {
  if (exponent.is_constant() && !exponent.is_condition()) return pow(a, exponent.value());
  return apply(Op::Pow, a, exponent, "pow");
}

bool is_same(const Scalar& a, const Scalar& b) {
  if (a.is_constant() && b.is_constant())
    return a.value() == b.value() && a.is_condition() == b.is_condition();
  return a.graph() == b.graph() && a.id() == b.id();
}

}  // namespace stark::symbolic
