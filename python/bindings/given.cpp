#include "given.h"

namespace stark::bindings {

ParameterValues parameter_values_of(nb::handle given, const std::string& owner) {
  ParameterValues result;
  if (given.is_none()) return result;
  for (auto [name, entry] : nb::cast<nb::dict>(given)) {
    const nb::tuple pair = nb::cast<nb::tuple>(entry);
    result[text(name)] = {array_of<double>(pair[0], owner + ": " + text(name), "real numbers"),
                          nb::cast<bool>(pair[1])};
  }
  return result;
}

double number_of(nb::handle object, const std::string& name) {
  const FieldValue value = to_field_value(object);
  if (const auto* real = std::get_if<double>(&value)) return *real;
  if (const auto* integer = std::get_if<int64_t>(&value)) return static_cast<double>(*integer);
  throw InvalidArgument(name + " = " + shown(object) + ": must be a number or None");
}

Mat3 matrix_of(nb::handle object, const std::string& name, const std::string& expected) {
  Mat3 result;
  if (nb::hasattr(object, "__len__") && nb::len(object) == result.m.size())
    return {read<std::array<double, 9>>(object, name)};  // row by row
  const auto rows = array_of<Vec3>(object, name, expected);
  if (rows.size() != 3)
    throw InvalidArgument(name + ": got " + std::to_string(rows.size()) + " rows: must be " + expected);
  return transpose(Mat3::from_columns(rows[0], rows[1], rows[2]));
}

}  // namespace stark::bindings
