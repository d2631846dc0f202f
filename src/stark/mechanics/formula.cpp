#include <stark/mechanics/formula.h>

#include <algorithm>

#include <stark/base/error.h>
#include <stark/mechanics/canonical_kernel.h>
#include <stark/symbolic/substitute.h>

namespace stark {

using symbolic::InputKind;
using symbolic::Scalar;

namespace {

bool is_clock(const UniformField& field) { return field.name == "time_step" || field.name == "time"; }

}  // namespace

Formula::Formula(std::shared_ptr<PotentialBuilder> builder, std::vector<Scalar> outputs)
    : builder_(std::move(builder)), outputs_(std::move(outputs)) {
  for (const Scalar& output : outputs_)
    STARK_CHECK(output.is_literal() || output.graph() == builder_->graph().get());
}

bool Formula::uses(ElementField::Source source) const {
  return std::ranges::any_of(element_fields(),
                             [&](const ElementField& field) { return field.source == source; });
}

std::set<std::string> Formula::shared_parameters() const {
  std::set<std::string> names;
  if (outputs_.empty() || symbolic::totals_in(outputs_.front()).empty()) return names;
  symbolic::Graph unused;
  const Scalar any = unused.input(InputKind::Uniform);
  symbolic::substitute(
      outputs_.front(),
      [&](InputKind kind, int index) {
        if (kind == InputKind::Uniform) names.insert(field_at(builder_->uniform_fields(), index).name);
        return any;
      },
      [&](symbolic::NodeId) { return any; });
  return names;
}

std::vector<Scalar> Formula::repeat(PotentialBuilder& target, const PointExpressions& points,
                                    const std::string& prefix) const {
  const auto point = [&](const std::vector<symbolic::Vec3>& given, auto position, int index) {
    const int p = index / 3;
    return (given.empty() ? (target.*position)(p) : given.at(p))[index % 3];
  };
  const auto element = [&](int index) {
    const ElementField& field = field_at(builder_->element_fields(), index);
    const int c = index - field.offset;
    switch (field.source) {
      case ElementField::Source::Rest:
        return point(points.X, &PotentialBuilder::X, 3 * field.point + c);
      case ElementField::Source::Previous:
        return point(points.x_prev, &PotentialBuilder::x_prev, 3 * field.point + c);
      case ElementField::Source::Initial:
        return point(points.x_initial, &PotentialBuilder::x_initial, 3 * field.point + c);
      case ElementField::Source::Beyond:
        STARK_CHECK(points.x_prev.empty());  // not of a formula whose past is given
        return target.x_beyond(field.point)[c];
      case ElementField::Source::Internal:
        return target.internal(prefix + field.name, field.initial, field.unit, field.doc)[c];
      case ElementField::Source::Data:
        break;
    }
    return target.data_array(prefix + field.name, field.width, field.unit, field.doc)[c];
  };
  const auto uniform = [&](int index) {
    const UniformField& field = field_at(builder_->uniform_fields(), index);
    if (is_clock(field)) return field.name == "time" ? target.time() : target.time_step();
    UniformField repeated = field;
    repeated.name = prefix + field.name;
    return target.parameter_like(repeated)[index - field.offset];
  };
  return symbolic::substitute(outputs_, [&](InputKind kind, int index) -> Scalar {
    if (kind == InputKind::Unknown) return point(points.x, &PotentialBuilder::x, index);
    return kind == InputKind::Element ? element(index) : uniform(index);
  });
}

Scalar Formula::repeat_energy(PotentialBuilder& target, const PointExpressions& points) const {
  const std::vector<Scalar> outputs = repeat(target, points);
  auto next = outputs.begin() + 1;
  for (const ElementField& field : element_fields()) {
    if (field.source != ElementField::Source::Internal || next == outputs.end()) continue;
    STARK_CHECK(outputs.end() - next >= field.width);
    target.internal(field.name, field.initial, field.unit, field.doc);  // psi may not use it
    target.update(field.name, {next, next + field.width});
    next += field.width;
  }
  return outputs.front();
}

PotentialDefinition define_potential(std::string name, std::string doc, Formula formula) {
  const int points = formula.point_count();
  return define_potential(
      std::move(name), points, std::move(doc),
      [formula = std::move(formula)](PotentialBuilder& builder) { return formula.repeat_energy(builder); });
}

Formula formula_of(const PotentialDefinition& definition) {
  const auto builder = std::make_shared<PotentialBuilder>(definition.point_count);
  const Scalar energy = definition.energy(*builder);
  return Formula(builder, {energy});
}

}  // namespace stark
