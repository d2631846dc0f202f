// NumPy arrays at the border: typed views of what comes in, owning arrays for what goes out. No copies but
// one. A wrong shape or type becomes InvalidArgument with the name of the argument (see array()); nanobind's
// own overload errors do not say which argument was meant.
#pragma once

#include <nanobind/nanobind.h>
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

namespace stark::bindings {

namespace nb = nanobind;

/// C-contiguous (n, Columns) array on the CPU. As a parameter type it accepts arrays only; array() accepts
/// lists too.
template <typename T, long Columns>
using Rows = nb::ndarray<const T, nb::shape<-1, Columns>, nb::c_contig, nb::device::cpu>;

/// C-contiguous vector of n numbers on the CPU.
template <typename T>
using Column = nb::ndarray<const T, nb::ndim<1>, nb::c_contig, nb::device::cpu>;

/// The rows of an (n, Columns) array as values of a plain type of exactly Columns numbers (Vec3,
/// std::array<int, 4>).
template <typename Value, typename T, long Columns>
std::span<const Value> rows(const Rows<T, Columns>& array) {
  static_assert(sizeof(Value) == sizeof(T) * Columns);
  return {reinterpret_cast<const Value*>(array.data()), array.shape(0)};
}

template <typename T>
std::span<const T> values(const Column<T>& array) {
  return {array.data(), array.shape(0)};
}

/// str(value) of Python.
inline std::string text(nb::handle value) { return nb::str(value).c_str(); }

/// A value as a message shows it: its repr, cut where it is long.
inline std::string shown(nb::handle value) {
  constexpr std::size_t kLongest = 80;
  std::string all = nb::repr(value).c_str();
  return all.size() <= kLongest ? all : all.substr(0, kLongest) + "...";
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

/// The numbers of an array of rows, or of a flat one, as a list of their own.
template <typename Value, typename T, long columns>
std::vector<Value> rows_of(nb::handle object, const std::string& name, const std::string& expected) {
  const auto given = array<Rows<T, columns>>(object, name, expected);
  const auto view = rows<Value>(given);
  return {view.begin(), view.end()};
}
template <typename T>
std::vector<T> numbers_of(nb::handle object, const std::string& name, const std::string& expected) {
  const auto given = array<Column<T>>(object, name, expected);
  return {given.data(), given.data() + given.shape(0)};
}

inline Vec3 vector_of(nb::handle object, const std::string& name) {
  const auto v = numbers_of<double>(object, name, "three numbers");
  if (v.size() != 3) throw InvalidArgument(name + ": got " + shown(object) + ": must be three numbers");
  return {v[0], v[1], v[2]};
}
inline Mat3 matrix_of(nb::handle object, const std::string& name,
                      const std::string& expected = "a 3 x 3 rotation matrix") {
  const auto matrix = array<Rows<double, 3>>(object, name, expected);
  if (matrix.shape(0) != 3)
    throw InvalidArgument(name + ": got " + std::to_string(matrix.shape(0)) + " rows: must be " + expected);
  Mat3 result;
  std::copy_n(matrix.data(), 9, result.m.begin());
  return result;
}
inline std::vector<Vec3> points_of(nb::handle object, const std::string& name,
                                   const char* expected = "an array of shape (n, 3) of real numbers [m]") {
  return rows_of<Vec3, double, 3>(object, name, expected);
}

/// As many positions as needed.
inline std::vector<Vec3> points_of(nb::handle object, const std::string& name, std::size_t count) {
  std::vector<Vec3> points = points_of(object, name, "an (n, 3) array of positions");
  if (points.size() != count)
    throw InvalidArgument(name + ": got " + std::to_string(points.size()) + " points: must be " +
                          std::to_string(count));
  return points;
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
