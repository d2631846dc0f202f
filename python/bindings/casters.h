// Values of the core that cross the border by themselves, so that functions and members are bound as they
// are: ids are ints, choices are their names, small vectors and lists of them are NumPy arrays. No copies of
// arrays but one. A wrong shape or type becomes InvalidArgument with the name of the argument (see array());
// nanobind's own overload errors do not say which argument was meant.
#pragma once

#include <nanobind/ndarray.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/map.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/string_view.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <concepts>
#include <span>
#include <variant>

#include <stark/base/choices.h>
#include <stark/collision/intersection.h>
#include <stark/mechanics/declaration_readings.h>
#include <stark/sim/scene/scene_readings.h>
#include <stark/sim/step/report_readings.h>
#include <stark/symbolic/kernel.h>

#include "domains.h"

namespace stark::bindings {

/// str(value) of Python.
inline std::string text(nb::handle value) { return nb::str(value).c_str(); }

/// A value as a message shows it: its repr on one line, cut where it is long.
inline std::string shown(nb::handle value) {
  constexpr std::size_t kLongest = 80;
  std::string all = text(nb::repr(value));
  std::size_t end = std::min(all.find('\n'), kLongest);
  if (end >= all.size()) return all;
  while (end > 0 && (all[end] & 0xC0) == 0x80) --end;  // not within a character of UTF-8
  return all.substr(0, end) + "...";
}

/// Whether the object is such an array as it is, which `result` then shares. Scalars of NumPy are none: the
/// buffer of a date has no strides, where nanobind reads some.
template <typename Array>
bool is_such_array(nb::handle object, Array& result) {
  if (nb::isinstance(object, nb::module_::import_("numpy").attr("generic"))) return false;
  return nb::try_cast<Array>(object, result, false) && result.is_valid();
}

/// Converts any array-like object to Array, or throws InvalidArgument naming the argument,
/// what came and what is needed. Fractions are never truncated to integers, nor wide integers to narrow ones.
template <typename Array>
Array array(nb::handle object, const std::string& name, const std::string& expected) {
  using T = std::remove_const_t<typename Array::Scalar>;
  if (Array as_it_is; is_such_array(object, as_it_is)) return as_it_is;
  const nb::module_ numpy = nb::module_::import_("numpy");
  std::string got = text(object.type().attr("__name__"));
  try {
    nb::object values = numpy.attr("asarray")(object);
    if (nb::cast<std::size_t>(values.attr("ndim")) == 0)
      got = shown(object);
    else
      got = "an array of shape " + text(values.attr("shape")) + " and type " + text(values.attr("dtype"));
    const std::string kinds = std::is_integral_v<T> ? "iu" : "iuf";
    const bool empty = nb::cast<std::size_t>(values.attr("size")) == 0;
    if (empty || kinds.find(text(values.attr("dtype").attr("kind"))) != std::string::npos) {
      const char* type = std::is_integral_v<T> ? (sizeof(T) == 4 ? "int32" : "int64") : "float64";
      nb::object converted = numpy.attr("ascontiguousarray")(values, type);
      const bool exact =
          !std::is_integral_v<T> || nb::cast<bool>(numpy.attr("array_equal")(converted, values));
      Array result;
      if (exact && is_such_array(converted, result)) return result;
    }
  } catch (const nb::python_error& error) {
    if (!error.matches(PyExc_Exception)) throw;  // Ctrl-C
    // Not an array of anything, for instance rows of unequal length: reported below.
  }
  throw InvalidArgument(name + ": got " + got + ": must be " + expected);
}

template <typename T, typename... Types>
concept OneOf = (std::is_same_v<T, Types> || ...);

/// Lists of numbers, or of rows of them, which are arrays in Python.
template <typename T>
constexpr bool is_list = false;
template <typename Value>
constexpr bool is_list<std::vector<Value>> = true;
template <typename T>
constexpr bool is_fixed_array = false;
template <typename Value, size_t n>
constexpr bool is_fixed_array<std::array<Value, n>> = true;

template <typename Value>
auto number_in() {
  if constexpr (OneOf<Value, Vec3, Mat3, Wrench, CellFilling>)
    return std::type_identity<double>();
  else if constexpr (OneOf<Value, EdgeTriangleIntersection, ContainedGroup>)
    return std::type_identity<int32_t>();
  else if constexpr (is_fixed_array<Value>)
    return number_in<typename Value::value_type>();
  else
    return std::type_identity<Value>();
}
/// What a plain type is made of: Vec3 of doubles, CellFilling of 27 moments.
template <typename Value>
using NumberOf = typename decltype(number_in<Value>())::type;
template <typename T>
constexpr bool is_array = false;
template <typename Value>
constexpr bool is_array<std::vector<Value>> =
    std::is_arithmetic_v<NumberOf<Value>> && !std::is_same_v<Value, bool>;

/// NumPy array of a shape that owns values; vectors may be moved into it.
template <typename Value>
auto to_numpy(std::vector<Value> values, const std::vector<std::size_t>& shape) {
  auto* owned = new std::vector<Value>(std::move(values));
  nb::capsule owner(owned, [](void* p) noexcept { delete static_cast<std::vector<Value>*>(p); });
  using Number = NumberOf<Value>;
  return nb::ndarray<nb::numpy, Number>(reinterpret_cast<Number*>(owned->data()), shape.size(), shape.data(),
                                        owner);
}

/// Of shape (n,) for numbers, (n, k) for types made of k numbers.
template <typename Value>
auto to_numpy(std::vector<Value> values) {
  constexpr std::size_t columns = sizeof(Value) / sizeof(NumberOf<Value>);
  const std::size_t count = values.size();
  if constexpr (columns == 1) return to_numpy(std::move(values), {count});
  return to_numpy(std::move(values), {count, columns});
}

/// Number of a part of a scene (sim/scene/ids.h).
template <typename T>
concept IsId = std::is_aggregate_v<T> && sizeof(T) == sizeof(int32_t) && requires(T id) {
  { id.index } -> std::same_as<int32_t&>;
};

/// What a function gives to Python: its lists as arrays, also those in a tuple.
template <typename T>
auto to_array(T result) {
  if constexpr (is_array<T>)
    return to_numpy(std::move(result));
  else if constexpr (requires { std::tuple_size<T>::value; } && !requires { result[0]; })
    return std::apply([](auto&... parts) { return std::tuple(to_array(std::move(parts))...); }, result);
  else
    return result;
}

/// Value of a member of a part that an id names: path_of(&Scene::joint, &JointDescription::name).
template <typename Part, typename Class, typename Id, typename Owner, typename Value>
auto path_of(Part (Class::*part)(Id) const, Value Owner::* member) {
  return [=](const Class& self, Id id) -> Value { return (self.*part)(id).*member; };
}

/// What has readings is a dictionary of them, unless Python has a class for it.
template <typename T>
concept Record = HasReadings<T> && !OneOf<T, Diagnosis, StepReport>;
template <typename T>
concept Pair = OneOf<T, Wrench, TriangleMesh, TetMesh, JointOutputs::Coordinate>;
template <typename T>
concept Triple = OneOf<T, SurfaceMotion, ClosestPoints>;

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

/// What plain structs are in Python: arrays, dictionaries, tuples of their members.
template <typename T>
auto form_of(const T& value) {
  if constexpr (std::is_same_v<T, Vec3>) {
    return to_numpy(std::vector<double>{value.x, value.y, value.z});
  } else if constexpr (std::is_same_v<T, Mat3>) {
    return to_numpy(std::vector<Mat3>{value}, {3, 3});
  } else if constexpr (Record<T>) {
    return dict_of_readings(value);
  } else if constexpr (Pair<T>) {
    const auto& [a, b] = value;
    return to_array(std::tuple(a, b));
  } else {
    const auto& [a, b, c] = value;
    return to_array(std::tuple(a, b, c));
  }
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

/// A list of what the function makes of each entry.
template <typename Range, typename Function>
nb::list list_of(const Range& range, Function function) {
  nb::list list;
  for (const auto& entry : range) list.append(function(entry));
  return list;
}

/// Flags, integers, reals (NumPy scalars too), texts and rows of three; anything else becomes its text, which
/// the descriptor then refuses by name.
inline FieldValue to_field_value(nb::handle object) {
  // A number of NumPy, an array without dimensions too, is what it holds.
  if (nb::hasattr(object, "item") && nb::hasattr(object, "ndim") &&
      nb::int_(object.attr("ndim")).equal(nb::int_(0))) {
    // What numpy.ma masks holds a number, which nobody gave.
    const nb::object mask = nb::getattr(object, "mask", nb::none());
    if (nb::cast<bool>(nb::bool_(mask))) return std::string("masked");
    const nb::object held = object.attr("item")();
    if (!held.type().is(object.type())) return to_field_value(held);  // long doubles hold themselves
  }
  if (nb::isinstance<nb::str>(object)) return nb::cast<std::string>(object);
  if (nb::isinstance<nb::bool_>(object)) return nb::cast<bool>(object);
  if (PyIndex_Check(object.ptr()) && !nb::hasattr(object, "__len__")) {
    int64_t integer = 0;
    if (nb::try_cast<int64_t>(nb::int_(object), integer)) return integer;
  }
  try {
    if (nb::hasattr(object, "__len__")) {
      if (nb::len(object) == 3 && !nb::isinstance<nb::bytes>(object)) {
        Vec3 v;
        for (int i = 0; i < 3; ++i) {
          const nb::object entry = object[i];
          if (nb::isinstance<nb::bool_>(entry)) return text(object);
          v[i] = nb::cast<double>(nb::float_(entry));
        }
        return v;
      }
    } else if (nb::hasattr(object, "__float__")) {
      return nb::cast<double>(nb::float_(object));
    }
  } catch (const std::exception&) {
  }
  return text(object);
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

/// To Python only, as what the function makes of a value; what comes from there is read by name
/// (functions.h).
template <typename T, auto to_python>
struct OneWayCaster {
  using Made = std::remove_cvref_t<decltype(to_python(std::declval<const T&>()))>;
  NB_TYPE_CASTER(T, make_caster<Made>::Name)
  bool from_python(handle, uint32_t, cleanup_list*) noexcept { return false; }
  static handle from_cpp(const T& value, rv_policy, cleanup_list*) {
    return cast(to_python(value)).release();
  }
};

/// From Python where EnumNames has the noun that messages need.
template <typename Choice>
  requires requires { stark::EnumNames<Choice>::kNames; }
struct type_caster<Choice, enable_if_t<std::is_enum_v<Choice>>>
    : OneWayCaster<Choice, stark::bindings::name_of<Choice>> {
  bool from_python(handle object, uint32_t, cleanup_list*) {
    if constexpr (requires { stark::EnumNames<Choice>::kNoun; }) {
      const bool is_text = isinstance<str>(object);
      const std::string name = is_text ? cast<std::string>(object) : "";
      const std::string given = is_text ? "'" + name + "'" : stark::bindings::shown(object);
      const std::string subject = std::string(stark::EnumNames<Choice>::kNoun) + " " + given;
      this->value = stark::choice_of<Choice>(name, subject);
      return true;
    }
    return false;
  }
};
template <typename T>
  requires stark::bindings::Record<T> || stark::bindings::Pair<T> || stark::bindings::Triple<T> ||
           stark::bindings::OneOf<T, stark::Vec3, stark::Mat3>
struct type_caster<T> : OneWayCaster<T, stark::bindings::form_of<T>> {};

template <>
struct type_caster<stark::FieldValue> {
  NB_TYPE_CASTER(stark::FieldValue, const_name("object"))
  bool from_python(handle object, uint32_t, cleanup_list*) {
    value = stark::bindings::to_field_value(object);
    return true;
  }
  static handle from_cpp(const stark::FieldValue& value, rv_policy, cleanup_list*) {
    if (const auto* v = std::get_if<stark::Vec3>(&value)) return make_tuple(v->x, v->y, v->z).release();
    return std::visit([](const auto& v) { return cast(v); }, value).release();
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
