// Descriptions from dictionaries of Python: each entry is read into the member that it is for, by its type.
#pragma once

#include <nanobind/stl/map.h>
#include <nanobind/stl/string.h>

#include <optional>
#include <string>
#include <vector>

#include <stark/mechanics/field_values.h>

#include "casters.h"
#include "described.h"

namespace stark::bindings {

/// Values of parameters, {name: (numbers, per_element)}. Throws InvalidArgument naming owner and parameter
/// when the numbers are no row of real numbers.
ParameterValues parameter_values_of(nb::handle given, const std::string& owner);

/// The enumerator of a name; throws InvalidArgument that lists all of them.
template <typename Choice>
Choice choice_of(const std::string& value, const std::string& name) {
  const auto& names = EnumNames<Choice>::kNames;
  const std::vector<std::string> known(names.begin(), names.end());
  std::string list;
  for (size_t i = 0; i < known.size(); ++i) {
    if (known[i] == value) return static_cast<Choice>(i);
    list += (i ? ", '" : "'") + known[i] + "'";
  }
  throw InvalidArgument(name + " = '" + value + "': must be one of " + list +
                        nearest_name_hint(value, known));
}

double number_of(nb::handle object, const std::string& name);

/// What an entry becomes, by the type of the member; `name` is for messages.
template <typename T>
struct Reader {
  static T read(nb::handle object, const std::string& name) {
    if constexpr (std::is_enum_v<T>) return choice_of<T>(nb::cast<std::string>(object), name);
    return nb::cast<T>(object);
  }
};
template <>
struct Reader<double> {
  static double read(nb::handle object, const std::string& name) { return number_of(object, name); }
};
template <>
struct Reader<Vec3> {
  static Vec3 read(nb::handle object, const std::string& name) { return vector_of(object, name); }
};
template <>
struct Reader<std::array<double, 3>> {
  static std::array<double, 3> read(nb::handle object, const std::string& name) {
    const Vec3 v = vector_of(object, name);
    return {v.x, v.y, v.z};
  }
};
template <>
struct Reader<Mat3> {
  static Mat3 read(nb::handle object, const std::string& name) { return matrix_of(object, name); }
};
template <>
struct Reader<std::vector<Vec3>> {
  static std::vector<Vec3> read(nb::handle object, const std::string& name) {
    return points_of(object, name);
  }
};
template <size_t n>
struct Reader<std::vector<std::array<int32_t, n>>> {
  static std::vector<std::array<int32_t, n>> read(nb::handle object, const std::string& name) {
    return rows_of<std::array<int32_t, n>, int32_t, n>(
        object, name, "an array of shape (m, " + std::to_string(n) + ") of integers (32 bits suffice)");
  }
};
template <typename T>
struct Reader<std::optional<T>> {
  static std::optional<T> read(nb::handle object, const std::string& name) {
    return Reader<T>::read(object, name);
  }
};

/// A description in the making. Keys that are missing or None leave what the member has.
class Given {
 public:
  Given(const nb::dict& entries, std::string owner) : entries_(entries), owner_(std::move(owner)) {}
  const std::string& owner() const { return owner_; }
  /// Null where it is missing or None.
  nb::object find(const char* key) const {
    nb::object entry = entries_.contains(key) ? nb::object(entries_[key]) : nb::object();
    return entry.is_none() ? nb::object() : entry;
  }
  template <typename T>
  void read(const char* key, T& out) const {
    if (const nb::object entry = find(key)) out = Reader<T>::read(entry, owner_ + ": " + key);
  }
  void read(const char* key, ParameterValues& out) const {
    if (const nb::object entry = find(key)) out = parameter_values_of(entry, owner_);
  }

 private:
  const nb::dict& entries_;
  std::string owner_;
};

/// Of a thing of this kind with a name.
inline Given given_of(const nb::dict& given, const char* kind) {
  const auto name = nb::cast<std::string>(given["name"]);
  return {given, std::string(kind) + (name.empty() ? "" : " '" + name + "'")};
}

/// Rows {name, unit, rule, doc, width} of what a potential asks for.
nb::list describe(const std::vector<ParameterDeclaration>& declarations);

}  // namespace stark::bindings
