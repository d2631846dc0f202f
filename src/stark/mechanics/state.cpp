#include <stark/mechanics/state.h>

#include <cstring>

#include <stark/base/hash.h>

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

}  // namespace stark
