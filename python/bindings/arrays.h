// NumPy arrays at the border: typed views of what comes in, owning arrays for what goes out. No copies but
// one. A wrong shape or type becomes InvalidArgument with the name of the argument (see array()); nanobind's
// own overload errors do not say which argument was meant.
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

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

/// Converts any array-like object to Array (Rows or Column), or throws InvalidArgument naming the argument,
/// what came and what is needed. Fractions are never truncated to integers, nor wide integers to narrow ones.
template <typename Array>
Array array(nb::handle object, const std::string& name, const std::string& expected) {
  using T = std::remove_const_t<typename Array::Scalar>;
  const nb::module_ numpy = nb::module_::import_("numpy");
  std::string got = text(object.type().attr("__name__"));
  try {
    nb::object values = numpy.attr("asarray")(object);
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
  throw InvalidArgument(name + ": got " + got + ", need " + expected);
}

/// NumPy array that owns the values of a vector: shape (n,) for numbers, (n, k) for types made of k numbers.
template <typename T, typename Value>
nb::ndarray<nb::numpy, T> to_numpy(std::vector<Value>&& vector) {
  static_assert(sizeof(Value) % sizeof(T) == 0);
  constexpr std::size_t columns = sizeof(Value) / sizeof(T);
  auto* owned = new std::vector<Value>(std::move(vector));
  nb::capsule owner(owned, [](void* p) noexcept { delete static_cast<std::vector<Value>*>(p); });
  const std::array<std::size_t, 2> shape = {owned->size(), columns};
  return nb::ndarray<nb::numpy, T>(reinterpret_cast<T*>(owned->data()), columns == 1 ? 1 : 2, shape.data(),
                                   owner);
}

}  // namespace stark::bindings
