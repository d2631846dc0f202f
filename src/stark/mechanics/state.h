// The state of a simulation: everything that changes in time, as plain arrays. A value: copying it is a
// snapshot, assigning it is a rewind, and a rejected step is a copy thrown away (step phase 3 and 6).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
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

/// A field of a state as plain numbers, for files and other languages.
struct StateArray {
  std::string name, unit, meaning;
  bool is_integer = false;      ///< int64_t, else double
  std::vector<size_t> shape{};  ///< {} of a single number, {n}, {n, 3} or {n, 3, 3}
  const void* data = nullptr;
};

/// All fields in their order; the pointers are into the state.
std::vector<StateArray> arrays_of(const State& state);

/// The state of these arrays, in any order; units and meanings are not looked at. Throws InvalidArgument for
/// fields that are missing, unknown or of another type or shape. The numbers may be any:
/// Simulation::set_state() checks them.
State make_state(std::span<const StateArray> arrays);

/// What is wrong with the numbers of a state, whatever the scene: "point_velocity[7] = nan m/s: must be
/// finite". Empty when nothing is.
std::string find_invalid_number(const State& state);

/// Name of the first array that is not as long in both states, empty when all are. Arrays of pairs in contact
/// may differ in length between states, but not within one.
std::string first_length_difference(const State& a, const State& b);

}  // namespace stark
