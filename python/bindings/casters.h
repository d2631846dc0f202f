// Values of the core that cross the border by themselves, so that functions and members are bound as they
// are: ids are ints, choices are their names, small vectors and lists of them are NumPy arrays.
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/stl/array.h>

#include <array>
#include <concepts>
#include <string>
#include <utility>
#include <vector>

#include <stark/base/reading.h>
#include <stark/base/settings.h>
#include <stark/sim/ids.h>
#include <stark/sim/scene.h>
#include <stark/sim/step_report.h>
#include <stark/symbolic/kernel.h>

#include "arrays.h"

namespace stark::bindings {

/// Number of a part of a scene (sim/ids.h).
template <typename T>
concept IsId = std::is_aggregate_v<T> && sizeof(T) == sizeof(int32_t) && requires(T id) {
  { id.index } -> std::same_as<int32_t&>;
};

/// A list of numbers or small vectors that becomes an array.
template <typename Value>
struct ArrayOf {
  std::vector<Value> values;
};
template <typename Value>
ArrayOf(std::vector<Value>) -> ArrayOf<Value>;

/// Value of a member of a part that an id names: path_of<&Scene::joint, &JointDescription::name>.
template <auto part, auto member>
struct PartOf;
template <typename Part, typename Class, typename Id, const Part& (Class::*part)(Id) const, auto member>
struct PartOf<part, member> {
  static auto value(const Class& self, Id id) { return (self.*part)(id).*member; }
};
template <auto part, auto member>
constexpr auto path_of = &PartOf<part, member>::value;
/// A list that is a member, as an array.
template <auto member>
constexpr auto array_at =
    [](const typename stark::detail::OwnerOf<decltype(member)>::type& self) { return ArrayOf{self.*member}; };

/// All readings of a struct as properties of a class that is one.
template <typename S, typename Class>
void def_readings(nb::class_<Class>& c) {
  for_each_reading<S>([&](const auto& row) {
    c.def_prop_ro(row.name, [read = row.read](const Class& object) { return read(object); }, row.doc);
  });
}

inline void add_to(nb::dict&) {}
template <typename Value, typename... Rest>
void add_to(nb::dict& dict, const char* key, Value&& value, Rest&&... rest) {
  dict[key] = std::forward<Value>(value);
  add_to(dict, std::forward<Rest>(rest)...);
}
/// A dictionary of keys and values in turn: dict_of("name", name, "unit", unit).
template <typename... Entries>
nb::dict dict_of(Entries&&... entries) {
  nb::dict dict;
  add_to(dict, std::forward<Entries>(entries)...);
  return dict;
}

/// A list of what the function makes of each entry.
template <typename Range, typename Function>
nb::list list_of(const Range& range, Function function) {
  nb::list list;
  for (const auto& entry : range) list.append(function(entry));
  return list;
}

}  // namespace stark::bindings

namespace nanobind::detail {

template <stark::bindings::IsId Id>
struct type_caster<Id> {
  NB_TYPE_CASTER(Id, const_name("int"))
  bool from_python(handle object, uint32_t flags, cleanup_list* list) noexcept {
    make_caster<int32_t> number;
    if (!number.from_python(object, flags, list)) return false;
    value = {number.value};
    return true;
  }
  static handle from_cpp(Id id, rv_policy, cleanup_list*) noexcept { return PyLong_FromLong(id.index); }
};

/// To Python only; what comes from there is read with the name of its field (given.h).
template <typename Choice>
struct ChoiceCaster {
  NB_TYPE_CASTER(Choice, const_name("str"))
  bool from_python(handle, uint32_t, cleanup_list*) noexcept { return false; }
  static handle from_cpp(Choice choice, rv_policy, cleanup_list*) noexcept {
    const std::string_view name = stark::EnumNames<Choice>::kNames[static_cast<size_t>(choice)];
    return PyUnicode_FromStringAndSize(name.data(), static_cast<Py_ssize_t>(name.size()));
  }
};
template <>
struct type_caster<stark::BodyKind> : ChoiceCaster<stark::BodyKind> {};
template <>
struct type_caster<stark::Motion> : ChoiceCaster<stark::Motion> {};
template <>
struct type_caster<stark::Integrator> : ChoiceCaster<stark::Integrator> {};
template <>
struct type_caster<stark::StepStatus> : ChoiceCaster<stark::StepStatus> {};
template <>
struct type_caster<stark::SolveStatus> : ChoiceCaster<stark::SolveStatus> {};
template <>
struct type_caster<stark::FailureCause> : ChoiceCaster<stark::FailureCause> {};
template <>
struct type_caster<stark::symbolic::Backend> : ChoiceCaster<stark::symbolic::Backend> {};
template <>
struct type_caster<stark::Caveat> : ChoiceCaster<stark::Caveat> {};

template <typename Entry>
struct type_caster<stark::bindings::ArrayOf<Entry>> {
  using Array = stark::bindings::ArrayOf<Entry>;
  NB_TYPE_CASTER(Array, make_caster<stark::bindings::Numpy<Entry>>::Name)
  bool from_python(handle, uint32_t, cleanup_list*) noexcept { return false; }
  static handle from_cpp(const Array& array, rv_policy, cleanup_list*) noexcept {
    return cast(stark::bindings::to_numpy(array.values)).release();
  }
};

/// From sequences of three numbers, to arrays.
template <>
struct type_caster<stark::Vec3> {
  using Array = make_caster<stark::bindings::Numpy<stark::Vec3>>;
  NB_TYPE_CASTER(stark::Vec3, const_name("@collections.abc.Sequence[float]@") + Array::Name + const_name("@"))
  bool from_python(handle object, uint32_t flags, cleanup_list* list) noexcept {
    make_caster<std::array<double, 3>> numbers;
    if (!numbers.from_python(object, flags, list)) return false;
    value = {numbers.value[0], numbers.value[1], numbers.value[2]};
    return true;
  }
  static handle from_cpp(const stark::Vec3& v, rv_policy, cleanup_list*) noexcept {
    return cast(stark::bindings::to_numpy(std::vector<double>{v.x, v.y, v.z})).release();
  }
};

/// To arrays of shape (3, 3).
template <>
struct type_caster<stark::Mat3> {
  NB_TYPE_CASTER(stark::Mat3, make_caster<stark::bindings::Numpy<stark::Mat3>>::Name)
  bool from_python(handle, uint32_t, cleanup_list*) noexcept { return false; }
  static handle from_cpp(const stark::Mat3& m, rv_policy, cleanup_list*) noexcept {
    return cast(stark::bindings::to_numpy(std::vector<stark::Mat3>{m}, {3, 3})).release();
  }
};

}  // namespace nanobind::detail
