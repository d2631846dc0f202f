// See field_values.h.
#include <stark/mechanics/field_values.h>

#include <algorithm>

#include <stark/base/error.h>

namespace stark {

namespace {

bool is_clock(const UniformField& field) { return field.name == "time_step" || field.name == "time"; }

template <typename Field>
ParameterDeclaration declaration_of(const Field& field, bool is_data) {
  return {field.name, field.unit, field.doc, field.width, field.rule, field.is_direction, is_data};
}

/// "c10", or "c10[3]" for the value of element 3.
std::string label(const ParameterDeclaration& declaration, const FieldValues& values, size_t element) {
  return declaration.name + (values.per_element ? "[" + std::to_string(element) + "]" : "");
}

void check_direction(std::string_view owner, const ParameterDeclaration& declaration,
                     const FieldValues& values, size_t element) {
  const double* v = values.values.data() + 3 * element;
  if (v[0] != 0.0 || v[1] != 0.0 || v[2] != 0.0) return;
  throw InvalidArgument(std::string(owner) + ": " + label(declaration, values, element) +
                        " = (0, 0, 0): must not be zero; give any vector in that direction");
}

}  // namespace

std::vector<ParameterDeclaration> parameters_of(const PotentialDefinition& definition) {
  PotentialBuilder builder(definition.point_count);
  (void)definition.energy(builder);
  std::vector<ParameterDeclaration> declarations;
  for (const UniformField& field : builder.uniform_fields())
    if (!is_clock(field)) declarations.push_back(declaration_of(field, false));
  for (const ElementField& field : builder.element_fields())
    if (field.source == ElementField::Source::Data) declarations.push_back(declaration_of(field, true));
  return declarations;
}

std::vector<ParameterDeclaration> parameters_of(const Formula& formula) {
  return parameters_of(define_potential("formula", "", formula));
}

void check_values(std::string_view owner, const ParameterDeclaration& declaration, const FieldValues& values,
                  int64_t element_count) {
  if (declaration.is_data && !values.per_element)
    throw InvalidArgument(std::string(owner) + ": " + declaration.name +
                          " is given once for all: must be given " + "for each of the " +
                          std::to_string(element_count) + " elements");
  const size_t width = static_cast<size_t>(declaration.width);
  const size_t count = values.per_element ? static_cast<size_t>(element_count) : 1;
  if (values.values.size() != width * count)
    throw InvalidArgument(std::string(owner) + ": " + declaration.name + " has " +
                          std::to_string(values.values.size()) + " numbers: must be " +
                          (values.per_element ? std::to_string(width) + " for each of the " +
                                                    std::to_string(element_count) + " elements"
                                              : std::to_string(width)) +
                          "; give one value for all elements or one for each");
  for (size_t k = 0; k < values.values.size(); ++k)
    if (!declaration.rule.holds(values.values[k]))
      throw InvalidArgument(std::string(owner) + ": " + label(declaration, values, k / width) + " = " +
                            quantity_text(values.values[k], declaration.unit) + ": " +
                            declaration.rule.text() + "; it is the " + declaration.doc);
  if (declaration.is_direction)
    for (size_t e = 0; e < count; ++e) check_direction(owner, declaration, values, e);
}

std::set<std::string> per_element_names(const ParameterValues& values) {
  std::set<std::string> names;
  for (const auto& [name, value] : values)
    if (value.per_element) names.insert(name);
  return names;
}

void set_values(PotentialBatch& batch, const ParameterValues& values) {
  for (const UniformField& field : batch.potential().uniform_fields())
    if (const auto found = values.find(field.name); found != values.end())
      batch.set_uniform(field.name, found->second.values);
  const auto& fields = batch.potential().element_fields();
  for (size_t k = 0; k < fields.size(); ++k) {
    const auto found = values.find(fields[k].name);
    if (fields[k].source != ElementField::Source::Data || found == values.end()) continue;
    const std::span<const double> numbers = found->second.values;
    const size_t width = static_cast<size_t>(fields[k].width);
    for (int64_t e = 0; e < batch.size(); ++e)
      batch.set(static_cast<int>(k), e,
                numbers.subspan(found->second.per_element ? static_cast<size_t>(e) * width : 0, width));
  }
}

}  // namespace stark
