// Readings of plain structs: what is worth to be read of one, declared once with name and meaning, for
// whoever shows or exports all of it: bindings, files, telemetry. Values with units, ranges and defaults that
// are set by name are declared in base/settings.h instead.
//
//   template <>
//   struct stark::Readings<Momentum> {
//     static constexpr std::tuple kAll{reading<&Momentum::linear>("linear", "of all free masses [N s]"),
//     ...};
//   };
//   for_each_reading<Momentum>([&](const auto& r) { print(r.name, r.read(momentum)); });
#pragma once

#include <functional>
#include <tuple>

namespace stark {

/// `read(object)` gives the value.
template <typename Read>
struct Reading {
  const char* name;
  const char* doc;
  Read read;
};

namespace detail {
template <typename Member>
struct OwnerOf;
template <typename Value, typename Owner>
struct OwnerOf<Value Owner::*> {
  using type = Owner;
};
}  // namespace detail

/// Value of a member, of a member of a member (path<&StepReport::solve, &SolveReport::residual>) or of a
/// member function at the end.
template <auto first, auto... rest>
constexpr auto path = [](const typename detail::OwnerOf<decltype(first)>::type& object) {
  if constexpr (sizeof...(rest) == 0)
    return std::invoke(first, object);
  else
    return path<rest...>(std::invoke(first, object));
};

template <auto... members>
constexpr auto reading(const char* name, const char* doc = "") {
  return Reading<decltype(path<members...>)>{name, doc, path<members...>};
}

/// Specialise with `static constexpr std::tuple kAll{reading<...>(...), ...}`.
template <typename S>
struct Readings;

template <typename S>
concept HasReadings = requires { Readings<S>::kAll; };

template <HasReadings S, typename Function>
constexpr void for_each_reading(Function&& function) {
  std::apply([&](const auto&... row) { (function(row), ...); }, Readings<S>::kAll);
}

}  // namespace stark
