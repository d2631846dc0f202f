// Traced scalars at the border: from what Python has to those of symbolic/traced_scalar; orders of
// derivatives and back ends.
#pragma once

#include <stark/symbolic/traced_scalar.h>

#include "functions.h"

namespace stark::bindings {

using symbolic::TracedScalar;

/// A traced scalar, or a number of Python or NumPy (also an array without dimensions); nothing for other
/// types.
std::optional<TracedScalar> to_traced(nb::handle object);
/// The same; throws TraceError that says what `name` got instead.
TracedScalar require_traced(nb::handle object, const std::string& name);
/// The items of a sequence; throws TraceError naming the place of one that is not a scalar.
std::vector<TracedScalar> require_traced_list(nb::handle sequence, const std::string& name);

/// Functions of traced scalars name them as arrays, for messages.
template <>
inline constexpr bool comes_as_array<TracedScalar> = true;
template <>
inline constexpr bool comes_as_array<std::vector<TracedScalar>> = true;
template <>
inline TracedScalar from_array(nb::handle object, const std::string& name) {
  return require_traced(object, name);
}
template <>
inline std::vector<TracedScalar> from_array(nb::handle sequence, const std::string& name) {
  return require_traced_list(sequence, name);
}

}  // namespace stark::bindings

namespace nanobind::detail {

/// 0, 1 or 2.
template <>
struct type_caster<stark::symbolic::Order> {
  NB_TYPE_CASTER(stark::symbolic::Order, const_name("int"))
  bool from_python(handle object, uint32_t, cleanup_list*) {
    const int order = cast<int>(object);
    if (order < 0 || order > 2)
      throw stark::InvalidArgument("order " + std::to_string(order) + ": must be 0, 1 or 2");
    value = static_cast<stark::symbolic::Order>(order);
    return true;
  }
  static handle from_cpp(stark::symbolic::Order order, rv_policy, cleanup_list*) noexcept {
    return PyLong_FromLong(static_cast<long>(order));
  }
};

}  // namespace nanobind::detail
