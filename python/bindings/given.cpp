#include "given.h"

#include <algorithm>

namespace stark::bindings {

namespace {

/// What Python shows of an object, on one line of a message: arrays have many.
std::string short_text(nb::handle object) {
  constexpr size_t kLongest = 60;
  std::string shown = text(nb::repr(object));
  size_t end = std::min(shown.find('\n'), kLongest);
  if (end >= shown.size()) return shown;
  while (end > 0 && (shown[end] & 0xC0) == 0x80) --end;  // not within a character of UTF-8
  return shown.substr(0, end) + " ...";
}

}  // namespace

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
  throw InvalidArgument(name + " = " + short_text(object) + ": must be a number or None");
}

nb::list describe(const std::vector<ParameterDeclaration>& declarations) {
  return list_of(declarations, [](const ParameterDeclaration& d) {
    return dict_of("name", d.name, "unit", d.unit, "rule",
                   d.is_direction ? "must not be zero" : d.rule.text(), "doc", d.doc, "width", d.width,
                   "is_data", d.is_data);
  });
}

}  // namespace stark::bindings
