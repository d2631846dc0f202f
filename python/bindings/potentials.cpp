// Bindings of the registered potentials, one element at a time: for tests against other programs and for
// inspection.
#include <nanobind/nanobind.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>

#include <algorithm>

#include <stark/base/aligned.h>
#include <stark/base/settings.h>
#include <stark/sim/registry.h>

#include "arrays.h"

namespace {

namespace nb = nanobind;
using namespace nb::literals;
using namespace stark;
using namespace stark::bindings;
using symbolic::kLanes;

PotentialDefinition find_potential(const std::string& name) {
  std::vector<std::string> names;
  for (PotentialDefinition& definition : registered_potentials()) {
    if (definition.name == name) return definition;
    names.push_back(definition.name);
  }
  throw InvalidArgument("potential '" + name + "' is not registered" + nearest_name_hint(name, names));
}

nb::list potential_list() {
  nb::list rows;
  for (const PotentialDefinition& definition : registered_potentials()) {
    nb::dict row;
    row["name"] = definition.name;
    row["points"] = definition.point_count;
    row["doc"] = definition.doc;
    rows.append(row);
  }
  return rows;
}

std::vector<Vec3> points(nb::object object, const std::string& name, int count) {
  const auto array_of_points = array<Rows<double, 3>>(object, name, "an (n, 3) array of positions");
  const std::span<const Vec3> given = rows<Vec3>(array_of_points);
  if (static_cast<int>(given.size()) != count)
    throw InvalidArgument(name + ": got " + std::to_string(given.size()) + " points, need " +
                          std::to_string(count));
  return {given.begin(), given.end()};
}

template <typename Field>
std::vector<double> numbers(const nb::dict& values, const Field& field) {
  if (!values.contains(field.name.c_str()))
    throw InvalidArgument("value '" + field.name + "' [" + field.unit + "] is missing: " + field.doc);
  const nb::object value = values[field.name.c_str()];
  std::vector<double> result;
  if (field.width == 1) {
    result.push_back(nb::cast<double>(nb::float_(value)));
  } else {
    const auto column = array<Column<double>>(value, field.name, std::to_string(field.width) + " numbers");
    result.assign(column.data(), column.data() + column.shape(0));
  }
  if (static_cast<int>(result.size()) != field.width)
    throw InvalidArgument("value '" + field.name + "': got " + std::to_string(result.size()) +
                          " numbers, need " + std::to_string(field.width));
  return result;
}

/// Energy [J], gradient [N] (n, 3) and Hessian [N/m] (3n, 3n) of one element.
nb::tuple evaluate_potential(const std::string& name, nb::object x, nb::object rest, nb::object previous,
                             const nb::dict& values) {
  const Potential potential(find_potential(name), symbolic::Backend::Automatic);
  const int count = potential.point_count(), n = 3 * count;
  const std::vector<Vec3> now = points(x, "x", count);
  const std::vector<Vec3> X = rest.is_none() ? now : points(rest, "X", count);
  const std::vector<Vec3> before = previous.is_none() ? now : points(previous, "x_prev", count);
  AlignedVector<double> unknowns(n * kLanes), elements(potential.element_width() * kLanes + 1),
      uniforms(potential.uniform_width() + 1);
  const auto spread = [](AlignedVector<double>& lanes, int row, double value) {
    std::fill_n(lanes.begin() + row * kLanes, kLanes, value);
  };
  for (int i = 0; i < n; ++i) spread(unknowns, i, now[i / 3][i % 3]);
  for (const ElementField& field : potential.element_fields()) {
    std::vector<double> given;
    if (field.source == ElementField::Source::Data) {
      given = numbers(values, field);
    } else {
      const Vec3& p = (field.source == ElementField::Source::Rest ? X : before)[field.point];
      given = {p.x, p.y, p.z};
    }
    for (int c = 0; c < field.width; ++c) spread(elements, field.offset + c, given[c]);
  }
  for (const UniformField& field : potential.uniform_fields())
    std::ranges::copy(numbers(values, field), uniforms.begin() + field.offset);
  AlignedVector<double> out(potential.kernel().output_count(symbolic::Order::Hessian) * kLanes);
  potential.kernel().evaluate(symbolic::Order::Hessian, unknowns.data(), elements.data(), uniforms.data(),
                              out.data(), 1);
  std::vector<Vec3> gradient(count);
  for (int i = 0; i < n; ++i) gradient[i / 3][i % 3] = out[(1 + i) * kLanes];
  std::vector<double> hessian(n * n);
  for (int i = 0, k = 1 + n; i < n; ++i)
    for (int j = i; j < n; ++j, ++k) hessian[i * n + j] = hessian[j * n + i] = out[k * kLanes];
  return nb::make_tuple(out[0], to_numpy(std::move(gradient)), to_numpy(std::move(hessian)));
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
