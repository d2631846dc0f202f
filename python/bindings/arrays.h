// NumPy arrays at the border: typed views of what comes in, owning arrays for what goes out. No copies but
// one. A wrong shape or type becomes InvalidArgument with the name of the argument (see array()); nanobind's
// own overload errors do not say which argument was meant.
#pragma once

#include <nanobind/ndarray.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include <stark/base/error.h>
#include <stark/base/math.h>

#include "domains.h"

namespace stark::bindings {

/// C-contiguous (n, Columns) array on the CPU. As a parameter type it accepts arrays only; array() accepts
/// lists too.
template <typename T, long Columns>
using Rows = nb::ndarray<const T, nb::shape<-1, Columns>, nb::c_contig, nb::device::cpu>;

/// C-contiguous vector of n numbers on the CPU.
template <typename T>
using Column = nb::ndarray<const T, nb::ndim<1>, nb::c_contig, nb::device::cpu>;

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

/// Converts any array-like object to Array (Rows or Column), or throws InvalidArgument naming the argument,
/// what came and what is needed. Fractions are never truncated to integers, nor wide integers to narrow ones.
template <typename Array>
Array array(nb::handle object, const std::string& name, const std::string& expected) {
  using T = std::remove_const_t<typename Array::Scalar>;
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
      if (exact && nb::try_cast<Array>(converted, result, false) && result.is_valid()) return result;
    }
  } catch (const nb::python_error& error) {
    if (!error.matches(PyExc_Exception)) throw;  // Ctrl-C
    // Not an array of anything, for instance rows of unequal length: reported below.
  }
  throw InvalidArgument(name + ": got " + got + ": must be " + expected);
}

/// Numbers that a plain type is made of: Vec3 of doubles, std::array<int, 4> of ints.
template <typename Value>
struct NumbersOf {
  using type = Value;
};
template <>
struct NumbersOf<Vec3> {
  using type = double;
};
template <>
struct NumbersOf<Mat3> {
  using type = double;
};
template <typename T, std::size_t n>
struct NumbersOf<std::array<T, n>> {
  using type = T;
};
/// Lists of numbers, or of rows of them, which are arrays in Python.
template <typename T>
constexpr bool is_list = false;
template <typename Value>
constexpr bool is_list<std::vector<Value>> = true;
template <typename T>
constexpr bool is_array = false;
template <typename Value>
constexpr bool is_array<std::vector<Value>> = std::is_arithmetic_v<typename NumbersOf<Value>::type>;

template <typename Value>
using Numpy = nb::ndarray<nb::numpy, typename NumbersOf<Value>::type>;

/// NumPy array of a shape that owns values; vectors may be moved into it.
template <typename Value>
Numpy<Value> to_numpy(std::vector<Value> values, const std::vector<std::size_t>& shape) {
  auto* owned = new std::vector<Value>(std::move(values));
  nb::capsule owner(owned, [](void* p) noexcept { delete static_cast<std::vector<Value>*>(p); });
  using T = typename NumbersOf<Value>::type;
  return Numpy<Value>(reinterpret_cast<T*>(owned->data()), shape.size(), shape.data(), owner);
}

/// Of shape (n,) for numbers, (n, k) for types made of k numbers.
template <typename Value>
Numpy<Value> to_numpy(std::vector<Value> values) {
  constexpr std::size_t columns = sizeof(Value) / sizeof(typename NumbersOf<Value>::type);
  const std::size_t count = values.size();
  if constexpr (columns == 1) return to_numpy(std::move(values), {count});
  return to_numpy(std::move(values), {count, columns});
}

}  // namespace stark::bindings
