// Functions of the core as Python calls them: def(scope, "push", &Simulation::push, {"body", "velocity"},
// doc) binds functions, methods and lambdas with the names of their arguments. What comes from Python is read
// by the type that it becomes: vectors, matrices and lists of numbers from any array or list, descriptions
// from dictionaries, whose entries are read into the members that they are for. Errors name the argument or
// the entry. Lists that come back are arrays.
#pragma once

#include <functional>
#include <string>
#include <tuple>
#include <type_traits>
#include <vector>

#include <stark/mechanics/field_values.h>
#include <stark/sim/scene/description_fields.h>

#include "casters.h"

namespace stark::bindings {

/// Any array or list as one of numbers, or of rows of as many as a value has.
template <typename Value>
std::vector<Value> array_of(nb::handle object, const std::string& name, std::string expected) {
  using Number = NumberOf<Value>;
  constexpr long columns = sizeof(Value) / sizeof(Number);
  if (expected.empty())
    expected = std::is_same_v<Value, Vec3> ? "an array of shape (n, 3) of real numbers [m]"
               : columns == 1
                   ? "a row of numbers"
                   : "an array of shape (m, " + std::to_string(columns) + ") of " +
                         (std::is_integral_v<Number> ? "integers (32 bits suffice)" : "real numbers");
  using Shape = std::conditional_t<columns == 1, nb::ndim<1>, nb::shape<-1, columns>>;
  using Array = nb::ndarray<const Number, Shape, nb::c_contig, nb::device::cpu>;
  const auto given = array<Array>(object, name, expected);
  const auto* begin = reinterpret_cast<const Value*>(given.data());
  return {begin, begin + given.shape(0)};
}

/// Values of parameters, {name: (numbers, per_element)}. Throws InvalidArgument naming owner and parameter
/// when the numbers are no row of real numbers.
inline ParameterValues parameter_values_of(nb::handle given, const std::string& owner) {
  ParameterValues result;
  if (given.is_none()) return result;
  for (auto [name, entry] : nb::cast<nb::dict>(given)) {
    const nb::tuple pair = nb::cast<nb::tuple>(entry);
    result[text(name)] = {array_of<double>(pair[0], owner + ": " + text(name), "real numbers"),
                          nb::cast<bool>(pair[1])};
  }
  return result;
}

/// The value of an argument; `expected` says what it must be, where its type does not.
template <typename T>
T read(nb::handle object, const std::string& name, const std::string& expected = "") {
  if constexpr (requires(T optional) { optional.has_value(); }) {
    return read<typename T::value_type>(object, name, expected);
  } else if constexpr (std::is_same_v<T, double>) {
    const FieldValue value = to_field_value(object);
    if (const auto* real = std::get_if<double>(&value)) return *real;
    if (const auto* integer = std::get_if<int64_t>(&value)) return static_cast<double>(*integer);
    throw InvalidArgument(name + " = " + shown(object) + ": must be a number or None");
  } else if constexpr (std::is_same_v<T, Mat3>) {
    const std::string shape = expected.empty() ? "a 3 x 3 rotation matrix" : expected;
    if (nb::hasattr(object, "__len__") && nb::len(object) == 9)
      return {read<std::array<double, 9>>(object, name)};  // row by row
    const auto rows = array_of<Vec3>(object, name, shape);
    if (rows.size() != 3)
      throw InvalidArgument(name + ": got " + std::to_string(rows.size()) + " rows: must be " + shape);
    return transpose(Mat3::from_columns(rows[0], rows[1], rows[2]));
  } else if constexpr (std::is_same_v<T, Vec3>) {
    const auto [x, y, z] = read<std::array<double, 3>>(object, name);
    return {x, y, z};
  } else if constexpr (is_fixed_array<T>) {
    T result{};
    const std::string count =
        result.size() == 3 ? "three numbers" : std::to_string(result.size()) + " numbers";
    const auto numbers = array_of<typename T::value_type>(object, name, count);
    if (numbers.size() != result.size())
      throw InvalidArgument(name + ": got " + shown(object) + ": must be " + count);
    std::copy(numbers.begin(), numbers.end(), result.begin());
    return result;
  } else if constexpr (is_list<T>) {
    using Value = typename T::value_type;
    if constexpr (is_array<T>) return array_of<Value>(object, name, expected);
    T list;
    for (const nb::handle entry : object) list.push_back(read<Value>(entry, name));
    return list;
  } else if constexpr (std::is_enum_v<T>) {
    const auto value = nb::cast<std::string>(object);
    return choice_of<T>(value, name + " = '" + value + "'");
  } else {
    return nb::cast<T>(object);
  }
}

/// A description in the making. Keys that are missing or None leave what the member has.
class Given {
 public:
  /// Of a thing of this kind, with its name if it has one.
  Given(nb::handle entries, const std::string& kind) : entries_(nb::cast<nb::dict>(entries)), owner_(kind) {
    std::string name;
    read("name", name);
    if (!name.empty()) owner_ += " '" + name + "'";
  }
  const std::string& owner() const { return owner_; }
  /// Null where it is missing or None.
  nb::object find(const char* key) const {
    nb::object entry = entries_.contains(key) ? nb::object(entries_[key]) : nb::object();
    return entry.is_none() ? nb::object() : entry;
  }
  /// Throws KeyError where it is missing.
  nb::object operator[](const char* key) const { return entries_[key]; }
  void require(const auto&... keys) const { (static_cast<void>((*this)[keys]), ...); }
  template <typename T>
  void read(const char* key, T& out, const char* expected = "") const {
    if (const nb::object entry = find(key)) out = bindings::read<T>(entry, owner_ + ": " + key, expected);
  }
  void read(const char* key, ParameterValues& out) const {
    if (const nb::object entry = find(key)) out = parameter_values_of(entry, owner_);
  }
  /// What the description declares (sim/scene/description_fields.h), by the names of its members.
  template <typename Description>
  Description description() const {
    Description description;
    for_each_field(description, [&](const char* name, auto& member) { read(name, member); });
    return description;
  }

