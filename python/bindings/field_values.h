// Values of parameters from Python: {name: (numbers, per_element)}.
#pragma once

#include <string>

#include <stark/mechanics/field_values.h>

#include "arrays.h"

namespace stark::bindings {

/// Throws InvalidArgument naming owner and parameter when the numbers are no row of real numbers.
inline ParameterValues parameter_values_of(nb::handle given, const std::string& owner) {
  ParameterValues result;
  if (given.is_none()) return result;
  for (auto [name, entry] : nb::cast<nb::dict>(given)) {
    const nb::tuple pair = nb::cast<nb::tuple>(entry);
    const auto numbers = array<Column<double>>(pair[0], owner + ": " + text(name), "real numbers");
    const auto view = values(numbers);
    result[text(name)] = {{view.begin(), view.end()}, nb::cast<bool>(pair[1])};
  }
  return result;
}

/// Rows {name, unit, rule, doc, width} of what a potential asks for.
inline nb::list describe(const std::vector<ParameterDeclaration>& declarations) {
  nb::list rows;
  for (const ParameterDeclaration& d : declarations) {
    nb::dict row;
    row["name"] = d.name;
    row["unit"] = d.unit;
    row["rule"] = d.is_direction ? "must not be zero" : d.rule.text();
    row["doc"] = d.doc;
    row["width"] = d.width;
    row["is_data"] = d.is_data;
    rows.append(row);
  }
  return rows;
}

}  // namespace stark::bindings
