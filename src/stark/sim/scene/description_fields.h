// The plain members of descriptions by name, for readers and writers of whole descriptions.
#pragma once

#include <array>
#include <string_view>

#include <stark/base/settings.h>
#include <stark/sim/scene/joint.h>
#include <stark/sim/scene/point_set.h>

namespace stark {

template <>
struct EnumNames<PointKind> {
  static constexpr std::array<std::string_view, 6> kNames{"vertices", "point", "direction",
                                                          "embedded", "world", "joined"};
};
template <>
struct EnumNames<FrameDescription::Carrier> {
  static constexpr std::array<std::string_view, 4> kNames{"world", "body", "patch", "node"};
};

/// Calls function(name, member) for each plain member (description_fields.inc) of a description: of a body, a
/// layer, a joint, an actuator, an attachment or an energy, and of the points and frames that these act on.
template <typename Description, typename Function>
void for_each_field(Description& description, Function&& function) {
#define STARK_DESCRIPTION_FIELD(field) \
  if constexpr (requires { description.field; }) function(#field, description.field);
#include <stark/sim/scene/description_fields.inc>
}

}  // namespace stark
