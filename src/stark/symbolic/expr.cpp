// Hash-consing arena and the simplifications that are applied while an expression is built. The rules keep
// values up to rounding where everything is finite (0 x -> 0 as in a computer algebra system) and put a
// canonical order on commutative operands, so that equal expressions become one node. Phase: model building.
#include <stark/symbolic/expr.h>

#include <stark/base/error.h>

#include <bit>
#include <cmath>
#include <utility>

namespace stark::symbolic {

namespace {

uint64_t mix(uint64_t h) {
  h ^= h >> 32;
  h *= 0x9e3779b97f4a7c15ull;
  return h ^ (h >> 29);
}

uint64_t hash(Op op, NodeId a, NodeId b, NodeId c, double value) {
  uint64_t h =
      mix((static_cast<uint64_t>(static_cast<uint32_t>(a)) << 32 | static_cast<uint32_t>(b)) + 0x51ed27f1ull);
  h = mix(h ^ (static_cast<uint64_t>(static_cast<uint32_t>(c)) << 8 | static_cast<uint64_t>(op)));
  return mix(h + std::bit_cast<uint64_t>(value));
}

Op input_op(InputKind kind) {
  return kind == InputKind::Unknown ? Op::Unknown : (kind == InputKind::Element ? Op::Element : Op::Uniform);
}

bool is_power_of_two(double x) {
  int exponent;
  return std::isnormal(x) && std::isnormal(1.0 / x) && std::fabs(std::frexp(x, &exponent)) == 0.5;
}

// Folding of functions uses the standard library: constants carry no requirement of equal bits between back
// ends, because a constant is folded before any back end sees it.
bool fold_unary(Op op, double x, double& result) {
  switch (op) {
    case Op::Neg:
      result = -x;
      return true;
    case Op::Held:
      result = x;
      return true;
    case Op::Abs:
      result = std::fabs(x);
      return true;
    case Op::Sqrt:
      result = std::sqrt(x);
      return true;
    case Op::Exp:
      result = std::exp(x);
      return true;
    case Op::Log:
      result = std::log(x);
      return true;
    case Op::Sin:
      result = std::sin(x);
      return true;
    case Op::Cos:
      result = std::cos(x);
      return true;
    case Op::Tan:
      result = std::tan(x);
      return true;
    case Op::Asin:
      result = std::asin(x);
      return true;
    case Op::Acos:
      result = std::acos(x);
      return true;
    case Op::Atan:
      result = std::atan(x);
      return true;
    case Op::Tanh:
      result = std::tanh(x);
      return true;
    default:
      return false;
  }
}

bool fold_binary(Op op, double x, double y, double& result) {
  switch (op) {
    case Op::Min:
      result = std::isnan(x) || x < y ? x : y;
      return true;
    case Op::Max:
      result = std::isnan(x) || x > y ? x : y;
      return true;
    case Op::Pow:
      result = std::pow(x, y);
      return true;
    case Op::Atan2:
      result = std::atan2(x, y);
      return true;
    default:
      return false;
  }
}

}  // namespace

Graph::Graph() : table_(1024, -1) { nodes_.reserve(512); }

NodeId Graph::intern(Op op, NodeId a, NodeId b, NodeId c, double value) {
  const uint64_t mask = table_.size() - 1;
  uint64_t slot = hash(op, a, b, c, value) & mask;
  for (; table_[slot] >= 0; slot = (slot + 1) & mask) {
    const Node& n = nodes_[table_[slot]];
    if (n.op == op && n.operands[0] == a && n.operands[1] == b && n.operands[2] == c &&
        std::bit_cast<uint64_t>(n.value) == std::bit_cast<uint64_t>(value)) {
      return table_[slot];
    }
  }
  const NodeId id = size();
  nodes_.push_back({op, {a, b, c}, value});
  table_[slot] = id;
  if (2 * nodes_.size() > table_.size()) grow();
  return id;
}

void Graph::grow() {
  std::vector<NodeId> table(2 * table_.size(), -1);
  const uint64_t mask = table.size() - 1;
  for (NodeId id = 0; id < size(); ++id) {
    const Node& n = nodes_[id];
    uint64_t slot = hash(n.op, n.operands[0], n.operands[1], n.operands[2], n.value) & mask;
    while (table[slot] >= 0) slot = (slot + 1) & mask;
    table[slot] = id;
  }
  table_ = std::move(table);
}

Scalar Graph::input(InputKind kind) {
  return Scalar(this, input_node(kind, input_count_[static_cast<int>(kind)]));
}

NodeId Graph::input_node(InputKind kind, int index) {
  int& count = input_count_[static_cast<int>(kind)];
  if (index >= count) count = index + 1;
  return intern(input_op(kind), index);
}

void Graph::mark_stage(const Scalar& value) {
  if (value.is_literal()) return;
  if (value.graph() != this)
    throw InvalidArgument("Graph::mark_stage: the value belongs to another graph; mark it in its own graph.");
  if (operand_count(nodes_[value.id()].op) > 0) stages_.push_back(value.id());
}

void Graph::set_name(const Scalar& value, std::string name) {
  if (value.graph() != this)
    throw InvalidArgument("Graph::set_name: the value is a number or belongs to another graph.");
  names_[value.id()] = std::move(name);
}

std::string Graph::name(NodeId id) const {
  const auto found = names_.find(id);
  return found == names_.end() ? std::string() : found->second;
}

NodeId Graph::constant(double value) { return intern(Op::Constant, -1, -1, -1, value); }

NodeId Graph::neg(NodeId a) {
  const Node n = nodes_[a];
  if (n.op == Op::Constant) return constant(-n.value);
  if (n.op == Op::Neg) return n.operands[0];
  if (n.op == Op::Sub) return sub(n.operands[1], n.operands[0]);
  if (n.op == Op::Mul && nodes_[n.operands[0]].op == Op::Constant) {
    return mul(constant(-nodes_[n.operands[0]].value), n.operands[1]);
  }
  return intern(Op::Neg, a);
}

NodeId Graph::add(NodeId a, NodeId b) {
  if (is_constant(a) && is_constant(b)) return constant(nodes_[a].value + nodes_[b].value);
  if (is_constant(a, 0.0)) return b;
  if (is_constant(b, 0.0)) return a;
  if (a == b) return mul(constant(2.0), a);
  if (nodes_[b].op == Op::Neg) return sub(a, nodes_[b].operands[0]);
  if (nodes_[a].op == Op::Neg) return sub(b, nodes_[a].operands[0]);
  // c x + d x = (c + d) x
  if (nodes_[a].op == Op::Mul && nodes_[b].op == Op::Mul && nodes_[a].operands[1] == nodes_[b].operands[1] &&
      is_constant(nodes_[a].operands[0]) && is_constant(nodes_[b].operands[0])) {
    const double sum = nodes_[nodes_[a].operands[0]].value + nodes_[nodes_[b].operands[0]].value;
    if (std::isfinite(sum)) return mul(constant(sum), nodes_[a].operands[1]);
  }
  if (a > b) std::swap(a, b);
  return intern(Op::Add, a, b);
}

NodeId Graph::sub(NodeId a, NodeId b) {
  if (is_constant(a) && is_constant(b)) return constant(nodes_[a].value - nodes_[b].value);
  if (is_constant(b, 0.0)) return a;
  if (is_constant(a, 0.0)) return neg(b);
  if (a == b) return constant(0.0);
  if (nodes_[b].op == Op::Neg) return add(a, nodes_[b].operands[0]);
  if (nodes_[a].op == Op::Neg) return neg(add(nodes_[a].operands[0], b));
  return intern(Op::Sub, a, b);
}

NodeId Graph::mul(NodeId a, NodeId b) {
  if (is_constant(b)) std::swap(a, b);
  if (is_constant(a)) {
    const double x = nodes_[a].value;
    const Node n = nodes_[b];
    if (n.op == Op::Constant) return constant(x * n.value);
    if (x == 0.0) return constant(0.0);
    if (x == 1.0) return b;
    if (x == -1.0) return neg(b);
    if (n.op == Op::Neg) return mul(constant(-x), n.operands[0]);
    if (n.op == Op::Mul && is_constant(n.operands[0])) {
      // Not where the factors alone leave the range of normal numbers.
      const double product = x * nodes_[n.operands[0]].value;
      if (std::isnormal(product)) return mul(constant(product), n.operands[1]);
    }
    return intern(Op::Mul, a, b);
  }
  // Signs and constant factors move outwards, where they meet others.
  if (nodes_[a].op == Op::Neg) return neg(mul(nodes_[a].operands[0], b));
  if (nodes_[b].op == Op::Neg) return neg(mul(a, nodes_[b].operands[0]));
  if (nodes_[a].op == Op::Mul && is_constant(nodes_[a].operands[0])) {
    const Node n = nodes_[a];
    return mul(n.operands[0], mul(n.operands[1], b));
  }
  if (nodes_[b].op == Op::Mul && is_constant(nodes_[b].operands[0])) {
    const Node n = nodes_[b];
    return mul(n.operands[0], mul(a, n.operands[1]));
  }
  if (a > b) std::swap(a, b);
  return intern(Op::Mul, a, b);
}

NodeId Graph::div(NodeId a, NodeId b) {
  if (is_constant(b)) {
    const double y = nodes_[b].value;
    if (is_constant(a)) return constant(nodes_[a].value / y);
    if (is_power_of_two(y)) return mul(constant(1.0 / y), a);  // exact
  }
  if (is_constant(a, 0.0)) return a;
  if (a == b) return constant(1.0);
  if (nodes_[a].op == Op::Neg) return neg(div(nodes_[a].operands[0], b));
  if (nodes_[b].op == Op::Neg) return neg(div(a, nodes_[b].operands[0]));
  return intern(Op::Div, a, b);
}

NodeId Graph::unary(Op op, NodeId a) {
  if (op == Op::Neg) return neg(a);
  if (op == Op::Not) {
    const Node n = nodes_[a];
    return n.op == Op::Not ? n.operands[0] : intern(Op::Not, a);
  }
  double folded;
  if (is_constant(a) && fold_unary(op, nodes_[a].value, folded)) return constant(folded);
  const Node n = nodes_[a];
  if (n.op == Op::Neg) {
    const NodeId x = n.operands[0];
    switch (op) {
      case Op::Abs:
      case Op::Cos:
        return unary(op, x);
      case Op::Sin:
      case Op::Tan:
      case Op::Asin:
      case Op::Atan:
      case Op::Tanh:
        return neg(unary(op, x));
      default:
        break;
    }
  }
  if (op == Op::Abs && (n.op == Op::Abs || n.op == Op::Sqrt || n.op == Op::Exp)) return a;
  return intern(op, a);
}

NodeId Graph::binary(Op op, NodeId a, NodeId b) {
  switch (op) {
    case Op::Add:
      return add(a, b);
    case Op::Sub:
      return sub(a, b);
    case Op::Mul:
      return mul(a, b);
    case Op::Div:
      return div(a, b);
    default:
      break;
  }
  double folded;
  if (is_constant(a) && is_constant(b) && fold_binary(op, nodes_[a].value, nodes_[b].value, folded)) {
    return constant(folded);
  }
  if (a == b && (op == Op::Min || op == Op::Max || op == Op::And || op == Op::Or)) return a;
  if ((op == Op::And || op == Op::Or) && a > b) std::swap(a, b);
  return intern(op, a, b);
}

NodeId Graph::fma(NodeId a, NodeId b, NodeId c) {
  if (is_constant(a) && is_constant(b) && is_constant(c)) {
    return constant(std::fma(nodes_[a].value, nodes_[b].value, nodes_[c].value));
  }
  if (is_constant(a, 0.0) || is_constant(b, 0.0)) return c;
  if (is_constant(c, 0.0)) return mul(a, b);
  if (is_constant(a, 1.0)) return add(b, c);
  if (is_constant(b, 1.0)) return add(a, c);
  if (a > b) std::swap(a, b);
  return intern(Op::Fma, a, b, c);
}

NodeId Graph::select(NodeId condition, NodeId a, NodeId b) {
  if (a == b) return a;
  if (nodes_[condition].op == Op::Not) return select(nodes_[condition].operands[0], b, a);
  // A nested select on the same condition takes the same branch.
  if (nodes_[a].op == Op::Select && nodes_[a].operands[0] == condition)
    return select(condition, nodes_[a].operands[1], b);
  if (nodes_[b].op == Op::Select && nodes_[b].operands[0] == condition)
    return select(condition, a, nodes_[b].operands[2]);
  return intern(Op::Select, condition, a, b);
}

}  // namespace stark::symbolic
