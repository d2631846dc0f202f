// Descriptor tables: checks, conversions and texts. See settings.h.
#include <stark/base/settings.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <optional>

#include <stark/base/error.h>

namespace stark {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

std::string trimmed(std::string_view text) {
  const size_t first = text.find_first_not_of(" \t\r\n");
  if (first == std::string_view::npos) return {};
  return std::string(text.substr(first, text.find_last_not_of(" \t\r\n") - first + 1));
}

std::optional<double> parse_number(std::string_view text) {
  double value = 0.0;
  if (!text.empty() && text.front() == '+') text.remove_prefix(1);
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

std::optional<bool> parse_flag(const std::string& text) {
  if (text == "true" || text == "True" || text == "on" || text == "yes" || text == "1") return true;
  if (text == "false" || text == "False" || text == "off" || text == "no" || text == "0") return false;
  return std::nullopt;
}

/// "(0, 0, -9.81)", "0 0 -9.81" or "0,0,-9.81".
std::optional<Vec3> parse_vector(std::string text) {
  for (char& c : text)
    if (c == ',' || c == '(' || c == ')' || c == '[' || c == ']') c = ' ';
  Vec3 result;
  size_t at = 0;
  for (int i = 0; i < 3; ++i) {
    const size_t first = text.find_first_not_of(' ', at);
    if (first == std::string::npos) return std::nullopt;
    at = std::min(text.find(' ', first), text.size());
    const auto value = parse_number(std::string_view(text).substr(first, at - first));
    if (!value) return std::nullopt;
    result[i] = *value;
  }
  if (text.find_first_not_of(' ', at) != std::string::npos) return std::nullopt;
  return result;
}

std::string joined(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "'" : ", '") + word + "'";
  return text;
}

}  // namespace

std::string to_text(double value) {
  if (std::isnan(value)) return "nan";
  if (std::isinf(value)) return value > 0 ? "inf" : "-inf";
  char buffer[40];
  return std::string(buffer, std::to_chars(buffer, buffer + sizeof buffer, value).ptr);
}

std::string quantity_text(double value, std::string_view unit) {
  return to_text(value) + (unit.empty() || unit == "1" ? "" : " " + std::string(unit));
}

namespace {

/// `round` of the value in units of its third digit; multiples of whole powers are exact.
template <typename Round>
double of_three_digits(double value, Round&& round) {
  const double digits = value == 0.0 ? 0.0 : 2.0 - std::floor(std::log10(std::fabs(value)));
  const double power = std::pow(10.0, std::fabs(digits));
  if (!std::isfinite(value) || !std::isfinite(power)) return value;
  return digits < 0.0 ? round(value / power) * power : round(value * power) / power;
}

}  // namespace

std::string rough_text(double value, std::string_view unit) {
  return quantity_text(of_three_digits(value, [](double x) { return std::round(x); }), unit);
}

std::string point_text(const Vec3& point) {
  return "(" + rough_text(point.x, "") + ", " + rough_text(point.y, "") + ", " + rough_text(point.z, "") +
         ") m";
}

double rough_below(double value) {
  return of_three_digits(value, [](double x) { return std::floor(x); });
}

std::string to_text(const FieldValue& value) {
  if (const auto* flag = std::get_if<bool>(&value)) return *flag ? "true" : "false";
  if (const auto* integer = std::get_if<int64_t>(&value)) return std::to_string(*integer);
  if (const auto* real = std::get_if<double>(&value)) return to_text(*real);
  if (const auto* v = std::get_if<Vec3>(&value))
    return "(" + to_text(v->x) + ", " + to_text(v->y) + ", " + to_text(v->z) + ")";
  return std::get<std::string>(value);
}

bool FieldRule::holds(double value) const {
  if (std::isnan(value)) return false;
  if (value == kInfinity) return infinity_allowed;
  if (value == -kInfinity) return false;
  return (low_open ? value > low : value >= low) && (high_open ? value < high : value <= high);
}

std::string FieldRule::text() const {
  std::string text = "must be ";
  if (low == -kInfinity && high == kInfinity) {
    text += "finite";
  } else if (high == kInfinity) {
    text += (low_open ? "> " : ">= ") + to_text(low) +
            (infinity_allowed ? " (infinity switches it off)" : " and finite");
  } else {
    text += std::string("in ") + (low_open ? "(" : "[") + to_text(low) + ", " + to_text(high) +
            (high_open ? ")" : "]");
  }
  return text;
}