 private:
  nb::dict entries_;
  std::string owner_;
};

/// What an argument is kept in while its function runs.
template <typename T>
T kept(std::type_identity<T>);
template <typename T>
std::vector<T> kept(std::type_identity<std::span<const T>>);
template <typename T>
using Kept = decltype(kept(std::type_identity<T>()));

template <typename T>
constexpr bool comes_as_array = is_array<Kept<T>> || std::is_same_v<T, Vec3> || std::is_same_v<T, Mat3>;

/// "targets: an (n, 3) array of positions" is the name of an argument and what it must be. With "?" behind
/// the name it may be empty: [] has no columns.
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

/// An argument: the text of an array (see from_array()), or a name; and its default value, if it has one.
struct Argument {
  Argument(const char* of) : text(of) {}  // NOLINT: implicit on purpose
  Argument(const char* of, const auto& value) : text(of), fallback(nb::cast(value)) {}
  nb::arg_v named() const { return {nb::arg(name.c_str()), nb::object(fallback)}; }

  std::string text, name = text.substr(0, text.find_first_of("?:"));
  nb::object fallback;
};

/// How an argument comes, and what it is kept in; the object of a method is not `named`.
template <typename Arg, bool named>
constexpr bool is_read = named && comes_as_array<std::remove_cvref_t<Arg>>;
template <typename Arg, bool named>
using Passed = std::conditional_t<is_read<Arg, named>, nb::object, Arg>;
template <typename Arg, bool named>
using KeptArg = std::conditional_t<is_read<Arg, named>, Kept<std::remove_cvref_t<Arg>>, Arg>;

template <typename Result, typename... Args>
struct Signature {};
template <typename Result, typename... Args>
Signature<Result, Args...> signature_of(Result (*)(Args...));
template <typename Result, typename Class, typename... Args>
Signature<Result, Class&, Args...> signature_of(Result (Class::*)(Args...));
template <typename Result, typename Class, typename... Args>
Signature<Result, const Class&, Args...> signature_of(Result (Class::*)(Args...) const);
template <typename Value, typename Class>
Signature<const Value&, const Class&> signature_of(Value Class::*);
template <typename Result, typename Function, typename... Args>
Signature<Result, Args...> signature_of_call(Result (Function::*)(Args...) const);
template <typename Function>
auto signature_of(Function) -> decltype(signature_of_call(&Function::operator()));

template <typename Function, size_t n, typename Result, typename... Args, size_t... k>
auto reading_arrays(Function function, std::array<std::string, n> texts, Signature<Result, Args...>,
                    std::index_sequence<k...>) {
  constexpr size_t first = sizeof...(Args) - n;  // that is named
  return [=](Passed<Args, (k >= first)>... passed) {
    [[maybe_unused]] const auto keep = [&]<typename Arg>(std::type_identity<Arg>, size_t i,
                                                         auto& value) -> Arg {
      if constexpr (std::is_same_v<std::remove_reference_t<Arg>, std::remove_reference_t<decltype(value)>>)
        return static_cast<Arg>(value);
      else
        return from_array<Arg>(value, texts[i - first]);
    };
    std::tuple<KeptArg<Args, (k >= first)>...> kept{
        keep(std::type_identity<KeptArg<Args, (k >= first)>>(), k, passed)...};
    const auto run = [&](auto&... args) -> Result { return std::invoke(function, args...); };
    if constexpr (std::is_void_v<Result>)
      std::apply(run, kept);
    else
      return to_array(std::apply(run, kept));
  };
}
/// The function with what comes as arrays read by its text, from left to right.
template <size_t n, typename Function>
auto bound(Function function, const std::array<std::string, n>& texts = {}) {
  return []<typename Result, typename... Args>(auto f, const auto& names, Signature<Result, Args...> s) {
    return reading_arrays(f, names, s, std::index_sequence_for<Args...>());
  }(function, texts, decltype(signature_of(function))());
}

/// Binds a function of a module or a method of a class; `scope` is either.
template <typename Function, size_t n>
void def(auto& scope, const char* name, Function function, const Argument (&arguments)[n],
         const char* doc = "") {
  [&]<size_t... k>(std::index_sequence<k...>) {
    scope.def(name, bound<n>(function, {arguments[k].text...}), arguments[k].named()..., doc);
  }(std::make_index_sequence<n>());
}
/// One without arguments.
void def(auto& scope, const char* name, auto function, const auto&... doc) {
  scope.def(name, bound<0>(function), doc...);
}
/// A property that is read only.
void property(auto& c, const char* name, auto function, const auto&... doc) {
  c.def_prop_ro(name, bound<0>(function), nb::rv_policy::automatic, doc...);
}

/// Name of a function or a member in C++, not of a template's: "pin_forces" of &Simulation::pin_forces. GCC
/// and Clang tell it as "[with auto function = &Simulation::pin_forces; ...]".
template <auto function>
std::string own_name() {
  const std::string_view text = __PRETTY_FUNCTION__, mark = "function = ";
  const std::string_view rest = text.substr(text.find(mark) + mark.size());
  const std::string_view name = rest.substr(0, rest.find_first_of("<;]"));
  return std::string(name.substr(name.find_last_of(":&") + 1));
}

// Functions of the core under their own names; what they do is said where they are declared.
template <auto... functions, size_t n>
void def(auto& scope, const Argument (&arguments)[n]) {
  (def(scope, own_name<functions>().c_str(), functions, arguments), ...);
}
template <auto first, auto... functions>
void def(auto& scope) {
  def(scope, own_name<first>().c_str(), first);
  (def(scope, own_name<functions>().c_str(), functions), ...);
}
template <auto... functions>
void property(auto& c) {
  (property(c, own_name<functions>().c_str(), functions), ...);
}

}  // namespace stark::bindings
