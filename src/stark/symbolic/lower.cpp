// Choice of instructions. A product with one user that is a sum becomes a fused multiply-add.
// Phase: kernel building.
#include <stark/symbolic/lower.h>

#include <stark/base/error.h>
#include <stark/symbolic/elementary.h>

#include <cmath>
#include <utility>

namespace stark::symbolic {

std::vector<NodeId> import_expressions(const Graph& source, std::span<const NodeId> outputs, Graph& target) {
  std::vector<NodeId> image(source.size(), -1);
  for (const InputKind kind : {InputKind::Unknown, InputKind::Element, InputKind::Uniform}) {
    for (int i = 0; i < source.input_count(kind); ++i) target.input_node(kind, i);
  }
  const auto kind_of = [](Op op) {
    return op == Op::Unknown   ? InputKind::Unknown
           : op == Op::Element ? InputKind::Element
                               : InputKind::Uniform;
  };
  for (NodeId id = 0; id < source.size(); ++id) {
    const Node& n = source.node(id);
    if (n.op != Op::Constant && operand_count(n.op) == 0)
      image[id] = target.input_node(kind_of(n.op), n.operands[0]);
  }
  return import_expressions(source, outputs, target, std::move(image));
}

std::vector<NodeId> import_expressions(const Graph& source, std::span<const NodeId> outputs, Graph& target,
                                       std::vector<NodeId> image) {
  std::vector<char> active;  // by target id: depends on an Unknown
  const auto is_active = [&](NodeId id) {
    for (NodeId k = static_cast<NodeId>(active.size()); k < target.size(); ++k) {
      const Node& n = target.node(k);
      bool a = n.op == Op::Unknown;
      for (int j = 0; j < operand_count(n.op); ++j) a |= active[n.operands[j]] != 0;
      active.push_back(a);
    }
    return active[id] != 0;
  };
  std::vector<NodeId> stack;
  for (const NodeId root : outputs) {
    stack.push_back(root);
    while (!stack.empty()) {
      const NodeId id = stack.back();
      if (image[id] >= 0) {
        stack.pop_back();
        continue;
      }
      const Node& n = source.node(id);
      const int count = operand_count(n.op);
      bool ready = true;
      for (int k = count - 1; k >= 0; --k) {
        if (image[n.operands[k]] < 0) {
          stack.push_back(n.operands[k]);
          ready = false;
        }
      }
      if (!ready) continue;
      stack.pop_back();
      NodeId x[3] = {-1, -1, -1};
      for (int k = 0; k < count; ++k) x[k] = image[n.operands[k]];
      switch (n.op) {
        case Op::Constant:
          image[id] = target.constant(n.value);
          break;
        case Op::Unknown:
        case Op::Element:
        case Op::Uniform:
          throw InvalidArgument("import_expressions: the expression uses an input that is not given.");
        case Op::Select:
          image[id] = target.select(x[0], x[1], x[2]);
          break;
        case Op::Fma:
          image[id] = target.fma(x[0], x[1], x[2]);
          break;
        case Op::Div:
          image[id] = !target.is_constant(x[1]) && (is_active(x[0]) || is_active(x[1]))
                          ? target.mul(x[0], target.div(target.constant(1.0), x[1]))
                          : target.div(x[0], x[1]);
          break;
        default:
          image[id] = count == 1 ? target.unary(n.op, x[0]) : target.binary(n.op, x[0], x[1]);
      }
    }
  }
  std::vector<NodeId> result;
  for (const NodeId id : outputs) result.push_back(image[id]);
  return result;
}

namespace {

class Lowering {
 public:
  explicit Lowering(const Graph& graph) : graph_(graph), low_(graph.size(), -1), uses_(graph.size(), 0) {}

  void lower_group(std::span<const NodeId> outputs) {
    std::vector<char> needed(graph_.size(), 0);
    std::fill(uses_.begin(), uses_.end(), 0);
    for (const NodeId id : outputs) {
      needed[id] = 1;
      ++uses_[id];
    }
    for (NodeId id = graph_.size() - 1; id >= 0; --id) {
      if (!needed[id] || low_[id] >= 0) continue;
      const Node& n = graph_.node(id);
      for (int k = 0; k < operand_count(n.op); ++k) {
        needed[n.operands[k]] = 1;
        ++uses_[n.operands[k]];
      }
    }
    // A product that its only user absorbs gets no instruction of its own.
    std::vector<signed char> absorbed(graph_.size(), -1);  // by sum: which operand
    std::vector<char> skip(graph_.size(), 0);
    for (NodeId id = 0; id < graph_.size(); ++id) {
      if (!needed[id] || low_[id] >= 0) continue;
      const Node& n = graph_.node(id);
      if (n.op != Op::Add && n.op != Op::Sub) continue;
      for (const int k : {1, 0}) {
        const NodeId x = n.operands[k];
        if (graph_.node(x).op == Op::Mul && uses_[x] == 1 && low_[x] < 0) {
          absorbed[id] = static_cast<signed char>(k);
          skip[x] = 1;
          break;
        }
      }
    }
    for (NodeId id = 0; id < graph_.size(); ++id) {
      if (!needed[id] || low_[id] >= 0 || skip[id]) continue;
      low_[id] = absorbed[id] >= 0 ? lower_fused(graph_.node(id), absorbed[id]) : lower_node(graph_.node(id));
    }
    for (const NodeId id : outputs) outputs_.push_back(low_[id]);
  }

