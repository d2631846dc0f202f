// The state of a simulation: everything that changes in time, as plain arrays. A value: copying it is a
// snapshot, assigning it is a rewind, and a rejected step is a copy thrown away (step phase 3 and 6).
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <stark/base/math.h>

namespace stark {

struct State {
#define STARK_STATE_FIELD(type, name, unit, meaning) type name{};
#include <stark/mechanics/state_fields.inc>
#undef STARK_STATE_FIELD

  /// Equal in every bit: 0 and -0 differ, as they do in the hash.
  bool operator==(const State& other) const;

  /// 64-bit hash of all fields, bit for bit; equal states have equal hashes on every machine.
  uint64_t hash() const;
};

/// Name of the first field in which two states differ, empty when they are equal in every bit.
std::string first_difference(const State& a, const State& b);

}  // namespace stark
