// Structs with descriptor tables (settings, materials): values of fields to and from Python, and the methods
// that all of them have, so that a new field needs no line here.
#pragma once

#include <string>

#include <stark/base/settings.h>

#include "casters.h"

namespace stark::bindings {

nb::object to_python(const FieldValue& value);
/// Flags, integers, reals (NumPy scalars too), texts and rows of three; anything else becomes its text, which
/// the descriptor then refuses by name.
FieldValue to_field_value(nb::handle object);

}  // namespace stark::bindings

namespace nanobind::detail {

template <>
struct type_caster<stark::FieldValue> {
  NB_TYPE_CASTER(stark::FieldValue, const_name("object"))
  bool from_python(handle object, uint32_t, cleanup_list*) {
    value = stark::bindings::to_field_value(object);
    return true;
  }
  static handle from_cpp(const stark::FieldValue& value, rv_policy, cleanup_list*) {
    return stark::bindings::to_python(value).release();
  }
};

/// Dictionaries, in their order.
template <>
struct type_caster<stark::FieldMap> {
  NB_TYPE_CASTER(stark::FieldMap, const_name("dict"))
  bool from_python(handle object, uint32_t, cleanup_list*) {
    if (!isinstance<dict>(object)) return false;
    for (auto [name, entry] : borrow<dict>(object))
      value.emplace_back(stark::bindings::text(name), stark::bindings::to_field_value(entry));
    return true;
  }
  static handle from_cpp(const stark::FieldMap& map, rv_policy, cleanup_list*) {
    dict result;
    for (const auto& [name, entry] : map) result[name.c_str()] = entry;
    return result.release();
  }
};

}  // namespace nanobind::detail

namespace stark::bindings {

/// Rows of what can be set: name, unit, default, rule, choices, doc.
nb::list describe(const FieldTable& table);

/// The methods that every described struct has: get, set, update, to_dict, changed, copy, fields, markdown,
/// ==.
template <typename S>
nb::class_<S> bind_described(nb::module_& m, const char* name, const char* doc) {
  const auto set = [](S& s, const std::string& field, const FieldValue& value, const std::string& owner) {
    S::fields().set(&s, field, value, owner);
  };
  const auto update = [](S& s, const FieldMap& values, const std::string& owner) {
    S::fields().set_all(&s, values, owner);
  };
  return nb::class_<S>(m, name, doc)
      .def(nb::init<>())
      .def(
          "get", [](const S& s, const std::string& field) { return S::fields().get(&s, field); }, "name"_a)
      .def("set", set, "name"_a, "value"_a.none(), "owner"_a = "", "Checks the range, then assigns.")
      .def("update", update, "values"_a, "owner"_a = "", "Assigns all entries, or none when one is refused.")
      .def("to_dict", [](const S& s) { return S::fields().to_map(&s); })
      .def("changed", [](const S& s) { return S::fields().changed_from_default(&s); })
      .def(
          "listing", [](const S& s) { return S::fields().listing(&s); }, "One 'name = value unit' a line.")
      .def("copy", [](const S& s) { return S(s); })
      .def("__eq__", [](const S& s, const S& o) { return S::fields().to_map(&s) == S::fields().to_map(&o); })
      .def_static("fields", [] { return describe(S::fields()); })
      .def_static("markdown", [] { return S::fields().markdown(); });
}

}  // namespace stark::bindings
