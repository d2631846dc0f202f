#include <stark/mechanics/potential.h>

#include <algorithm>

#include <stark/base/error.h>

namespace stark {

using symbolic::InputKind;
using symbolic::Scalar;

PotentialBuilder::PotentialBuilder(int point_count) : graph_(std::make_shared<symbolic::Graph>()) {
  for (int i = 0; i < point_count; ++i) {
    symbolic::Vec3 p;
    for (int c = 0; c < 3; ++c) p[c] = graph_->input(InputKind::Unknown);
    x_.push_back(p);
  }
}

namespace {

symbolic::Vec3 vector_of(const std::vector<Scalar>& values) {
  symbolic::Vec3 v;
  for (int c = 0; c < 3; ++c) v[c] = values[c];
  return v;
}

template <typename Field>
int total_width(const std::vector<Field>& fields) {
  return fields.empty() ? 0 : fields.back().offset + fields.back().width;
}

/// Finds the field by name or appends it with fresh inputs of the given kind.
template <typename Field>
const std::vector<Scalar>& find_or_add(symbolic::Graph& graph, InputKind kind, Field field,
                                       std::vector<Field>& fields, std::vector<std::vector<Scalar>>& values) {
  for (size_t k = 0; k < fields.size(); ++k)
    if (fields[k].name == field.name) {
      if (fields[k].width != field.width || fields[k].unit != field.unit)
        throw InvalidArgument("potential input '" + field.name +
                              "' is declared twice with different widths or units (" + fields[k].unit +
                              " and " + field.unit + "); give the two inputs different names");
      return values[k];
    }
  field.offset = total_width(fields);
  fields.push_back(field);
  std::vector<Scalar> inputs;
  for (int c = 0; c < field.width; ++c) inputs.push_back(graph.input(kind));
  values.push_back(std::move(inputs));
  return values.back();
}

}  // namespace

const std::vector<Scalar>& PotentialBuilder::element_field(const ElementField& field) {
  return find_or_add(*graph_, InputKind::Element, field, element_fields_, element_values_);
}

const std::vector<Scalar>& PotentialBuilder::uniform_field(const UniformField& field) {
  return find_or_add(*graph_, InputKind::Uniform, field, uniform_fields_, uniform_values_);
}

symbolic::Vec3 PotentialBuilder::x(int point) { return x_.at(point); }

symbolic::Vec3 PotentialBuilder::X(int point) {
  return vector_of(element_field({.name = "X" + std::to_string(point),
                                  .unit = "m",
                                  .doc = "rest position",
                                  .source = ElementField::Source::Rest,
                                  .point = point,
                                  .width = 3}));
}

symbolic::Vec3 PotentialBuilder::x_prev(int point) {
  return vector_of(element_field({.name = "x_prev" + std::to_string(point),
                                  .unit = "m",
                                  .doc = "position at the start of the step",
                                  .source = ElementField::Source::Previous,
                                  .point = point,
                                  .width = 3}));
}

Scalar PotentialBuilder::time_step() {
  return uniform_field({.name = "time_step", .unit = "s", .doc = "size of the time step"})[0];
}

Scalar PotentialBuilder::data(const std::string& name, const std::string& unit, const std::string& doc) {
  return element_field({.name = name, .unit = unit, .doc = doc})[0];
}

symbolic::Vec3 PotentialBuilder::data3(const std::string& name, const std::string& unit,
                                       const std::string& doc) {
  return vector_of(element_field({.name = name, .unit = unit, .doc = doc, .width = 3}));
}

Scalar PotentialBuilder::parameter(const std::string& name, const std::string& unit, const std::string& doc) {
  return uniform_field({.name = name, .unit = unit, .doc = doc})[0];
}

symbolic::Vec3 PotentialBuilder::parameter3(const std::string& name, const std::string& unit,
                                            const std::string& doc) {
  return vector_of(uniform_field({.name = name, .unit = unit, .doc = doc, .width = 3}));
}

Potential::Potential(const PotentialDefinition& definition, symbolic::Backend backend)
    : name_(definition.name),
      point_count_(definition.point_count),
      translation_invariant_(definition.translation_invariant) {
  PotentialBuilder builder(definition.point_count);
  const Scalar energy = definition.energy(builder);
  kernel_ = symbolic::compile(energy, backend);
  element_fields_ = builder.element_fields();
  uniform_fields_ = builder.uniform_fields();
  element_width_ = total_width(element_fields_);
  uniform_width_ = total_width(uniform_fields_);
}

PotentialDefinition define_potential(std::string name, int point_count, std::string doc,
                                     std::function<Scalar(PotentialBuilder&)> energy) {
  PotentialDefinition definition;
  definition.name = std::move(name);
  definition.point_count = point_count;
  definition.doc = std::move(doc);
  definition.energy = std::move(energy);
  return definition;
}

PotentialDefinition compose(std::string name, const std::vector<PotentialDefinition>& terms) {
  STARK_CHECK(!terms.empty());
  PotentialDefinition sum = terms.front();
  sum.name = std::move(name);
  sum.energy = [terms](PotentialBuilder& builder) {
    Scalar total = 0.0;
    for (const PotentialDefinition& term : terms) total = total + term.energy(builder);
    return total;
  };
  for (const PotentialDefinition& term : terms) {
    STARK_CHECK(term.point_count == sum.point_count);
    sum.translation_invariant = sum.translation_invariant && term.translation_invariant;
    sum.rotation_invariant = sum.rotation_invariant && term.rotation_invariant;
    sum.zero_at_rest = sum.zero_at_rest && term.zero_at_rest;
  }
  return sum;
}

}  // namespace stark
