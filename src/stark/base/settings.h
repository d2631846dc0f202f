// Descriptor tables: every setting and every material parameter is declared once, beside the plain struct
// that holds it, with name, unit, rule and meaning. Validation, setting by name from text, maps for files,
// printing and the reference tables of the documentation all derive from that one declaration. Used before a
// simulation, never inside.
//
//   struct NewtonSettings {
//     double step_tolerance = 1e-3;
//     static const FieldTable& fields();
//   };
//   const FieldTable& NewtonSettings::fields() {
//     static const FieldTable table = describe<NewtonSettings>("newton", {
//         field(&NewtonSettings::step_tolerance, "step_tolerance", "m/s", non_negative(), "largest motion
//         ...")});
//     return table;
//   }
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include <stark/base/math.h>
#include <stark/base/reading.h>

namespace stark {

/// A value of a field: flag, integer, real number, text (also the enumerators of choices) or 3-vector.
using FieldValue = std::variant<bool, int64_t, double, std::string, Vec3>;
using FieldMap = std::vector<std::pair<std::string, FieldValue>>;

/// "0.001", "true", "automatic", "(0, 0, -9.81)": shortest text that reads back to the same value.
std::string to_text(const FieldValue& value);
std::string to_text(double value);
/// "-1 N/m", and the bare number for unit "1" or none.
std::string quantity_text(double value, std::string_view unit);
/// The same of a measured value, rounded to three digits: "0.000599 m". Not for what is told beside a bound
/// that it may miss by less.
std::string rough_text(double value, std::string_view unit);
/// "(0, 0.05, 1.05) m", rounded to three digits.
std::string point_text(const Vec3& point);
/// The largest value of three digits that is not above a positive one: for "use at most", and for bounds.
double rough_below(double value);

/// The range a number must lie in. For vectors it holds for each component.
struct FieldRule {
  double low, high;
  bool low_open, high_open;
  bool infinity_allowed;  ///< +infinity means "off"
  bool holds(double value) const;
  std::string text() const;  ///< "must be > 0"
};
FieldRule any_number();
FieldRule any_value();  ///< of flags, choices and texts, which have no range
FieldRule positive();
FieldRule positive_or_infinity();
FieldRule non_negative();
FieldRule non_negative_or_infinity();
FieldRule at_least(double low);
FieldRule open_interval(double low, double high);
FieldRule closed_interval(double low, double high);
FieldRule half_open_interval(double low, double high);  ///< [low, high)

/// The rule of a text that must be one of the names that are known when it is checked.
struct NameRule {
  std::vector<std::string> (*known)();
};
inline NameRule one_of(std::vector<std::string> (*known)()) { return {known}; }

/// Names of the enumerators of E, in the order of their values 0, 1, ...: specialise with
/// `static constexpr std::array<std::string_view, n> kNames`.
template <typename E>
struct EnumNames;

template <typename E>
std::string to_string(E value)
  requires std::is_enum_v<E>
{
  return std::string(EnumNames<E>::kNames.at(static_cast<size_t>(value)));
}

enum class FieldType : uint8_t { Flag, Integer, Real, Text, Choice, Vector };

/// One declared field of a struct, type-erased.
struct Field {
  std::string name;  ///< dotted path inside the table, e.g. "newton.step_tolerance"
  std::string unit;  ///< SI; "1" for pure numbers, empty for flags and choices
  std::string doc;
  FieldType type = FieldType::Real;
  FieldRule rule = any_number();
  std::function<std::vector<std::string>()> choices;  ///< of FieldType::Choice
  FieldValue default_value;
  std::function<FieldValue(const void*)> get;
  std::function<void(void*, const FieldValue&)> set;  ///< the value has the type that get() returns

  std::string rule_text() const;
  std::string value_text(const FieldValue& value) const;  ///< with unit: "-1 m/s"
  std::vector<std::string> choice_names() const { return choices ? choices() : std::vector<std::string>(); }
};
template <>
struct Readings<Field> {
  static constexpr std::tuple kAll{reading<&Field::name>("name"),
                                   reading<&Field::unit>("unit"),
                                   reading<&Field::default_value>("default"),
                                   reading<&Field::rule_text>("rule"),
                                   reading<&Field::choice_names>("choices"),
                                   reading<&Field::doc>("doc")};
};

/// Whether a table is a set of settings (violations throw InvalidSetting) or of parameters of an object of
/// the scene (InvalidArgument).
enum class TableKind : uint8_t { Settings, Parameters };

class FieldTable {
 public:
  FieldTable(std::string name, TableKind kind, std::vector<Field> fields);

  const std::string& name() const { return name_; }
  const std::vector<Field>& fields() const { return fields_; }
  TableKind kind() const { return kind_; }

  /// Throws for an unknown name, with the nearest known one as a hint.
  const Field& find(std::string_view name) const;

