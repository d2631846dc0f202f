// See past_measures.h.
#include <stark/mechanics/past_measures.h>

#include <limits>
#include <map>

#include <stark/symbolic/diff.h>

namespace stark {

using symbolic::Graph;
using symbolic::Node;
using symbolic::NodeId;
using symbolic::Op;
using symbolic::Scalar;

namespace {

/// Correction over the difference of a measure that may jump on both sides, up to which it is one. An angle
/// of points that turn rigidly stays below a quarter, a jump in between makes a half.
constexpr double kLargestCorrection = 0.375;

/// What a node depends on.
struct Dependence {
  bool now = false;        ///< positions at the end of the step
  bool past = false;       ///< those at its start
  bool is_linear = true;   ///< in these
  bool reference = false;  ///< PotentialBuilder::reference has been there
  bool may_jump = false;   ///< has an operation whose value does
};

using Images = std::map<NodeId, Scalar>;

class PastMeasures {
 public:
  PastMeasures(PotentialBuilder& builder, const Scalar& energy)
      : builder_(builder), graph_(*builder.graph()), root_(energy.id()) {
    const NodeId roots[] = {root_};
    needed_ = symbolic::reachable(graph_, roots);
    for (NodeId id = 0; id < static_cast<NodeId>(needed_.size()); ++id)
      depends_.push_back(needed_[id] ? dependence_of(id) : Dependence{});
  }

  /// Nodes in the order of their ids.
  std::vector<NodeId> find() const {
    std::vector<char> is_found(needed_.size(), 0);
    for (NodeId id = 0; id < static_cast<NodeId>(needed_.size()); ++id) {
      if (!needed_[id] || !depends_[id].now) continue;
      const Node& node = graph_.node(id);
      for (int k = 0; k < symbolic::operand_count(node.op); ++k)
        is_found[node.operands[k]] |= is_measure(node.operands[k]);
    }
    std::vector<NodeId> found;
    for (NodeId id = 0; id < static_cast<NodeId>(is_found.size()); ++id)
      if (is_found[id]) found.push_back(id);
    return found;
  }

  /// Node `id` with other positions at the start.
  Scalar at(NodeId id, PotentialBuilder::Position position) {
    Images images;
    const NodeId roots[] = {id};
    const std::vector<char> needed = symbolic::reachable(graph_, roots);
    for (NodeId k = 0; k <= id; ++k) {
      if (!needed[k]) continue;
      const ElementField* field = previous_field(k);
      images[k] = field ? (builder_.*position)(field->point)[graph_.node(k).operands[0] - field->offset]
                        : copy(k, images);
    }
    return images.at(id);
  }

  bool may_jump(NodeId id) const { return depends_[id].may_jump; }

  /// The energy with other nodes in place of some.
  Scalar replaced(Images images) {
    for (NodeId id = 0; id <= root_; ++id)
      if (needed_[id] && !images.contains(id)) images[id] = copy(id, images);
    return images.at(root_);
  }

 private:
  bool is_measure(NodeId id) const {
    const Dependence& d = depends_[id];
    return d.past && !d.now && !d.is_linear && !d.reference && !symbolic::is_condition(graph_.node(id).op);
  }

  /// Field of x_prev that the node is a number of, or nullptr.
  const ElementField* previous_field(NodeId id) const { return field_of(id, ElementField::Source::Previous); }
  const ElementField* field_of(NodeId id, ElementField::Source source) const {
    const Node& node = graph_.node(id);
    if (node.op != Op::Element) return nullptr;
    for (const ElementField& field : builder_.element_fields())
      if (field.source == source && node.operands[0] >= field.offset &&
          node.operands[0] < field.offset + field.width)
        return &field;
    return nullptr;
  }

  Dependence dependence_of(NodeId id) const {
    const Node& node = graph_.node(id);
    if (node.op == Op::Unknown) return {.now = true};
    if (previous_field(id)) return {.past = true};
    if (field_of(id, ElementField::Source::Beyond)) return {.past = true, .reference = true};
    Dependence all{.may_jump = jumps(node.op)};
    int past_operands = 0;
    for (int k = 0; k < symbolic::operand_count(node.op); ++k) {
      const Dependence& d = depends_[node.operands[k]];
      all.now |= d.now;
      all.past |= d.past;
      all.reference |= d.reference;
      all.is_linear &= d.is_linear;
      all.may_jump |= d.may_jump;
      past_operands += d.past;
    }
    all.is_linear &= !all.past || keeps_linear(node, past_operands);
    return all;
  }

  static bool jumps(Op op) { return op == Op::Atan2 || op == Op::Atan || op == Op::Tan || op == Op::Select; }

  bool keeps_linear(const Node& node, int past_operands) const {
    const auto is_past = [&](int k) { return depends_[node.operands[k]].past; };
    switch (node.op) {
      case Op::Add:
      case Op::Sub:
      case Op::Neg:
        return true;
      case Op::Mul:
        return past_operands == 1;
      case Op::Div:
        return !is_past(1);
      case Op::Fma:
        return !(is_past(0) && is_past(1));
      case Op::Select:
        return !is_past(0);
      default:
        return false;
    }
  }

  Scalar copy(NodeId id, const Images& images) {
    const Node node = graph_.node(id);
    NodeId x[3] = {-1, -1, -1};
    bool is_same = true;
    for (int k = 0; k < symbolic::operand_count(node.op); ++k) {
      const Scalar& image = images.at(node.operands[k]);
      x[k] = image.is_literal() ? graph_.constant(image.value()) : image.id();
      is_same &= x[k] == node.operands[k];
    }
    if (is_same) return {&graph_, id};
    if (node.op == Op::Select) return {&graph_, graph_.select(x[0], x[1], x[2])};
    if (node.op == Op::Fma) return {&graph_, graph_.fma(x[0], x[1], x[2])};
    return {&graph_, symbolic::operand_count(node.op) == 1 ? graph_.unary(node.op, x[0])
                                                           : graph_.binary(node.op, x[0], x[1])};
  }

  PotentialBuilder& builder_;
  Graph& graph_;
  NodeId root_;
  std::vector<char> needed_;
  std::vector<Dependence> depends_;
};

}  // namespace

Scalar with_references(PotentialBuilder& builder, const Scalar& energy) {
  if (energy.is_literal()) return energy;
  PastMeasures measures(builder, energy);
  Images images;
  for (const NodeId id : measures.find()) {
    const Scalar here(builder.graph().get(), id);
    const Scalar beyond = measures.at(id, &PotentialBuilder::x_beyond);
    const Scalar behind = measures.at(id, &PotentialBuilder::x_behind);
    const Scalar correction = here - (beyond + behind) * 0.5;
    // Numbers of a vector that turns reach their extremes one after the other: bounds by what they change by
    // would correct some and not others, and make the axes of the world matter.
    const Scalar bound = measures.may_jump(id) ? kLargestCorrection * abs(beyond - behind)
                                               : Scalar(std::numeric_limits<double>::max());
    // False, so no correction, where a side is not finite.
    images[id] = here + select(abs(correction) <= bound, correction, 0.0);
  }
  return images.empty() ? energy : measures.replaced(std::move(images));
}

}  // namespace stark
