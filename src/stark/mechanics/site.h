// A site is a material point or direction and how it moves with the unknowns. Energies are functions of
// sites; only the kinematic map knows that bodies exist.
#pragma once

#include <array>
#include <cstdint>

#include <stark/base/math.h>

namespace stark {

enum class SiteKind : uint8_t {
  Point,           ///< x = point[index]
  RigidPoint,      ///< x = t + R local
  RigidDirection,  ///< x = R local
  Barycentric,     ///< x = sum_k weight_k point[point_k]
  World,           ///< x = local, at rest
};

struct Site {
  SiteKind kind = SiteKind::Point;
  int32_t index = 0;  ///< point, body or first point
  Vec3 local{};       ///< lever [m] or direction in the body frame, position in the world [m]
  std::array<int32_t, 4> points{0, 0, 0, 0};  ///< Barycentric only
  std::array<double, 4> weights{0, 0, 0, 0};  ///< Barycentric only; sum to one
};

}  // namespace stark
