// What sheets and rods are at rest in: their mesh, or flat and straight. Colours of bodies and layers.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include <stark/base/settings.h>

namespace stark {

/// Rest angles of cloth: flat everywhere, or those of the rest mesh.
enum class RestAngles : uint8_t { Flat, Mesh };
/// Rest shape of a rod: that of its points, or straight and without twist.
enum class RestShape : uint8_t { Mesh, Straight };

template <>
struct EnumNames<RestShape> {
  static constexpr std::array<std::string_view, 2> kNames{"mesh", "straight"};
};
template <>
struct EnumNames<RestAngles> {
  static constexpr std::array<std::string_view, 2> kNames{"flat", "mesh"};
};

/// Red, green, blue in [0, 1]; for pictures only.
using Color = std::array<double, 3>;

}  // namespace stark
