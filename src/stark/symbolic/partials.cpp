// Table of the derivatives of every operation. Shared factors (1/b, the value itself) are written so that
// hash-consing finds them again in the energy. Phase: kernel building.
#include <stark/symbolic/partials.h>

#include <stark/base/error.h>

namespace stark::symbolic {

NodeId add_term(Graph& graph, NodeId a, NodeId b) {
  if (a < 0) return b;
  return b < 0 ? a : graph.add(a, b);
}

NodeId multiply_term(Graph& graph, NodeId a, NodeId b) { return a < 0 || b < 0 ? -1 : graph.mul(a, b); }

Arms choice_arms(Graph& graph, NodeId id) {
  const Node n = graph.node(id);
  if (n.op == Op::Select) return {n.operands[0], n.operands[1], n.operands[2]};
  const NodeId a = n.operands[0], b = n.operands[1];
  return {n.op == Op::Min ? graph.binary(Op::Less, a, b) : graph.binary(Op::Less, b, a), a, b};
}

namespace {

struct Raw {
  NodeId d[3] = {-1, -1, -1};
  NodeId dd[3][3] = {{-1, -1, -1}, {-1, -1, -1}, {-1, -1, -1}};
};

NodeId reciprocal(Graph& g, NodeId x) { return g.div(g.constant(1.0), x); }

void unary_partials(Graph& g, NodeId id, const Node& n, bool second, Raw& r) {
  const NodeId x = n.operands[0], f = id, one = g.constant(1.0);
  NodeId& d = r.d[0];
  NodeId& dd = r.dd[0][0];
  switch (n.op) {
    case Op::Neg:
      d = g.constant(-1.0);
      break;
    case Op::Held:
      break;
    case Op::Total:
      refuse_total();
    case Op::Abs:
      d = g.select(g.binary(Op::Less, x, g.constant(0.0)), g.constant(-1.0), one);
      break;
    case Op::Sqrt: {
      const NodeId inverse = reciprocal(g, f);
      d = g.mul(g.constant(0.5), inverse);
      if (second) dd = g.mul(g.constant(-0.25), g.mul(inverse, g.mul(inverse, inverse)));
      break;
    }
    case Op::Exp:
      d = dd = f;
      break;
    case Op::Log:
      d = reciprocal(g, x);
      if (second) dd = g.neg(g.mul(d, d));
      break;
    case Op::Sin:
      d = g.unary(Op::Cos, x);
      if (second) dd = g.neg(f);
      break;
    case Op::Cos:
      d = g.neg(g.unary(Op::Sin, x));
      if (second) dd = g.neg(f);
      break;
    case Op::Tan:
      d = g.add(one, g.mul(f, f));
      if (second) dd = g.mul(g.constant(2.0), g.mul(f, d));
      break;
    case Op::Asin:
    case Op::Acos: {
      // (1 - x)(1 + x) keeps its relative accuracy near |x| = 1.
      NodeId inverse = reciprocal(g, g.unary(Op::Sqrt, g.mul(g.sub(one, x), g.add(one, x))));
      if (n.op == Op::Acos) inverse = g.neg(inverse);
      d = inverse;
      if (second) dd = g.mul(x, g.mul(d, g.mul(d, d)));
      break;
    }
    case Op::Atan:
      d = reciprocal(g, g.add(one, g.mul(x, x)));
      if (second) dd = g.mul(g.constant(-2.0), g.mul(x, g.mul(d, d)));
      break;
    case Op::Tanh:
      d = g.mul(g.sub(one, f), g.add(one, f));
      if (second) dd = g.mul(g.constant(-2.0), g.mul(f, d));
      break;
    default:
      STARK_CHECK(false);
  }
}

// Of a^b. At a = 0 some factors are infinite where others are 0, and the derivative is 0: those by a where
// the exponent is 0 or 1, and those by b of powers that vanish. Exponents that are constants of the formula
// are neither 0 nor 1, so they need no choice.
void power_partials(Graph& g, NodeId id, NodeId a, NodeId b, bool second, Raw& r) {
  const NodeId zero = g.constant(0.0), one = g.constant(1.0);
  const NodeId b1 = g.sub(b, one), power1 = g.binary(Op::Pow, a, b1);
  const auto power2 = [&] { return g.binary(Op::Pow, a, g.sub(b, g.constant(2.0))); };
  if (g.is_constant(b)) {
    r.d[0] = g.mul(b, power1);
    if (second) r.dd[0][0] = g.mul(g.mul(b, b1), power2());
    return;
  }
  const auto less = [&](NodeId x, NodeId y) { return g.binary(Op::Less, x, y); };
  const auto unless_zero = [&](NodeId factor, NodeId power) {
    const NodeId is_not_zero = g.binary(Op::Or, less(factor, zero), less(zero, factor));
    return g.select(g.binary(Op::Or, less(zero, a), is_not_zero), g.mul(factor, power), factor);
  };
  const auto unless_gone = [&](NodeId power, NodeId factor) {
    return g.select(less(zero, power), g.mul(power, factor), power);
  };
  const NodeId log_a = g.unary(Op::Log, a);
  r.d[0] = unless_zero(b, power1);
  r.d[1] = unless_gone(id, log_a);
  if (!second) return;
  r.dd[0][0] = unless_zero(g.mul(b, b1), power2());
  r.dd[0][1] = unless_gone(power1, g.add(one, g.mul(b, log_a)));
  r.dd[1][1] = unless_gone(id, g.mul(log_a, log_a));
}

void binary_partials(Graph& g, NodeId id, const Node& n, bool second, Raw& r) {
  const NodeId a = n.operands[0], b = n.operands[1], one = g.constant(1.0);
  switch (n.op) {
    case Op::Add:
      r.d[0] = r.d[1] = one;
      break;
    case Op::Sub:
      r.d[0] = one;
      r.d[1] = g.constant(-1.0);
      break;
    case Op::Mul:
      r.d[0] = b;
      r.d[1] = a;
      if (second) r.dd[0][1] = one;
      break;
    case Op::Div: {
      const NodeId inverse = reciprocal(g, b);
      r.d[0] = inverse;
      const NodeId slope = g.mul(id, inverse);
      r.d[1] = g.neg(slope);
      if (second) {
        r.dd[0][1] = g.neg(g.mul(inverse, inverse));
        r.dd[1][1] = g.mul(g.constant(2.0), g.mul(slope, inverse));
      }
      break;
    }
    case Op::Pow:
      power_partials(g, id, a, b, second, r);
      break;
    case Op::Atan2: {  // a is y, b is x
      const NodeId inverse = reciprocal(g, g.add(g.mul(a, a), g.mul(b, b)));
      const NodeId u = g.mul(b, inverse), v = g.mul(a, inverse);
      r.d[0] = u;
      r.d[1] = g.neg(v);
      if (second) {
        const NodeId uv2 = g.mul(g.constant(2.0), g.mul(u, v));
        r.dd[0][0] = g.neg(uv2);
        r.dd[1][1] = uv2;
        r.dd[0][1] = g.mul(g.sub(v, u), g.add(v, u));
      }
      break;
    }
    default:
      STARK_CHECK(false);
  }
}

}  // namespace

Partials local_partials(Graph& graph, NodeId id, bool with_second) {
  const Node n = graph.node(id);
  Raw r;
  const int count = operand_count(n.op);
  if (n.op == Op::Fma) {
    r.d[0] = n.operands[1];
    r.d[1] = n.operands[0];
    r.d[2] = graph.constant(1.0);
    if (with_second) r.dd[0][1] = graph.constant(1.0);
  } else if (count == 1) {
    unary_partials(graph, id, n, with_second, r);
  } else {
    binary_partials(graph, id, n, with_second, r);
  }
  // Equal operands are one variable: their partials add up.
  Partials p;
  int place[3];
  for (int i = 0; i < count; ++i) {
    int k = 0;
    while (k < p.count && p.operand[k] != n.operands[i]) ++k;
    if (k == p.count) p.operand[p.count++] = n.operands[i];
    place[i] = k;
    p.first[k] = add_term(graph, p.first[k], r.d[i]);
  }
  for (int i = 0; i < count; ++i) {
    for (int j = i; j < count; ++j) {
      if (r.dd[i][j] < 0) continue;
      const int a = place[i] < place[j] ? place[i] : place[j], b = place[i] < place[j] ? place[j] : place[i];
      NodeId& entry = p.second[a][b];
      entry = add_term(graph, entry, r.dd[i][j]);
      if (i != j && a == b) entry = add_term(graph, entry, r.dd[i][j]);
    }
  }
  return p;
}

}  // namespace stark::symbolic