FieldRule any_value() { return any_number(); }
FieldRule any_number() { return {-kInfinity, kInfinity, true, true, false}; }
FieldRule positive() { return {0.0, kInfinity, true, true, false}; }
FieldRule positive_or_infinity() { return {0.0, kInfinity, true, true, true}; }
FieldRule non_negative() { return {0.0, kInfinity, false, true, false}; }
FieldRule non_negative_or_infinity() { return {0.0, kInfinity, false, true, true}; }
FieldRule at_least(double low) { return {low, kInfinity, false, true, false}; }
FieldRule open_interval(double low, double high) { return {low, high, true, true, false}; }
FieldRule closed_interval(double low, double high) { return {low, high, false, false, false}; }
FieldRule half_open_interval(double low, double high) { return {low, high, false, true, false}; }

std::string Field::rule_text() const {
  switch (type) {
    case FieldType::Flag:
      return "must be true or false";
    case FieldType::Text:
      return "must be text";
    case FieldType::Choice:
      return "must be one of " + joined(choices());
    case FieldType::Vector:
      return "must be three numbers; each " + rule.text();
    case FieldType::Integer:
      return rule.text() + ", a whole number";
    case FieldType::Real:
      break;
  }
  return rule.text();
}

std::string Field::value_text(const FieldValue& value) const {
  std::string text = to_text(value);
  if (type == FieldType::Choice || type == FieldType::Text) text = "'" + text + "'";
  return unit.empty() || unit == "1" ? text : text + " " + unit;
}

FieldTable::FieldTable(std::string name, TableKind kind, std::vector<Field> fields)
    : name_(std::move(name)), kind_(kind), fields_(std::move(fields)) {}

void FieldTable::fail(const std::string& message) const {
  if (kind_ == TableKind::Settings) throw InvalidSetting(message);
  throw InvalidArgument(message);
}

const Field& FieldTable::find(std::string_view name) const {
  for (const Field& field : fields_)
    if (field.name == name) return field;
  std::vector<std::string> known;
  for (const Field& field : fields_) known.push_back(field.name);
  std::string hint = nearest_name_hint(name, known);
  if (hint.empty()) {  // a part of longer names
    std::vector<std::string> longer;
    for (const std::string& other : known)
      if (name.size() > 2 && other.find(name) != std::string::npos) longer.push_back(other);
    if (!longer.empty()) hint = " (did you mean " + joined(longer) + "?)";
  }
  const std::string what = kind_ == TableKind::Settings ? "setting '" + std::string(name) + "'"
                                                        : "parameter '" + std::string(name) + "' of " + name_;
  fail("unknown " + what + (hint.empty() ? "; known are " + joined(known) : hint));
}

FieldValue FieldTable::get(const void* object, std::string_view name) const { return find(name).get(object); }

FieldValue FieldTable::converted(const Field& field, const FieldValue& value, std::string_view owner) const {
  const auto* text = std::get_if<std::string>(&value);
  const std::string word = text ? trimmed(*text) : std::string();
  switch (field.type) {
    case FieldType::Flag:
      if (std::holds_alternative<bool>(value)) return value;
      if (text)
        if (const auto flag = parse_flag(word)) return *flag;
      break;
    case FieldType::Integer: {
      if (const auto* integer = std::get_if<int64_t>(&value))
        if (std::abs(*integer) <= std::numeric_limits<int>::max()) return *integer;
      std::optional<double> number = text ? parse_number(word) : std::nullopt;
      if (const auto* real = std::get_if<double>(&value)) number = *real;
      if (number && std::fabs(*number) <= std::numeric_limits<int>::max() && std::floor(*number) == *number)
        return static_cast<int64_t>(*number);
      break;
    }
    case FieldType::Real:
      if (std::holds_alternative<double>(value)) return value;
      if (const auto* integer = std::get_if<int64_t>(&value)) return static_cast<double>(*integer);
      if (text)
        if (const auto number = parse_number(word)) return *number;
      break;
    case FieldType::Vector:
      if (std::holds_alternative<Vec3>(value)) return value;
      if (text)
        if (const auto vector = parse_vector(word)) return *vector;
      break;
    case FieldType::Choice:
      if (text) return word;
      break;
    case FieldType::Text:
      if (text) return value;
      break;
  }
  refuse(field, value, text ? "'" + *text + "'" : to_text(value), owner);
}

void FieldTable::refuse(const Field& field, const FieldValue& value, const std::string& shown,
                        std::string_view owner) const {
  const auto* text = std::get_if<std::string>(&value);
  const std::string hint =
      field.type == FieldType::Choice && text ? nearest_name_hint(trimmed(*text), field.choices()) : "";
  fail((owner.empty() ? "" : std::string(owner) + ": ") + field.name + " = " + shown + ": " +
       field.rule_text() + hint + ". It is the " + field.doc + "; the default is " +
       field.value_text(field.default_value));
}

