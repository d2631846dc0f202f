// Typed indices of what a scene holds. Valid in copies of the scene and in simulations made from it.
#pragma once

#include <compare>
#include <cstdint>

namespace stark {

/// Index of a body in its scene, in the order of the add_* calls.
struct BodyId {
  int32_t index = -1;
  auto operator<=>(const BodyId&) const = default;
};

/// Index of an energy that was added to a scene.
struct EnergyId {
  int32_t index = -1;
  auto operator<=>(const EnergyId&) const = default;
};

/// Index of an actuator that was added to a scene.
struct ActuatorId {
  int32_t index = -1;
  auto operator<=>(const ActuatorId&) const = default;
};

/// Index of an attachment that was added to a scene.
struct AttachmentId {
  int32_t index = -1;
  auto operator<=>(const AttachmentId&) const = default;
};

/// Index of fibres that were added to a scene.
struct FibresId {
  int32_t index = -1;
  auto operator<=>(const FibresId&) const = default;
};

/// Index of a joint that was added to a scene.
struct JointId {
  int32_t index = -1;
  auto operator<=>(const JointId&) const = default;
};

/// Index of a skin that was added to a scene.
struct SkinId {
  int32_t index = -1;
  auto operator<=>(const SkinId&) const = default;
};

}  // namespace stark
