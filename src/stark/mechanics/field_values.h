// Values of one parameter of a potential: one for all elements, or one for each.
#pragma once

#include <map>
#include <string>
#include <vector>

namespace stark {

struct FieldValues {
  std::vector<double> values;  ///< width numbers, or [element][width]
  bool per_element = false;
};

/// By the name of the parameter.
using FieldValueMap = std::map<std::string, FieldValues>;

}  // namespace stark