void FieldTable::check(const Field& field, const FieldValue& value, std::string_view owner) const {
  bool holds = true;
  if (const auto* real = std::get_if<double>(&value)) holds = field.rule.holds(*real);
  if (const auto* integer = std::get_if<int64_t>(&value))
    holds = field.rule.holds(static_cast<double>(*integer));
  if (const auto* v = std::get_if<Vec3>(&value))
    holds = field.rule.holds(v->x) && field.rule.holds(v->y) && field.rule.holds(v->z);
  if (field.type == FieldType::Choice) {
    const std::vector<std::string> known = field.choices();
    holds = std::ranges::find(known, std::get<std::string>(value)) != known.end();
  }
  if (!holds) refuse(field, value, field.value_text(value), owner);
}

void FieldTable::set(void* object, std::string_view name, const FieldValue& value,
                     std::string_view owner) const {
  const Field& field = find(name);
  const FieldValue accepted = converted(field, value, owner);
  check(field, accepted, owner);
  field.set(object, accepted);
}

void FieldTable::set_from_text(void* object, std::string_view name, std::string_view text) const {
  set(object, name, FieldValue(std::string(text)));
}

void FieldTable::set_all(void* object, const FieldMap& values, std::string_view owner) const {
  std::vector<std::pair<const Field*, FieldValue>> accepted;
  for (const auto& [name, value] : values) {
    const Field& field = find(name);
    accepted.emplace_back(&field, converted(field, value, owner));
    check(field, accepted.back().second, owner);
  }
  for (const auto& [field, value] : accepted) field->set(object, value);
}

void FieldTable::validate(const void* object, std::string_view owner) const {
  for (const Field& field : fields_) check(field, field.get(object), owner);
}

FieldMap FieldTable::to_map(const void* object) const {
  FieldMap map;
  for (const Field& field : fields_) map.emplace_back(field.name, field.get(object));
  return map;
}

FieldMap FieldTable::changed_from_default(const void* object) const {
  FieldMap map;
  for (const Field& field : fields_)
    if (FieldValue value = field.get(object); value != field.default_value)
      map.emplace_back(field.name, std::move(value));
  return map;
}

std::string FieldTable::listing(const void* object) const {
  std::string text;
  for (const Field& field : fields_) text += field.name + " = " + field.value_text(field.get(object)) + "\n";
  return text;
}

std::string FieldTable::markdown() const {
  std::string text = "| name | default | unit | range | meaning |\n|---|---|---|---|---|\n";
  for (const Field& field : fields_) {
    std::string range = field.rule_text();
    if (range.starts_with("must be ")) range = range.substr(8);
    text += "| `" + field.name + "` | " + to_text(field.default_value) + " | " + field.unit + " | " + range +
            " | " + field.doc + " |\n";
  }
  return text;
}

int edit_distance(std::string_view a, std::string_view b) {
  // Optimal string alignment (Damerau-Levenshtein without repeated edits), three rolling rows.
  std::vector<int> before(b.size() + 1), previous(b.size() + 1), current(b.size() + 1);
  for (size_t j = 0; j <= b.size(); ++j) previous[j] = static_cast<int>(j);
  for (size_t i = 1; i <= a.size(); ++i) {
    current[0] = static_cast<int>(i);
    for (size_t j = 1; j <= b.size(); ++j) {
      current[j] = std::min({previous[j] + 1, current[j - 1] + 1, previous[j - 1] + (a[i - 1] != b[j - 1])});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        current[j] = std::min(current[j], before[j - 2] + 1);
    }
    std::swap(before, previous);
    std::swap(previous, current);
  }
  return previous[b.size()];
}

std::string nearest_name_hint(std::string_view name, const std::vector<std::string>& known) {
  const std::string* nearest = nullptr;
  int best = std::numeric_limits<int>::max();
  for (const std::string& candidate : known) {
    // A missing group prefix ("step_tolerance" for "newton.step_tolerance") counts as near as a typing error.
    const size_t dot = candidate.rfind('.');
    int distance = edit_distance(name, candidate);
    if (dot != std::string::npos && name.find('.') == std::string_view::npos)
      distance = std::min(distance, 1 + edit_distance(name, std::string_view(candidate).substr(dot + 1)));
    if (distance < best) best = distance, nearest = &candidate;
  }
  // A name of which no letter is left is not near.
  const int length = static_cast<int>(name.size());
  if (!nearest || best >= length || best > std::max(2, length / 3)) return {};
  return " (did you mean '" + *nearest + "'?)";
}

}  // namespace stark
