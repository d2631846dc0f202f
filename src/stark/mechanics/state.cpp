#include <stark/mechanics/state.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string_view>
#include <type_traits>
#include <utility>

#include <stark/base/error.h>
#include <stark/base/hash.h>
#include <stark/base/settings.h>

namespace stark {

namespace {

template <typename T>
void append(Hash64& hash, const T& value) {
  hash.append_bytes(&value, sizeof(T));
}

template <typename T>
void append(Hash64& hash, const std::vector<T>& values) {
  const uint64_t size = values.size();
  hash.append_bytes(&size, sizeof(size));
  hash.append_bytes(values.data(), sizeof(T) * values.size());
}

template <typename T>
bool same_bits(const T& a, const T& b) {
  return std::memcmp(&a, &b, sizeof(T)) == 0;
}

template <typename T>
bool same_bits(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), sizeof(T) * a.size()) == 0);
}

}  // namespace

bool State::operator==(const State& other) const { return first_difference(*this, other).empty(); }

uint64_t State::hash() const {
  Hash64 hash;
#define STARK_STATE_FIELD(type, name, unit, meaning) append(hash, name);
#define STARK_OPTIONAL_STATE_FIELD(type, name, unit, meaning) \
  if (!name.empty()) append(hash, name);
#include <stark/mechanics/state_fields.inc>
#undef STARK_STATE_FIELD
  return hash.value();
}

std::string first_difference(const State& a, const State& b) {
#define STARK_STATE_FIELD(type, name, unit, meaning) \
  if (!same_bits(a.name, b.name)) return #name;
#include <stark/mechanics/state_fields.inc>
#undef STARK_STATE_FIELD
  return {};
}

