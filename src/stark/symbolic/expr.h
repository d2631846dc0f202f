// Expression graph of scalars: the language in which energies are written. Nodes are hash-consed (equal
// expressions are one node, so common sub-expressions are found by construction) and simplified while they
// are built. Phase: model building; nothing here runs inside the time step.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <unordered_map>
#include <vector>

namespace stark::symbolic {

using NodeId = int32_t;

/// Unknown: differentiated, changes at every evaluation. Element: one value per element. Uniform: the same
/// for all.
enum class InputKind : uint8_t { Unknown, Element, Uniform };

enum class Op : uint8_t {
  Constant,
  Unknown,
  Element,
  Uniform,  // leaves
  Neg,
  Abs,
  Sqrt,
  Exp,
  Log,
  Sin,
  Cos,
  Tan,
  Asin,
  Acos,
  Atan,
  Tanh,  // one operand
  Add,
  Sub,
  Mul,
  Div,
  Min,
  Max,
  Pow,
  Atan2,  // two operands
  Fma,
  Select,  // three: a b + c; a ? b : c
  Less,
  LessEqual,
  And,
  Or,
  Not,   // conditions
  Held,  // one operand: its value, which derivatives take for a constant
  Total  // one operand: its sum over all elements of an energy (mechanics/total_energy.h)
};

constexpr int operand_count(Op op) {
  if (op <= Op::Uniform) return 0;
  if (op <= Op::Tanh || op == Op::Not || op >= Op::Held) return 1;
  return op == Op::Fma || op == Op::Select ? 3 : 2;
}
constexpr bool is_condition(Op op) { return op >= Op::Less && op <= Op::Not; }

struct Node {
  Op op = Op::Constant;
  std::array<NodeId, 3> operands{-1, -1, -1};  // of an input: operands[0] is its number within its kind
  double value = 0.0;                          // of a constant
};

class Scalar;

/// Throws InvalidArgument: a sum over elements means nothing where there are none.
[[noreturn]] void refuse_total();

/// Arena of nodes. Operands always precede their users, so the order of ids is a topological order. Not safe
/// for concurrent building. Scalars refer to their graph: it must outlive them (compiled kernels do not need
/// it).
class Graph {
 public:
  Graph();
  Graph(const Graph&) = delete;
  Graph& operator=(const Graph&) = delete;
  Graph(Graph&&) = default;

  /// A new input, numbered 0, 1, 2... within its kind in order of creation.
  Scalar input(InputKind kind);
  /// Marks a value as a cut for staged differentiation (points of a body, deformation gradient). A hint: it
  /// can make derivatives cheaper and never changes their meaning.
  void mark_stage(const Scalar& value);
  /// Names a node for printing; the last name holds. Names change no result and are not copied with
  /// expressions.
  void set_name(const Scalar& value, std::string name);
  /// Empty if the node has no name.
  std::string name(NodeId id) const;

  int input_count(InputKind kind) const { return input_count_[static_cast<int>(kind)]; }
  int size() const { return static_cast<int>(nodes_.size()); }
  const Node& node(NodeId id) const { return nodes_[id]; }
  const std::vector<NodeId>& stages() const { return stages_; }

  // Building on node ids: the layer under Scalar, used by differentiation. Results are simplified.
  NodeId constant(double value);
  NodeId input_node(InputKind kind, int index);  // finds or makes the input with this number
  NodeId unary(Op op, NodeId a);
  NodeId binary(Op op, NodeId a, NodeId b);
  NodeId select(NodeId condition, NodeId a, NodeId b);
  NodeId fma(NodeId a, NodeId b, NodeId c);
  NodeId add(NodeId a, NodeId b);
  NodeId sub(NodeId a, NodeId b);
  NodeId mul(NodeId a, NodeId b);
  NodeId div(NodeId a, NodeId b);
  NodeId neg(NodeId a);
  /// Whether the node is this constant (0.0 matches both zeros).
  bool is_constant(NodeId a, double value) const {
    return nodes_[a].op == Op::Constant && nodes_[a].value == value;
  }
  bool is_constant(NodeId a) const { return nodes_[a].op == Op::Constant; }

 private:
  NodeId intern(Op op, NodeId a, NodeId b = -1, NodeId c = -1, double value = 0.0);
  void grow();