  FieldValue get(const void* object, std::string_view name) const;
  /// Converts (integers to reals, whole reals to integers, text to anything), checks the rule, assigns.
  /// `owner` names the object in messages: "material 'felt'"; may be empty.
  void set(void* object, std::string_view name, const FieldValue& value, std::string_view owner = {}) const;
  void set_from_text(void* object, std::string_view name, std::string_view text) const;
  /// Assigns all entries, or none when one of them is unknown or out of range.
  void set_all(void* object, const FieldMap& values, std::string_view owner = {}) const;

  /// Checks every field of the object against its rule.
  void validate(const void* object, std::string_view owner = {}) const;

  FieldMap to_map(const void* object) const;
  FieldMap changed_from_default(const void* object) const;
  std::string listing(const void* object) const;  ///< one "name = value unit" a line
  std::string markdown() const;                   ///< table: name, default, unit, range, meaning

  [[noreturn]] void fail(const std::string& message) const;

 private:
  FieldValue converted(const Field& field, const FieldValue& value, std::string_view owner) const;
  void check(const Field& field, const FieldValue& value, std::string_view owner) const;
  [[noreturn]] void refuse(const Field& field, const FieldValue& value, const std::string& shown,
                           std::string_view owner) const;

  std::string name_;
  TableKind kind_;
  std::vector<Field> fields_;
};

/// Number of insertions, deletions, substitutions and swaps of neighbours that turn a into b.
int edit_distance(std::string_view a, std::string_view b);
/// " (did you mean 'x'?)" for the nearest of the known names, or "" when none is near.
std::string nearest_name_hint(std::string_view name, const std::vector<std::string>& known);

namespace detail {

template <typename T>
FieldValue to_field_value(const T& value) {
  if constexpr (std::is_enum_v<T>) {
    return to_string(value);
  } else if constexpr (std::is_same_v<T, bool>) {
    return value;
  } else if constexpr (std::is_integral_v<T>) {
    return static_cast<int64_t>(value);
  } else {
    return value;
  }
}

template <typename T>
T from_field_value(const FieldValue& value) {
  if constexpr (std::is_enum_v<T>) {
    const auto& names = EnumNames<T>::kNames;
    for (size_t i = 0; i < names.size(); ++i)
      if (names[i] == std::get<std::string>(value)) return static_cast<T>(i);
    return T{};
  } else if constexpr (std::is_same_v<T, bool>) {
    return std::get<bool>(value);
  } else if constexpr (std::is_integral_v<T>) {
    return static_cast<T>(std::get<int64_t>(value));
  } else {
    return std::get<T>(value);
  }
}

template <typename T>
constexpr FieldType field_type() {
  if constexpr (std::is_enum_v<T>)
    return FieldType::Choice;
  else if constexpr (std::is_same_v<T, bool>)
    return FieldType::Flag;
  else if constexpr (std::is_integral_v<T>)
    return FieldType::Integer;
  else if constexpr (std::is_same_v<T, double>)
    return FieldType::Real;
  else if constexpr (std::is_same_v<T, Vec3>)
    return FieldType::Vector;
  else
    return FieldType::Text;
}

}  // namespace detail

/// Declares a member: field(&S::mass, "mass", "kg", positive(), "mass of the body").
template <typename S, typename T>
Field field(T S::* member, std::string name, std::string unit, FieldRule rule, std::string doc) {
  Field f;
  f.name = std::move(name);
  f.unit = std::move(unit);
  f.doc = std::move(doc);
  f.rule = rule;
  f.type = detail::field_type<T>();
  if constexpr (std::is_enum_v<T>)
    f.choices = [] {
      return std::vector<std::string>(EnumNames<T>::kNames.begin(), EnumNames<T>::kNames.end());
    };
  f.get = [member](const void* object) {
    return detail::to_field_value(static_cast<const S*>(object)->*member);
  };
  f.set = [member](void* object, const FieldValue& value) {
    static_cast<S*>(object)->*member = detail::from_field_value<T>(value);
  };
  const S defaults{};
  f.default_value = f.get(&defaults);
  return f;
}

/// Declares a flag, a choice or a text, which have no range.
template <typename S, typename T>
Field field(T S::* member, std::string name, std::string doc) {
  return field(member, std::move(name), "", any_value(), std::move(doc));
}

/// Declares a text that must be one of known names.
template <typename S>
Field field(std::string S::* member, std::string name, const std::string& /*unit*/, NameRule rule,
            std::string doc) {
  Field f = field(member, std::move(name), std::move(doc));
  f.type = FieldType::Choice;
  f.choices = rule.known;
  return f;
}

/// The fields of a nested struct under "prefix.": group(&Settings::newton, "newton",
/// NewtonSettings::fields()).
template <typename S, typename T>
std::vector<Field> group(T S::* member, const std::string& prefix, const FieldTable& table) {
  std::vector<Field> fields = table.fields();
  for (Field& f : fields) {
    f.name = prefix + "." + f.name;
    f.get = [member, get = f.get](const void* object) {
      return get(&(static_cast<const S*>(object)->*member));
    };
    f.set = [member, set = f.set](void* object, const FieldValue& value) {
      set(&(static_cast<S*>(object)->*member), value);
    };
  }
  return fields;
}

}  // namespace stark
