// The plain members of descriptions by name, for readers and writers of whole descriptions.
#pragma once

namespace stark {

/// Calls function(name, member) for each plain member (description_fields.inc) of a description: of a body, a
/// layer, a joint, an actuator, an attachment or an energy.
template <typename Description, typename Function>
void for_each_field(Description& description, Function&& function) {
#define STARK_DESCRIPTION_FIELD(field) \
  if constexpr (requires { description.field; }) function(#field, description.field);
#include <stark/sim/description_fields.inc>
}

}  // namespace stark