  std::vector<Node> nodes_;
  std::vector<NodeId> table_;  // open addressing, power of two, -1 is empty
  std::vector<NodeId> stages_;
  std::unordered_map<NodeId, std::string> names_;
  std::array<int, 3> input_count_{0, 0, 0};
};

/// Value handle: a node of a graph, or a literal number (graph() == nullptr), so that `2.0 * s` and `Scalar s
/// = 0.0` work. Cheap to copy. Comparisons give conditions, which are used by select, &&, || and ! only.
class Scalar {
 public:
  Scalar(double value = 0.0) : value_(value) {}  // NOLINT: implicit on purpose
  Scalar(Graph* graph, NodeId id) : graph_(graph), id_(id) {}

  Graph* graph() const { return graph_; }
  NodeId id() const { return id_; }
  bool is_literal() const { return graph_ == nullptr; }
  /// Value of a literal, or of a node that was folded to a constant. Precondition: is_constant().
  double value() const;
  bool is_constant() const;
  bool is_condition() const;

  Scalar& operator+=(const Scalar& b);
  Scalar& operator-=(const Scalar& b);
  Scalar& operator*=(const Scalar& b);
  Scalar& operator/=(const Scalar& b);

  static Scalar literal_condition(bool value) {
    Scalar s(value ? 1.0 : 0.0);
    s.condition_ = true;
    return s;
  }

 private:
  Graph* graph_ = nullptr;
  NodeId id_ = -1;
  bool condition_ = false;  // of a literal only
  double value_ = 0.0;
};

Scalar operator+(const Scalar& a, const Scalar& b);
Scalar operator-(const Scalar& a, const Scalar& b);
Scalar operator*(const Scalar& a, const Scalar& b);
Scalar operator/(const Scalar& a, const Scalar& b);
Scalar operator-(const Scalar& a);
Scalar operator<(const Scalar& a, const Scalar& b);
Scalar operator<=(const Scalar& a, const Scalar& b);
Scalar operator>(const Scalar& a, const Scalar& b);
Scalar operator>=(const Scalar& a, const Scalar& b);
Scalar operator&&(const Scalar& a, const Scalar& b);  // no short circuit: both sides are values
Scalar operator||(const Scalar& a, const Scalar& b);
Scalar operator!(const Scalar& a);

/// condition ? a : b. The branch that is not taken never contributes to value or derivatives, not even as
/// NaN.
Scalar select(const Scalar& condition, const Scalar& a, const Scalar& b);
Scalar min(const Scalar& a, const Scalar& b);  // a < b ? a : b
Scalar max(const Scalar& a, const Scalar& b);  // a > b ? a : b
Scalar abs(const Scalar& a);
Scalar sqrt(const Scalar& a);
Scalar square(const Scalar& a);
Scalar pow(const Scalar& a, int exponent);
/// Real power of a base >= 0; integral literal exponents up to 64 in size become products and take any base.
Scalar pow(const Scalar& a, const Scalar& exponent);
Scalar pow(const Scalar& a, double exponent);
Scalar exp(const Scalar& a);
Scalar log(const Scalar& a);
Scalar sin(const Scalar& a);  // |a| <= 1e9 rad
Scalar cos(const Scalar& a);
Scalar tan(const Scalar& a);
Scalar asin(const Scalar& a);
Scalar acos(const Scalar& a);
Scalar atan(const Scalar& a);
Scalar atan2(const Scalar& y, const Scalar& x);
Scalar sinh(const Scalar& a);
Scalar cosh(const Scalar& a);
Scalar tanh(const Scalar& a);
/// The value of a, which derivatives take for a constant. For iterations whose result the energy is
/// stationary in: their steps need no derivatives (models/yielding.h).
Scalar held(const Scalar& a);
/// The sum of a over all elements of an energy. Kernels know nothing of it: a Potential takes it apart.
Scalar total(const Scalar& a);
/// a b + c with one rounding.
Scalar fma(const Scalar& a, const Scalar& b, const Scalar& c);

/// Whether both are the same node, or literals of the same value.
bool is_same(const Scalar& a, const Scalar& b);

}  // namespace stark::symbolic
