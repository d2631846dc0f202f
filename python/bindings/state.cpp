#include "state.h"

#include <nanobind/operators.h>
#include <nanobind/stl/string.h>

#include <cstdio>
#include <vector>

#include <stark/mechanics/state.h>

#include "arrays.h"

namespace stark::bindings {

using namespace nb::literals;

std::string hex(uint64_t value) {
  char text[17];
  std::snprintf(text, sizeof(text), "%016llx", static_cast<unsigned long long>(value));
  return text;
}

namespace {

/// A field as an array of its own.
nb::object copied(const StateArray& field) {
  size_t count = 1;
  for (const size_t extent : field.shape) count *= extent;
  const auto owned = [&]<typename T>(const T* data) {
    auto* values = new std::vector<T>(data, data + count);
    nb::capsule owner(values, [](void* p) noexcept { delete static_cast<std::vector<T>*>(p); });
    return nb::cast(nb::ndarray<nb::numpy, T>(values->data(), field.shape.size(), field.shape.data(), owner));
  };
  return field.is_integer ? owned(static_cast<const int64_t*>(field.data))
                          : owned(static_cast<const double*>(field.data));
}

nb::dict state_arrays(const State& state) {
  nb::dict arrays;
  for (const StateArray& field : arrays_of(state)) arrays[field.name.c_str()] = copied(field);
  return arrays;
}

nb::list state_fields() {
  nb::list fields;
  const State none;
  for (const StateArray& field : arrays_of(none)) {
    nb::dict row;
    row["name"] = field.name;
    row["unit"] = field.unit;
    row["meaning"] = field.meaning;
    fields.append(row);
  }
  return fields;
}

State state_of_arrays(const nb::dict& given) {
  using Any = nb::ndarray<nb::ro, nb::c_contig, nb::device::cpu>;
  std::vector<Any> kept;  // the arrays live as long as they are read
  std::vector<StateArray> arrays;
  for (const auto& [key, value] : given) {
    const std::string name = text(key);
    Any array;
    if (!nb::try_cast<Any>(value, array, false) ||
        (array.dtype() != nb::dtype<double>() && array.dtype() != nb::dtype<int64_t>()))
      throw InvalidArgument("state: the field '" + name +
                            "' must be a contiguous array of the type float64 or int64");
    StateArray field{.name = name, .unit = "", .meaning = ""};
    field.is_integer = array.dtype() == nb::dtype<int64_t>();
    for (size_t k = 0; k < array.ndim(); ++k) field.shape.push_back(array.shape(k));
    field.data = array.data();
    kept.push_back(array);
    arrays.push_back(field);
  }
  return make_state(arrays);
}

}  // namespace

void bind_state(nb::module_& m) {
  nb::class_<State>(m, "State", "Everything that changes in time, as a value.")
      .def_prop_ro(
          "time", [](const State& s) { return s.time; }, "Simulated time [s].")
      .def_prop_ro(
          "time_step", [](const State& s) { return s.time_step; },
          "Length of the next step, or less for the next mark [s].")
      .def_prop_ro(
          "step_count", [](const State& s) { return s.step_count; }, "Accepted steps so far.")
      .def_prop_ro(
          "point_positions",
          [](const State& s) { return to_numpy<double>(std::vector<Vec3>(s.point_position)); },
          nb::rv_policy::automatic, "Positions of the points of cloth and solids (n, 3) [m].")
      .def_prop_ro(
          "point_velocities",
          [](const State& s) { return to_numpy<double>(std::vector<Vec3>(s.point_velocity)); },
          nb::rv_policy::automatic, "Their velocities (n, 3) [m/s].")
      .def_prop_ro(
          "body_positions",
          [](const State& s) { return to_numpy<double>(std::vector<Vec3>(s.body_position)); },
          nb::rv_policy::automatic, "Centres of mass of rigid bodies, nodes of rods (n, 3) [m].")
      .def_prop_ro(
          "hash", [](const State& s) { return hex(s.hash()); }, "Hash of all bits, 16 hexadecimal digits.")
      .def(
          "copy", [](const State& s) { return s; }, "A state of its own: the same value.")
      .def("arrays", &state_arrays,
           "All fields by name, as arrays of their own; State.fields() describes them.")
      .def_static(
          "of_arrays", &state_of_arrays, "arrays"_a,
          "The state of what arrays() gave. Raises InvalidArgument for fields that are missing, unknown "
          "or of another type or shape.")
      .def_static("fields", &state_fields, "Name, unit and meaning of every field, in order.")
      .def("__eq__", [](const State& a, const State& b) { return first_difference(a, b).empty(); })
      .def(
          "first_difference", [](const State& a, const State& b) { return first_difference(a, b); },
          "Name of the first field that differs, '' when all bits are equal.");
}

}  // namespace stark::bindings
