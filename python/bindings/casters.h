// Values of the core that cross the border by themselves, so that functions and members are bound as they
// are: ids are ints, choices are their names, small vectors and lists of them are NumPy arrays.
#pragma once

#include <nanobind/stl/array.h>
#include <nanobind/stl/map.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/string_view.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <array>
#include <concepts>
#include <string>
#include <utility>
#include <vector>

#include <stark/base/reading.h>
#include <stark/base/settings.h>
#include <stark/mechanics/declaration_readings.h>
#include <stark/sim/ids.h>
#include <stark/sim/report_readings.h>
#include <stark/sim/scene.h>
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

template <typename Result>
decltype(auto) to_array(Result&& result) {
  if constexpr (is_array<std::remove_cvref_t<Result>>)
    return ArrayOf{std::forward<Result>(result)};
  else
    return std::forward<Result>(result);
}

/// Value of a member of a part that an id names: path_of(&Scene::joint, &JointDescription::name).
template <typename Part, typename Class, typename Id, typename Owner, typename Value>
auto path_of(Part (Class::*part)(Id) const, Value Owner::* member) {
  return [=](const Class& self, Id id) {
    Value value = (self.*part)(id).*member;
    return to_array(std::move(value));
  };
}

/// How many members a plain struct has that is a tuple of them in Python.
template <typename T>
constexpr int kMembers = 0;
template <>
inline constexpr int kMembers<SurfaceMotion> = 3;
template <>
inline constexpr int kMembers<Wrench> = 2;
template <>
inline constexpr int kMembers<JointOutputs::Coordinate> = 2;

template <typename T>
auto tuple_of(const T& value) {
  const auto of = [](auto... members) { return std::tuple(to_array(std::move(members))...); };
  if constexpr (kMembers<T> == 2) {
    const auto& [a, b] = value;
    return of(a, b);
  } else {
    const auto& [a, b, c] = value;
    return of(a, b, c);
  }
}

/// Whether Python has a class for it; what else has readings is a dictionary of them.
template <typename T>
constexpr bool has_class = false;
template <>
inline constexpr bool has_class<Diagnosis> = true;
template <>
inline constexpr bool has_class<StepReport> = true;
template <typename T>
concept Record = HasReadings<T> && !has_class<T>;

template <HasReadings T>
nb::dict dict_of_readings(const T& value);

/// Dictionaries, lists, numbers and texts alone.
template <typename T>
nb::object plain(const T& value) {
  if constexpr (HasReadings<T>)
    return dict_of_readings(value);
  else if constexpr (std::is_same_v<T, Vec3>)
    return nb::make_tuple(value.x, value.y, value.z);
  else
    return nb::cast(value);
}
template <HasReadings T>
nb::dict dict_of_readings(const T& value) {
  nb::dict dict;
  for_each_reading<T>([&](const auto& row) { dict[row.name] = plain(row.read(value)); });
  return dict;
}

/// All readings of a struct as properties of a class that is one.
template <typename S, typename Class>
void def_readings(nb::class_<Class>& c) {
  for_each_reading<S>([&](const auto& row) {
    c.def_prop_ro(row.name, [read = row.read](const Class& object) { return read(object); }, row.doc);
  });
}

template <typename Choice>
std::string_view name_of(Choice choice) {
  return EnumNames<Choice>::kNames[static_cast<size_t>(choice)];
}
template <typename Value>
auto numpy_of(const ArrayOf<Value>& array) {
  return to_numpy(array.values);
}
inline auto numpy_of_matrix(const Mat3& matrix) { return to_numpy(std::vector<Mat3>{matrix}, {3, 3}); }

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

nb::object to_python(const FieldValue& value);
/// Flags, integers, reals (NumPy scalars too), texts and rows of three; anything else becomes its text, which
/// the descriptor then refuses by name.
FieldValue to_field_value(nb::handle object);

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

/// To Python only, as what the function makes of a value; what comes from there is read by name (given.h).
template <typename T, auto to_python>
struct OneWayCaster {
  using Made = std::remove_cvref_t<decltype(to_python(std::declval<const T&>()))>;
  NB_TYPE_CASTER(T, make_caster<Made>::Name)
  bool from_python(handle, uint32_t, cleanup_list*) noexcept { return false; }
  static handle from_cpp(const T& value, rv_policy, cleanup_list*) {
    return cast(to_python(value)).release();
  }
};

template <typename Choice>
  requires requires { stark::EnumNames<Choice>::kNames; }
struct type_caster<Choice, enable_if_t<std::is_enum_v<Choice>>>
    : OneWayCaster<Choice, stark::bindings::name_of<Choice>> {};
template <typename T>
  requires(stark::bindings::kMembers<T> > 0)
struct type_caster<T> : OneWayCaster<T, stark::bindings::tuple_of<T>> {};
template <stark::bindings::Record T>
struct type_caster<T> : OneWayCaster<T, stark::bindings::dict_of_readings<T>> {};
template <typename Entry>
struct type_caster<stark::bindings::ArrayOf<Entry>>
    : OneWayCaster<stark::bindings::ArrayOf<Entry>, stark::bindings::numpy_of<Entry>> {};
/// Of shape (3, 3).
template <>
struct type_caster<stark::Mat3> : OneWayCaster<stark::Mat3, stark::bindings::numpy_of_matrix> {};

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
