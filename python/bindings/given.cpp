#include "given.h"

namespace stark::bindings {

ParameterValues parameter_values_of(nb::handle given, const std::string& owner) {
  ParameterValues result;
  if (given.is_none()) return result;
  for (auto [name, entry] : nb::cast<nb::dict>(given)) {
    const nb::tuple pair = nb::cast<nb::tuple>(entry);
    result[text(name)] = {numbers_of<double>(pair[0], owner + ": " + text(name), "real numbers"),
                          nb::cast<bool>(pair[1])};
  }
  return result;
}

double number_of(nb::handle object, const std::string& name) {
  const FieldValue value = to_field_value(object);
  if (const auto* real = std::get_if<double>(&value)) return *real;
  if (const auto* integer = std::get_if<int64_t>(&value)) return static_cast<double>(*integer);
  throw InvalidArgument(name + " = " + text(nb::repr(object)) + ": must be a number or None");
}

nb::list describe(const std::vector<ParameterDeclaration>& declarations) {
  return list_of(declarations, [](const ParameterDeclaration& d) {
    return dict_of("name", d.name, "unit", d.unit, "rule",
                   d.is_direction ? "must not be zero" : d.rule.text(), "doc", d.doc, "width", d.width,
                   "is_data", d.is_data);
  });
}

}  // namespace stark::bindings
