// Second-order forward jets and random expressions for the tests of the symbolic engine.
#include "symbolic/support.h"

namespace stark::symbolic::test {

namespace {

Jet unary(Op op, const Jet& a) {
  const Real x = a.v;
  switch (op) {
    case Op::Neg:
      return chain(a, -x, -1, 0);
    case Op::Held:
      return chain(a, x, 0, 0);
    case Op::Abs:
      return chain(a, std::fabs(x), x < 0 ? -1 : 1, 0);
    case Op::Sqrt: {
      const Real s = std::sqrt(x);
      return chain(a, s, 1 / (2 * s), -1 / (4 * s * x));
    }
    case Op::Exp: {
      const Real e = std::exp(x);
      return chain(a, e, e, e);
    }
    case Op::Log:
      return chain(a, std::log(x), 1 / x, -1 / (x * x));
    case Op::Sin:
      return chain(a, std::sin(x), std::cos(x), -std::sin(x));
    case Op::Cos:
      return chain(a, std::cos(x), -std::sin(x), -std::cos(x));
    case Op::Tan: {
      const Real c = std::cos(x);
      return chain(a, std::tan(x), 1 / (c * c), 2 * std::tan(x) / (c * c));
    }
    case Op::Asin: {
      const Real w = 1 - x * x;
      return chain(a, std::asin(x), 1 / std::sqrt(w), x / (w * std::sqrt(w)));
    }
    case Op::Acos: {
      const Real w = 1 - x * x;
      return chain(a, std::acos(x), -1 / std::sqrt(w), -x / (w * std::sqrt(w)));
    }
    case Op::Atan: {
      const Real w = 1 + x * x;
      return chain(a, std::atan(x), 1 / w, -2 * x / (w * w));
    }
    case Op::Tanh: {
      const Real c = std::cosh(x), t = std::tanh(x);
      return chain(a, t, 1 / (c * c), -2 * t / (c * c));
    }
    default:
      throw std::logic_error("unary");
  }
}

Jet binary(Op op, const Jet& a, const Jet& b) {
  const Real x = a.v, y = b.v;
  switch (op) {
    case Op::Add:
      return chain(a, b, x + y, 1, 1, 0, 0, 0);
    case Op::Sub:
      return chain(a, b, x - y, 1, -1, 0, 0, 0);
    case Op::Mul:
      return chain(a, b, x * y, y, x, 0, 1, 0);
    case Op::Div:
      return chain(a, b, x / y, 1 / y, -x / (y * y), 0, -1 / (y * y), 2 * x / (y * y * y));
    case Op::Min:
      return x < y ? a : b;
    case Op::Max:
      return x > y ? a : b;
    case Op::Atan2: {
      const Real w = x * x + y * y;
      return chain(a, b, std::atan2(x, y), y / w, -x / w, -2 * x * y / (w * w), (x * x - y * y) / (w * w),
                   2 * x * y / (w * w));
    }
    case Op::Pow: {
      const Real p = std::pow(x, y), l = std::log(x);
      return chain(a, b, p, y * p / x, p * l, y * (y - 1) * p / (x * x), p / x * (1 + y * l), p * l * l);
    }
    default:
      throw std::logic_error("binary");
  }
}

}  // namespace

Jet evaluate_jet(const Scalar& expression, const InputValues& values) {
  const size_t n = values.unknowns.size();
  if (expression.is_literal()) return Jet::constant(expression.value(), n);
  const Graph& graph = *expression.graph();
  std::vector<Jet> jets(expression.id() + 1);
  for (NodeId id = 0; id <= expression.id(); ++id) {
    const Node& node = graph.node(id);
    const auto x = [&](int k) -> const Jet& { return jets[node.operands[k]]; };
    switch (node.op) {
      case Op::Constant:
        jets[id] = Jet::constant(node.value, n);
        break;
      case Op::Unknown:
        jets[id] = Jet::constant(values.unknowns[node.operands[0]], n);
        jets[id].g[node.operands[0]] = 1;
        break;
      case Op::Element:
        jets[id] = Jet::constant(values.elements[node.operands[0]], n);
        break;
      case Op::Uniform:
        jets[id] = Jet::constant(values.uniforms[node.operands[0]], n);
        break;
      case Op::Fma:
        jets[id] = binary(Op::Add, binary(Op::Mul, x(0), x(1)), x(2));
        break;
      case Op::Select:
        jets[id] = x(0).v != 0 ? x(1) : x(2);
        break;
      case Op::Less:
        jets[id] = Jet::constant(x(0).v < x(1).v, n);
        break;
      case Op::LessEqual:
        jets[id] = Jet::constant(x(0).v <= x(1).v, n);
        break;
      case Op::And:
        jets[id] = Jet::constant(x(0).v != 0 && x(1).v != 0, n);
        break;
      case Op::Or:
        jets[id] = Jet::constant(x(0).v != 0 || x(1).v != 0, n);
        break;
      case Op::Not:
        jets[id] = Jet::constant(x(0).v == 0, n);
        break;
      default:
        jets[id] = operand_count(node.op) == 1 ? unary(node.op, x(0)) : binary(node.op, x(0), x(1));
    }
  }
  return jets[expression.id()];
}

Scalar random_expression(Graph& graph, Random& random, int unknowns, int elements, int uniforms, int size) {
  std::vector<Scalar> pool;
  for (int i = 0; i < unknowns; ++i) pool.push_back(graph.input(InputKind::Unknown));
  for (int i = 0; i < elements; ++i) pool.push_back(graph.input(InputKind::Element));
  for (int i = 0; i < uniforms; ++i) pool.push_back(graph.input(InputKind::Uniform));
  const auto pick = [&] { return pool[random() % pool.size()]; };
  const auto bounded = [&] { return tanh(pick()); };
  for (int k = 0; k < size; ++k) {
    const Scalar a = pick(), b = pick(), c = pick();
    Scalar r;
    switch (random() % 24) {
      case 0:
        r = a + b;
        break;
      case 1:
        r = a - b;
        break;
      case 2:
      case 3:
      case 4:
        r = 0.7 * (a * b);
        break;
      case 5:
        r = a / (2.0 + b * b);
        break;
      case 6:
        r = sqrt(1.0 + a * a);
        break;
      case 7:
        r = exp(bounded());
        break;
      case 8:
        r = log(1.5 + a * a);
        break;
      case 9:
        r = sin(a) * cos(b);
        break;
      case 10:
        r = tan(0.8 * bounded());
        break;
      case 11:
        r = asin(0.9 * bounded());
        break;
      case 12:
        r = acos(0.9 * bounded());
        break;
      case 13:
        r = atan(a);
        break;
      case 14:
        r = atan2(a, 1.1 + bounded());
        break;
      case 15:
        r = pow(1.2 + bounded(), 0.8 * bounded());
        break;
      case 16:
        r = pow(1.0 + a * a, 1.0 / 3.0);
        break;
      case 17:
        r = select(a < b, a * c, b - c);
        break;
      case 18:
        r = select(a <= 0.3 && !(b > c), square(c), a);
        break;
      case 19:
        r = min(a, b * c);
        break;
      case 20:
        r = max(a + c, b);
        break;
      case 21:
        r = abs(a);
        break;
      case 22:
        r = fma(a, b, c);
        break;
      default:
        r = select(a > 0.1 || b < c, sqrt(abs(a) + 0.01), pow(b, 3));
        break;
    }
    if (random() % 4 == 0) r = tanh(r);
    if (random() % 16 == 0) graph.mark_stage(r);
    pool.push_back(r);
  }
  Scalar sum = 0.0;
  for (int k = 0; k < 6; ++k) sum += pool[pool.size() - 1 - static_cast<size_t>(k)] * pick();
  return sum;
}

}  // namespace stark::symbolic::test