namespace {

// Numbers of one element of a field, and its shape: 1, 3 or 3 x 3.
template <typename T>
constexpr size_t kWidth = sizeof(T) / sizeof(double);
template <typename T>
std::vector<size_t> element_shape() {
  if constexpr (kWidth<T> == 1) return {};
  if constexpr (kWidth<T> == 3) return {3};
  return {3, 3};
}

template <typename T>
void describe(const T& value, StateArray& out) {
  out.is_integer = std::is_integral_v<T>;
  out.data = &value;
}
template <typename T>
void describe(const std::vector<T>& values, StateArray& out) {
  out.is_integer = std::is_integral_v<T>;
  out.shape = element_shape<T>();
  out.shape.insert(out.shape.begin(), values.size());
  out.data = values.data();
}

bool matches(const StateArray& field, const StateArray& given) {
  // The number of elements is free; everything else is the field's.
  std::vector<size_t> shape = given.shape;
  if (!field.shape.empty() && !shape.empty()) shape[0] = field.shape[0];
  return shape == field.shape && given.is_integer == field.is_integer;
}

template <typename T>
void read(const StateArray& given, T& out) {
  std::memcpy(&out, given.data, sizeof(T));
}
template <typename T>
void read(const StateArray& given, std::vector<T>& out) {
  out.resize(given.shape[0]);
  if (!out.empty()) std::memcpy(out.data(), given.data, sizeof(T) * out.size());
}

const StateArray& find(std::span<const StateArray> arrays, const std::string& name) {
  for (const StateArray& array : arrays)
    if (array.name == name) return array;
  throw InvalidArgument("state: the field '" + name + "' is missing: must have all fields of stark::State");
}

bool has(std::span<const StateArray> arrays, const std::string& name) {
  return std::ranges::any_of(arrays, [&](const StateArray& array) { return array.name == name; });
}

bool is_optional(const std::string& field) {
#define STARK_STATE_FIELD(type, name, unit, meaning)
#define STARK_OPTIONAL_STATE_FIELD(type, name, unit, meaning) \
  if (field == #name) return true;
#include <stark/mechanics/state_fields.inc>
#undef STARK_STATE_FIELD
  return false;
}

struct NumberRule {
  const char* text;
  bool (*holds)(double);
};

NumberRule rule_of(std::string_view field) {
  if (field == "actuator_enabled") return {"must be 0 or 1", [](double v) { return v == 0.0 || v == 1.0; }};
  if (field == "restitution_due") return {"must be 0 or 1", [](double v) { return v == 0.0 || v == 1.0; }};
  if (field == "restitution_stiffness")
    return {"must be > 0 and at most 1", [](double v) { return v > 0.0 && v <= 1.0; }};
  if (field == "attachment_held" || field == "joint_enabled")
    return {"must be 1, 0 or -1", [](double v) { return v == 0.0 || v == 1.0 || v == -1.0; }};
  // Infinity switches caps off; memories are what users' formulas make of them.
  if (field == "actuator_value" || field == "actuator_memory")
    return {"must be a number", [](double v) { return !std::isnan(v); }};
  if (field == "time_step" || field == "mark_step")
    return {"must be > 0 and finite", [](double v) { return v > 0.0 && std::isfinite(v); }};
  if (field == "time" || field == "mark_origin" || field == "previous_time_step")
    return {"must be >= 0 and finite", [](double v) { return v >= 0.0 && std::isfinite(v); }};
  return {"must be finite", [](double v) { return std::isfinite(v); }};
}

template <typename T>
size_t length(const T&) {
  return 1;
}
template <typename T>
size_t length(const std::vector<T>& values) {
  return values.size();
}

std::string invalid_number(int64_t, const char*, const char*) { return {}; }
std::string invalid_number(const std::vector<int64_t>&, const char*, const char*) { return {}; }
std::string invalid_number(double value, const char* name, const char* unit) {
  const NumberRule rule = rule_of(name);
  return rule.holds(value) ? std::string{}
                           : std::string(name) + " = " + quantity_text(value, unit) + ": " + rule.text;
}
template <typename T>
std::string invalid_number(const std::vector<T>& values, const char* name, const char* unit) {
  if (values.empty()) return {};
  const NumberRule rule = rule_of(name);
  const auto* numbers = reinterpret_cast<const double*>(values.data());
  for (size_t k = 0; k < values.size() * kWidth<T>; ++k)
    if (!rule.holds(numbers[k]))
      return std::string(name) + "[" + std::to_string(k / kWidth<T>) +
             "] = " + quantity_text(numbers[k], unit) + ": " + rule.text;
  return {};
}

/// Rounding of many steps stays far below this, anything but a rotation far above.
constexpr double kOrthonormal = 1e-5;

/// Position of the first matrix that is no rotation, -1 if all are.
int64_t find_no_rotation(const std::vector<Mat3>& matrices) {
  for (size_t k = 0; k < matrices.size(); ++k) {
    const Mat3 error = transpose(matrices[k]) * matrices[k] - Mat3::identity();
    for (const double entry : error.m)
      if (!(std::fabs(entry) <= kOrthonormal)) return static_cast<int64_t>(k);
    if (!(determinant(matrices[k]) > 0.0)) return static_cast<int64_t>(k);
  }
  return -1;
}

}  // namespace

std::vector<StateArray> arrays_of(const State& state) {
  std::vector<StateArray> arrays;
#define STARK_STATE_FIELD(type, name, unit, meaning) \
  arrays.push_back({#name, unit, meaning});          \
  describe(state.name, arrays.back());
#include <stark/mechanics/state_fields.inc>
#undef STARK_STATE_FIELD
  return arrays;
}

State make_state(std::span<const StateArray> arrays) {
  State state;
  std::vector<std::string> names;
  for (const StateArray& field : arrays_of(state)) {
    names.push_back(field.name);
    if (is_optional(field.name) && !has(arrays, field.name)) continue;
    const StateArray& given = find(arrays, field.name);
    if (!matches(field, given))
      throw InvalidArgument("state: the field '" + field.name + "' has " +
                            (given.is_integer ? "integers" : "real numbers") + " in " +
                            std::to_string(given.shape.size()) + " dimensions: must have " +
                            (field.is_integer ? "integers" : "real numbers") + " in " +
                            std::to_string(field.shape.size()) + ", with the last ones of 3");
  }
  for (const StateArray& given : arrays)
    if (std::find(names.begin(), names.end(), given.name) == names.end())
      throw InvalidArgument("state: unknown field '" + given.name + "'" +
                            nearest_name_hint(given.name, names) + ": must be a field of stark::State");
#define STARK_STATE_FIELD(type, name, unit, meaning) read(find(arrays, #name), state.name);
#define STARK_OPTIONAL_STATE_FIELD(type, name, unit, meaning) \
  if (has(arrays, #name)) read(find(arrays, #name), state.name);
#include <stark/mechanics/state_fields.inc>
#undef STARK_STATE_FIELD
  return state;
}

std::string find_invalid_number(const State& state) {
  for (const auto& [name, count] :
       {std::pair{"step_count", state.step_count}, std::pair{"mark_count", state.mark_count}})
    if (count < 0) return std::string(name) + " = " + std::to_string(count) + ": must be >= 0";
  // Field by field without lists of them: states are set between the steps of small scenes.
#define STARK_STATE_FIELD(type, name, unit, meaning) \
  if (std::string what = invalid_number(state.name, #name, unit); !what.empty()) return what;
#include <stark/mechanics/state_fields.inc>
#undef STARK_STATE_FIELD
  for (const auto& [name, matrices] : {std::pair{"body_rotation", &state.body_rotation},
                                       {"script_rotation", &state.script_rotation},
                                       {"previous_body_rotation", &state.previous_body_rotation}})
    if (const int64_t k = find_no_rotation(*matrices); k >= 0)
      return std::string(name) + "[" + std::to_string(k) + "]: must be a rotation";
  return {};
}

std::string first_length_difference(const State& a, const State& b) {
  if (a.friction_deflection.size() != a.friction_pair.size()) return "friction_deflection";
  if (a.friction_force.size() != a.friction_pair.size()) return "friction_force";
  if (a.contact_factor.size() != a.contact_bodies.size()) return "contact_factor";
  if (const size_t n = a.contact_trial.size(); n != 0 && n != a.contact_bodies.size()) return "contact_trial";
  if (a.contact_trial_age.size() != a.contact_trial.size()) return "contact_trial_age";
  if (a.contact_close_distance.size() != a.contact_close_bodies.size()) return "contact_close_distance";
#define STARK_STATE_FIELD(type, name, unit, meaning)                                                     \
  if (constexpr std::string_view field = #name; field.starts_with("restitution_")) {                     \
    if (length(a.name) != a.restitution_bodies.size()) return #name;                                     \
  } else if (!field.starts_with("friction_") && !field.starts_with("contact_")) { /* those by contact */ \
    if (length(a.name) != length(b.name)) return #name;                                                  \
  }
#include <stark/mechanics/state_fields.inc>
#undef STARK_STATE_FIELD
  return {};
}

}  // namespace stark
