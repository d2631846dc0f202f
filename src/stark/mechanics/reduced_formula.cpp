#include <stark/mechanics/reduced_formula.h>

#include <stark/symbolic/diff.h>

namespace stark {

using symbolic::Scalar;

ReducedFormula::ReducedFormula(const std::shared_ptr<PotentialBuilder>& traced, std::vector<Scalar> outputs)
    : formula_(traced, std::move(outputs)),
      now_(traced->point_count(), 0),
      before_(traced->point_count(), 0),
      initial_(traced->point_count(), 0) {
  std::vector<symbolic::NodeId> roots;
  for (const Scalar& output : formula_.outputs())
    if (!output.is_literal()) roots.push_back(output.id());
  const symbolic::Graph& graph = *traced->graph();
  const std::vector<char> needed = symbolic::reachable(graph, roots);
  for (size_t id = 0; id < needed.size(); ++id) {
    if (!needed[id]) continue;
    const symbolic::Node& node = graph.node(static_cast<symbolic::NodeId>(id));
    if (node.op == symbolic::Op::Unknown) now_[node.operands[0] / 3] = 1;
    if (node.op != symbolic::Op::Element) continue;
    for (const ElementField& field : traced->element_fields()) {
      if (node.operands[0] < field.offset || node.operands[0] >= field.offset + field.width) continue;
      if (field.source == ElementField::Source::Previous) before_[field.point] = 1;
      if (field.source == ElementField::Source::Initial) initial_[field.point] = 1;
    }
  }
  for (int p = 0; p < traced->point_count(); ++p)
    if (now_[p] || before_[p] || initial_[p]) points_.push_back(p);
}

std::vector<Scalar> ReducedFormula::repeat(PotentialBuilder& target, int first,
                                           const std::string& prefix) const {
  PointExpressions points;
  points.x.resize(now_.size());
  points.x_prev.resize(now_.size());
  points.x_initial.resize(now_.size());
  for (size_t k = 0; k < points_.size(); ++k) {
    const int p = points_[k], q = first + static_cast<int>(k);
    if (now_[p]) points.x[p] = target.x(q);
    if (before_[p]) points.x_prev[p] = target.x_prev(q);
    if (initial_[p]) points.x_initial[p] = target.x_initial(q);
  }
  return formula_.repeat(target, points, prefix);
}

}  // namespace stark