  Program finish() const {
    Program program = builder_.finish(outputs_);
    program.unknown_count = graph_.input_count(InputKind::Unknown);
    program.element_count = graph_.input_count(InputKind::Element);
    program.uniform_count = graph_.input_count(InputKind::Uniform);
    return program;
  }

 private:
  LowId lower_fused(const Node& n, int place) {
    const Node& product = graph_.node(n.operands[place]);
    const LowId a = low_[product.operands[0]], b = low_[product.operands[1]], c = low_[n.operands[1 - place]];
    if (n.op == Op::Add) return builder_.mul_add(a, b, c);
    return place == 0 ? builder_.mul_sub(a, b, c) : builder_.neg_mul_add(a, b, c);
  }

  /// NaN of either operand propagates. The instruction passes on that of the second one alone, so a constant
  /// comes first.
  LowId lower_extreme(Code code, const Node& n, LowId a, LowId b) {
    const auto is_number = [&](NodeId id) {
      return graph_.node(id).op == Op::Constant && !std::isnan(graph_.node(id).value);
    };
    if (is_number(n.operands[0])) return builder_.emit(code, a, b);
    if (is_number(n.operands[1])) return builder_.emit(code, b, a);
    return builder_.select(builder_.emit(Code::LessEqual, a, a), builder_.emit(code, a, b), a);
  }

  LowId lower_node(const Node& n) {
    ProgramBuilder& p = builder_;
    LowId x[3] = {-1, -1, -1};
    for (int k = 0; k < operand_count(n.op); ++k) x[k] = low_[n.operands[k]];
    switch (n.op) {
      case Op::Constant:
        return p.constant(n.value);
      case Op::Unknown:
        return p.input(Space::Unknown, n.operands[0]);
      case Op::Element:
        return p.input(Space::Element, n.operands[0]);
      case Op::Uniform:
        return p.input(Space::Uniform, n.operands[0]);
      case Op::Neg:
        return p.negate(x[0]);
      case Op::Held:
        return x[0];
      case Op::Abs:
        return p.emit(Code::And, x[0], p.bits(0x7fffffffffffffffull));
      case Op::Sqrt:
        return p.emit(Code::Sqrt, x[0]);
      case Op::Exp:
        return expand_exp(p, x[0]);
      case Op::Log:
        return expand_log(p, x[0]);
      case Op::Sin:
        return expand_sin(p, x[0]);
      case Op::Cos:
        return expand_cos(p, x[0]);
      case Op::Tan:
        return expand_tan(p, x[0]);
      case Op::Asin:
        return expand_asin(p, x[0]);
      case Op::Acos:
        return expand_acos(p, x[0]);
      case Op::Atan:
        return expand_atan(p, x[0]);
      case Op::Tanh:
        return expand_tanh(p, x[0]);
      case Op::Add:
        return p.add(x[0], x[1]);
      case Op::Sub:
        return p.sub(x[0], x[1]);
      case Op::Mul:
        return p.mul(x[0], x[1]);
      case Op::Div:
        return p.div(x[0], x[1]);
      case Op::Min:
        return lower_extreme(Code::Min, n, x[0], x[1]);
      case Op::Max:
        return lower_extreme(Code::Max, n, x[0], x[1]);
      case Op::Pow:
        return expand_pow(p, x[0], x[1]);
      case Op::Atan2:
        return expand_atan2(p, x[0], x[1]);
      case Op::Fma:
        return p.mul_add(x[0], x[1], x[2]);
      case Op::Select:
        return p.select(x[0], x[1], x[2]);
      case Op::Less:
        return p.emit(Code::Less, x[0], x[1]);
      case Op::LessEqual:
        return p.emit(Code::LessEqual, x[0], x[1]);
      case Op::And:
        return p.emit(Code::And, x[0], x[1]);
      case Op::Or:
        return p.emit(Code::Or, x[0], x[1]);
      case Op::Not:
        return p.emit(Code::Xor, x[0], p.bits(~0ull));
    }
    throw InternalError("Lowering: unknown operation.");
  }

  const Graph& graph_;
  ProgramBuilder builder_;
  std::vector<LowId> low_;  // node -> value
  std::vector<int> uses_;
  std::vector<LowId> outputs_;
};

}  // namespace

Program lower(const Graph& graph, std::span<const std::vector<NodeId>> groups) {
  Lowering lowering(graph);
  for (const auto& group : groups) lowering.lower_group(group);
  return lowering.finish();
}

}  // namespace stark::symbolic
