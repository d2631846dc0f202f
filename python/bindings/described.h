// Structs with descriptor tables (settings, materials): values of fields to and from Python, and the methods
// that all of them have, so that a new field needs no line here.
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <string>

#include <stark/base/settings.h>

namespace stark::bindings {

namespace nb = nanobind;
using namespace nb::literals;

nb::object to_python(const FieldValue& value);
/// Flags, integers, reals (NumPy scalars too), texts and rows of three; anything else becomes its text, which
/// the descriptor then refuses by name.
FieldValue to_field_value(nb::handle object);
FieldMap to_field_map(const nb::dict& values);
nb::dict to_dict(const FieldMap& map);
nb::list describe(const FieldTable& table);

/// The methods that every described struct has: get, set, update, to_dict, changed, copy, fields, markdown,
/// ==.
template <typename S>
nb::class_<S> bind_described(nb::module_& m, const char* name, const char* doc) {
  return nb::class_<S>(m, name, doc)
      .def(nb::init<>())
      .def(
          "get", [](const S& s, const std::string& field) { return to_python(S::fields().get(&s, field)); },
          "name"_a)
      .def(
          "set",
          [](S& s, const std::string& field, nb::handle value, const std::string& owner) {
            S::fields().set(&s, field, to_field_value(value), owner);
          },
          "name"_a, "value"_a.none(), "owner"_a = "", "Checks the range, then assigns.")
      .def(
          "update",
          [](S& s, const nb::dict& values, const std::string& owner) {
            S::fields().set_all(&s, to_field_map(values), owner);
          },
          "values"_a, "owner"_a = "", "Assigns all entries, or none when one is refused.")
      .def("to_dict", [](const S& s) { return to_dict(S::fields().to_map(&s)); })
      .def("changed", [](const S& s) { return to_dict(S::fields().changed_from_default(&s)); })
      .def(
          "listing", [](const S& s) { return S::fields().listing(&s); }, "One 'name = value unit' a line.")
      .def("copy", [](const S& s) { return S(s); })
      .def("__eq__",
           [](const S& s, const S& other) { return S::fields().to_map(&s) == S::fields().to_map(&other); })
      .def_static("fields", [] { return describe(S::fields()); })
      .def_static("markdown", [] { return S::fields().markdown(); });
}

}  // namespace stark::bindings
