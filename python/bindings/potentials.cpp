// Bindings of the registered potentials, one element at a time: for tests against other programs and for
// inspection.
#include <stark/mechanics/element_evaluation.h>
#include <stark/sim/registry.h>

#include "given.h"

namespace stark::bindings {

namespace {

nb::list potential_list() {
  return list_of(registered_potentials(), [](const PotentialDefinition& d) {
    return dict_of("name", d.name, "points", d.point_count, "doc", d.doc);
  });
}

std::vector<double> numbers(const nb::dict& values, const ElementInput& field) {
  if (!values.contains(field.name.c_str()))
    throw InvalidArgument("value '" + field.name + "' [" + field.unit + "] is missing: " + field.doc);
  const nb::object value = values[field.name.c_str()];
  if (field.width == 1) return {nb::cast<double>(nb::float_(value))};
  return array_of<double>(value, field.name, std::to_string(field.width) + " numbers");
}

/// Energy [J], gradient [N] (n, 3) and Hessian [N/m] (3n, 3n) of one element.
nb::tuple evaluate_potential(const std::string& name, nb::object x, nb::object rest, nb::object previous,
                             const nb::dict& values) {
  const Potential potential(find_potential(name), symbolic::Backend::Automatic);
  const auto points = [](nb::handle given, const char* as) {
    return array_of<Vec3>(given, as, "an (n, 3) array of positions");
  };
  const std::vector<Vec3> now = points(x, "x");
  ElementEvaluation element =
      evaluate_element(potential, now, rest.is_none() ? now : points(rest, "X"),
                       previous.is_none() ? now : points(previous, "x_prev"),
                       [&](const ElementInput& input) { return numbers(values, input); });
  return nb::make_tuple(element.energy, ArrayOf{element.gradient}, ArrayOf{element.hessian});
}

}  // namespace

void bind_potentials(nb::module_& m) {
  m.def("potentials", potential_list, "All registered potentials: name, points, doc.");
  m.def("evaluate_potential", evaluate_potential, "name"_a, "x"_a, "X"_a = nb::none(),
        "x_prev"_a = nb::none(), nb::kw_only(), "values"_a,
        "Energy [J], gradient (n, 3) [N] and Hessian (9 n^2,) [N/m], row by row, of one element of a "
        "registered potential. `values` holds its data and parameters by name; rest and previous positions "
        "default to x.");
}

}  // namespace stark::bindings
