#include <stark/mechanics/potential.h>

#include <algorithm>

#include <stark/base/error.h>
#include <stark/mechanics/canonical_kernel.h>
#include <stark/mechanics/total_energy.h>
#include <stark/symbolic/diff.h>
#include <stark/symbolic/substitute.h>

namespace stark {

using symbolic::InputKind;
using symbolic::Scalar;

PotentialBuilder::PotentialBuilder(int point_count, std::set<std::string> per_element)
    : graph_(std::make_shared<symbolic::Graph>()), per_element_(std::move(per_element)) {
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

bool is_same_role(const ElementField& a, const ElementField& b) { return a.source == b.source; }
bool is_same_role(const UniformField&, const UniformField&) { return true; }

/// Finds the field by name or appends it with fresh inputs of the given kind.
template <typename Field>
const std::vector<Scalar>& find_or_add(symbolic::Graph& graph, InputKind kind, Field field,
                                       std::vector<Field>& fields, std::vector<std::vector<Scalar>>& values) {
  for (size_t k = 0; k < fields.size(); ++k)
    if (fields[k].name == field.name) {
      if (fields[k].width != field.width || fields[k].unit != field.unit || !is_same_role(fields[k], field))
        throw InvalidArgument("potential input '" + field.name +
                              "' is declared twice with different meanings, widths or units (" +
                              fields[k].unit + " and " + field.unit +
                              "); give the two inputs different names");
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

symbolic::Vec3 PotentialBuilder::position(const char* name, const char* doc, ElementField::Source source,
                                          int point) {
  return vector_of(element_field({.name = name + std::to_string(point),
                                  .unit = "m",
                                  .doc = doc,
                                  .source = source,
                                  .point = point,
                                  .width = 3}));
}

symbolic::Vec3 PotentialBuilder::X(int point) {
  return position("X", "rest position", ElementField::Source::Rest, point);
}

symbolic::Vec3 PotentialBuilder::x_prev(int point) {
  return position("x_prev", "position at the start of the step", ElementField::Source::Previous, point);
}

symbolic::Vec3 PotentialBuilder::x_initial(int point) {
  return position("x_initial", "position in the world at time 0", ElementField::Source::Initial, point);
}

symbolic::Vec3 PotentialBuilder::x_beyond(int point) {
  return position("x_beyond", "position at the start of the step and a way on", ElementField::Source::Beyond,
                  point);
}

symbolic::Vec3 PotentialBuilder::x_behind(int point) { return 2.0 * x_prev(point) - x_beyond(point); }

symbolic::Vec3 PotentialBuilder::velocity(int point) { return (x(point) - x_prev(point)) / time_step(); }

Scalar PotentialBuilder::time_step() {
  return uniform_field({.name = "time_step", .unit = "s", .doc = "size of the time step"})[0];
}

Scalar PotentialBuilder::time() {
  return uniform_field({.name = "time", .unit = "s", .doc = "time at the end of the step"})[0];
}

std::vector<Scalar> PotentialBuilder::data_array(const std::string& name, int width, const std::string& unit,
                                                 const std::string& doc) {
  return element_field({.name = name, .unit = unit, .doc = doc, .width = width});
}

Scalar PotentialBuilder::data(const std::string& name, const std::string& unit, const std::string& doc) {
  return data_array(name, 1, unit, doc)[0];
}

symbolic::Vec3 PotentialBuilder::data3(const std::string& name, const std::string& unit,
                                       const std::string& doc) {
  return vector_of(data_array(name, 3, unit, doc));
}

std::vector<Scalar> PotentialBuilder::parameter_like(const UniformField& field) {
  if (field.name == "time" || field.name == "time_step")
    throw InvalidArgument("potential parameter '" + field.name +
                          "' has the name of a built-in input; choose another one, or use " + field.name +
                          "()");
  if (!per_element_.contains(field.name)) return uniform_field(field);
  return element_field({.name = field.name,
                        .unit = field.unit,
                        .doc = field.doc,
                        .width = field.width,
                        .rule = field.rule,
                        .is_direction = field.is_direction});
}

std::vector<Scalar> PotentialBuilder::parameter_array(const std::string& name, int width,
                                                      const std::string& unit, const std::string& doc,
                                                      const FieldRule& rule) {
  return parameter_like({.name = name, .unit = unit, .doc = doc, .width = width, .rule = rule});
}

Scalar PotentialBuilder::parameter(const std::string& name, const std::string& unit, const std::string& doc,
                                   const FieldRule& rule) {
  return parameter_array(name, 1, unit, doc, rule)[0];
}

symbolic::Vec3 PotentialBuilder::direction(const std::string& name, const std::string& doc) {
  return normalized(
      vector_of(parameter_like({.name = name, .unit = "1", .doc = doc, .width = 3, .is_direction = true})));
}

symbolic::Vec3 PotentialBuilder::parameter3(const std::string& name, const std::string& unit,
                                            const std::string& doc) {
  return vector_of(parameter_array(name, 3, unit, doc));
}

std::vector<Scalar> PotentialBuilder::internal(const std::string& name, const std::vector<double>& initial,
                                               const std::string& unit, const std::string& doc) {
  STARK_CHECK(!initial.empty());
  return element_field({.name = name,
                        .unit = unit,
                        .doc = doc,
                        .source = ElementField::Source::Internal,
                        .width = static_cast<int>(initial.size()),
                        .initial = initial});
}

void PotentialBuilder::update(const std::string& name, const std::vector<Scalar>& values) {
  const auto field = std::ranges::find_if(element_fields_, [&](const ElementField& f) {
    return f.source == ElementField::Source::Internal && f.name == name;
  });
  if (field == element_fields_.end())
    throw InvalidArgument("update of '" + name + "': must be an internal variable; declare it first");
  if (static_cast<int>(values.size()) != field->width)
    throw InvalidArgument("update of '" + name + "': got " + std::to_string(values.size()) +
                          " numbers, must be " + std::to_string(field->width));
  if (!updates_.emplace(name, values).second)
    throw InvalidArgument(
        "update of '" + name +
        "' is given twice; give the internal variables of laws that are summed different names");
}

std::vector<Scalar> PotentialBuilder::updates() const {
  std::vector<Scalar> all;
  for (size_t k = 0; k < element_fields_.size(); ++k) {
    if (element_fields_[k].source != ElementField::Source::Internal) continue;
    const auto found = updates_.find(element_fields_[k].name);
    const std::vector<Scalar>& values = found == updates_.end() ? element_values_[k] : found->second;
    all.insert(all.end(), values.begin(), values.end());
  }
  return all;
}

namespace {

/// Updates of the internal variables, with bits that do not depend on the order of writing either.
symbolic::Function compile_update(const PotentialBuilder& builder, symbolic::Backend backend) {
  symbolic::Graph graph;
  std::vector<Scalar> outputs;
  for (const Scalar& value : builder.updates()) {
    symbolic::Graph own;
    const Scalar copy = symbolic::canonical_copy(own, value, labels_of(builder));
    if (copy.is_literal()) {
      outputs.emplace_back(&graph, graph.constant(copy.value()));
      continue;
    }
    const Scalar one[] = {copy};
    outputs.push_back(symbolic::substitute(one, [&](InputKind kind, int index) {
                        return Scalar(&graph, graph.input_node(kind, index));
                      }).at(0));
  }
  add_inputs(input_counts(builder), graph);
  return outputs.empty() ? symbolic::Function() : symbolic::compile_function(outputs, backend);
}

/// Whether the updates of the internal variables depend on the time step.
bool has_rates_of_internal(const PotentialBuilder& builder) {
  std::vector<symbolic::NodeId> roots;
  for (const Scalar& value : builder.updates())
    if (!value.is_literal()) roots.push_back(value.id());
  const symbolic::Graph& graph = *builder.graph();
  const std::vector<char> needed = symbolic::reachable(graph, roots);
  for (const UniformField& field : builder.uniform_fields())
    for (size_t id = 0; field.name == "time_step" && id < needed.size(); ++id) {
      const symbolic::Node& node = graph.node(static_cast<symbolic::NodeId>(id));
      if (needed[id] && node.op == symbolic::Op::Uniform && node.operands[0] == field.offset) return true;
    }
  return false;
}

std::shared_ptr<const TotalEnergy> totals_of(const PotentialBuilder& builder, const Scalar& energy,
                                             symbolic::Backend backend) {
  if (symbolic::totals_in(energy).empty()) return nullptr;
  return std::make_shared<TotalEnergy>(builder, energy, backend);
}

}  // namespace

Potential::Potential(const PotentialDefinition& definition, symbolic::Backend backend,
                     const std::set<std::string>& per_element)
    : Potential([&] {
        PotentialBuilder builder(definition.point_count, per_element);
        const Scalar energy = definition.energy(builder);
        Potential result(definition.name, builder, energy, backend, definition.translation_invariant);
        result.one_sided_ = definition.one_sided;
        return result;
      }()) {}

Potential::Potential(std::string name, const PotentialBuilder& builder, const Scalar& energy,
                     symbolic::Backend backend, bool translation_invariant)
    : name_(std::move(name)),
      point_count_(builder.point_count()),
      translation_invariant_(translation_invariant),
      element_width_(total_width(builder.element_fields())),
      uniform_width_(total_width(builder.uniform_fields())),
      element_fields_(builder.element_fields()),
      uniform_fields_(builder.uniform_fields()),
      totals_(totals_of(builder, energy, backend)),
      kernel_(totals_ ? totals_->plane()
                      : compile_canonical(energy, labels_of(builder), input_counts(builder), backend)),
      update_(compile_update(builder, backend)) {
  internal_width_ = update_ ? update_.output_count() : 0;
  flows_at_a_rate_ = has_rates_of_internal(builder);
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
    sum.one_sided = sum.one_sided && term.one_sided;
  }
  return sum;
}

}  // namespace stark
