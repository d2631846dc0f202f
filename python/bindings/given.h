// What comes from Python, by the type that it becomes, and descriptions from dictionaries, whose entries are
// read into the members that they are for. Errors name the argument or the entry.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <stark/mechanics/field_values.h>
#include <stark/sim/description_fields.h>

#include "casters.h"

namespace stark::bindings {

/// Values of parameters, {name: (numbers, per_element)}. Throws InvalidArgument naming owner and parameter
/// when the numbers are no row of real numbers.
ParameterValues parameter_values_of(nb::handle given, const std::string& owner);

/// The enumerator of a name; throws InvalidArgument about the subject that lists all of them.
template <typename Choice>
Choice choice_of(const std::string& value, const std::string& subject) {
  const auto& names = EnumNames<Choice>::kNames;
  const std::vector<std::string> known(names.begin(), names.end());
  std::string list;
  for (size_t i = 0; i < known.size(); ++i) {
    if (known[i] == value) return static_cast<Choice>(i);
    list += (i ? ", '" : "'") + known[i] + "'";
  }
  throw InvalidArgument(subject + ": must be one of " + list + nearest_name_hint(value, known));
}

double number_of(nb::handle object, const std::string& name);
Mat3 matrix_of(nb::handle object, const std::string& name, const std::string& expected);

/// Any array or list as one of numbers, or of rows of as many as a value has.
template <typename Value>
std::vector<Value> array_of(nb::handle object, const std::string& name, std::string expected) {
  using Number = typename NumbersOf<Value>::type;
  constexpr long columns = sizeof(Value) / sizeof(Number);
  if (expected.empty())
    expected = std::is_same_v<Value, Vec3> ? "an array of shape (n, 3) of real numbers [m]"
               : columns == 1
                   ? "a row of numbers"
                   : "an array of shape (m, " + std::to_string(columns) + ") of " +
                         (std::is_integral_v<Number> ? "integers (32 bits suffice)" : "real numbers");
  using Array = std::conditional_t<columns == 1, Column<Number>, Rows<Number, columns>>;
  const auto given = array<Array>(object, name, expected);
  const auto* begin = reinterpret_cast<const Value*>(given.data());
  return {begin, begin + given.shape(0)};
}

template <typename T>
constexpr bool is_fixed_array = false;
template <typename Value, size_t n>
constexpr bool is_fixed_array<std::array<Value, n>> = true;
template <typename T>
constexpr bool is_optional = false;
template <typename T>
constexpr bool is_optional<std::optional<T>> = true;

/// The value of an argument; `expected` says what it must be, where its type does not.
template <typename T>
T read(nb::handle object, const std::string& name, const std::string& expected = "") {
  if constexpr (is_optional<T>) {
    return read<typename T::value_type>(object, name, expected);
  } else if constexpr (std::is_same_v<T, double>) {
    return number_of(object, name);
  } else if constexpr (std::is_same_v<T, Mat3>) {
    return matrix_of(object, name, expected.empty() ? "a 3 x 3 rotation matrix" : expected);
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
  /// What the description declares (sim/description_fields.h), by the names of its members.
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

}  // namespace stark::bindings
