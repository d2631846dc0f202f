// Functions of the core as Python calls them: arguments that are vectors, matrices or lists of numbers come
// as any array or list, with their name in messages; lists that come back are arrays.
#pragma once

#include <algorithm>
#include <array>
#include <span>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "given.h"

namespace stark::bindings {

/// A text as an argument of a template: "targets: an (n, 3) array of positions" is the name of an argument
/// and what it must be. With "?" behind the name it may be empty: [] has no columns.
template <size_t n>
struct Text {
  char characters[n]{};
  constexpr Text(const char (&text)[n]) { std::copy_n(text, n, characters); }  // NOLINT: implicit on purpose
};

/// What an argument is kept in while its function runs.
template <typename T>
struct Kept {
  using type = T;
};
template <typename T>
struct Kept<std::span<const T>> {
  using type = std::vector<T>;
};

template <typename T>
constexpr bool comes_as_array = is_array<typename Kept<T>::type>;
template <>
inline constexpr bool comes_as_array<Vec3> = true;
template <>
inline constexpr bool comes_as_array<Mat3> = true;

template <typename T>
T from_array(nb::handle object, const std::string& text) {
  std::string name = text.substr(0, text.find(": "));
  const std::string expected = name.size() == text.size() ? "" : text.substr(name.size() + 2);
  if (name.ends_with('?')) {
    name.pop_back();
    if (nb::hasattr(object, "__len__") && nb::len(object) == 0) return {};
  }
  return read<T>(object, name, expected);
}

template <auto function, typename Signature, Text... texts>
struct WithArrays;
template <auto function, typename Result, typename... Args, Text... texts>
struct WithArrays<function, Result(Args...), texts...> {
  template <typename Arg>
  static constexpr bool is_array = comes_as_array<std::remove_cvref_t<Arg>>;
  template <typename Arg>
  using Given = std::conditional_t<is_array<Arg>, nb::object, Arg>;
  template <typename Arg>
  using KeptArg =
      std::conditional_t<is_array<Arg>, typename Kept<std::remove_cvref_t<Arg>>::type, Given<Arg>>;

  static auto call(Given<Args>... given) {
    [[maybe_unused]] const std::array<std::string, sizeof...(texts)> names{texts.characters...};
    [[maybe_unused]] size_t next = 0;
    const auto read = [&]<typename Arg>(std::type_identity<Arg>, auto& value) -> KeptArg<Arg> {
      if constexpr (is_array<Arg>)
        return from_array<KeptArg<Arg>>(value, names.at(next++));
      else
        return static_cast<Given<Arg>>(value);
    };
    std::tuple<KeptArg<Args>...> kept{read(std::type_identity<Args>(), given)...};  // from left to right
    const auto run = [](auto&... args) -> Result { return std::invoke(function, args...); };
    if constexpr (std::is_void_v<Result>)
      std::apply(run, kept);
    else
      return to_array(std::apply(run, kept));
  }
};

template <typename Function>
struct SignatureOf;
template <typename Result, typename... Args>
struct SignatureOf<Result (*)(Args...)> {
  using result = Result;
  using type = Result(Args...);
};
template <typename Result, typename Class, typename... Args>
struct SignatureOf<Result (Class::*)(Args...)> {
  using type = Result(Class&, Args...);
};
template <typename Result, typename Class, typename... Args>
struct SignatureOf<Result (Class::*)(Args...) const> {
  using type = Result(const Class&, Args...);
};

/// with_arrays<&Simulation::push, "velocity", "angular_velocity">: a text for each argument that is an array.
template <auto function, Text... texts>
constexpr auto with_arrays =
    &WithArrays<function, typename SignatureOf<decltype(function)>::type, texts...>::call;

}  // namespace stark::bindings
