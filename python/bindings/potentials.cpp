// Bindings of the registered potentials, one element at a time: for tests against other programs and for
// inspection.
#include <nanobind/nanobind.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>

#include <stark/base/settings.h>
#include <stark/mechanics/element_evaluation.h>
#include <stark/sim/registry.h>

#include "casters.h"
#include "domains.h"

namespace {

namespace nb = nanobind;
using namespace nb::literals;
using namespace stark;
using namespace stark::bindings;

PotentialDefinition find_potential(const std::string& name) {
  std::vector<std::string> names;
  for (PotentialDefinition& definition : registered_potentials()) {
    if (definition.name == name) return definition;
    names.push_back(definition.name);
  }
  throw InvalidArgument("potential '" + name + "' is not registered" + nearest_name_hint(name, names));
}

nb::list potential_list() {
  return list_of(registered_potentials(), [](const PotentialDefinition& d) {
    return dict_of("name", d.name, "points", d.point_count, "doc", d.doc);
  });
}

std::vector<double> numbers(const nb::dict& values, const ElementInput& field) {
  if (!values.contains(field.name.c_str()))
    throw InvalidArgument("value '" + field.name + "' [" + field.unit + "] is missing: " + field.doc);
  const nb::object value = values[field.name.c_str()];
  std::vector<double> result;
  if (field.width == 1) {
    result.push_back(nb::cast<double>(nb::float_(value)));
  } else {
    result = numbers_of<double>(value, field.name, std::to_string(field.width) + " numbers");
  }
  if (static_cast<int>(result.size()) != field.width)
    throw InvalidArgument("value '" + field.name + "': got " + std::to_string(result.size()) +
                          " numbers: must be " + std::to_string(field.width));
  return result;
}

/// Energy [J], gradient [N] (n, 3) and Hessian [N/m] (3n, 3n) of one element.
nb::tuple evaluate_potential(const std::string& name, nb::object x, nb::object rest, nb::object previous,
                             const nb::dict& values) {
  const Potential potential(find_potential(name), symbolic::Backend::Automatic);
  const int count = potential.point_count();
  const std::vector<Vec3> now = points_of(x, "x", count);
  ElementEvaluation element =
      evaluate_element(potential, now, rest.is_none() ? now : points_of(rest, "X", count),
                       previous.is_none() ? now : points_of(previous, "x_prev", count),
                       [&](const ElementInput& input) { return numbers(values, input); });
  return nb::make_tuple(element.energy, to_numpy(std::move(element.gradient)),
                        to_numpy(std::move(element.hessian)));
}

}  // namespace

void bind_potentials(nb::module_& m) {
  m.def("potentials", potential_list, "All registered potentials: name, points, doc.");
  m.def(
      "evaluate_potential", evaluate_potential, "name"_a, "x"_a, "X"_a = nb::none(), "x_prev"_a = nb::none(),
      nb::kw_only(), "values"_a,
      "Energy [J], gradient (n, 3) [N] and Hessian (9 n^2,) [N/m], row by row, of one element of a "
      "registered "
      "potential. `values` holds its data and parameters by name; rest and previous positions default to x.");
}
