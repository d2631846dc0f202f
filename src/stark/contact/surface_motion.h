// Surfaces that move along themselves while their body stays where it is: conveyor belts, turntables, tracks.
// Friction measures slip against the material of the surface (step phase 2). [theory eq. 20c]
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <stark/base/math.h>

namespace stark {

/// Velocity of the material of a surface against its body, in the frame of the mesh: v(r) = velocity + spin x
/// (r - center). Its part in the plane of a contact counts.
struct SurfaceMotion {
  Vec3 velocity;  ///< [m/s]
  Vec3 spin;      ///< [rad/s]
  Vec3 center{};  ///< a point of the axis of the spin [m]
};

/// A rigid group with such a motion.
struct MovingSurface {
  int32_t group = 0;
  std::array<int32_t, 3> sites{};  ///< of the group, not on a line
  std::array<Vec3, 3> local{};     ///< where they are in the frame of the mesh [m]
  SurfaceMotion motion{};
};

/// The moving surfaces of a scene.
class MovingSurfaces {
 public:
  MovingSurfaces() = default;
  explicit MovingSurfaces(std::vector<MovingSurface> surfaces);

  bool empty() const { return surfaces_.empty(); }
  /// Velocities [m/s] and spins [rad/s] of a step, surface by surface.
  void set(std::span<const Vec3> velocities, std::span<const Vec3> spins);

  /// Way of the material of a group that is at a point in the world [m] now, with sites at x, against its
  /// body; zero of groups that have none. World axes [m]. The chord of what it has gone for a duration [s],
  /// or, not as a chord, its velocity times the duration.
  Vec3 way(int32_t group, const Vec3& point, std::span<const Vec3> x, double duration, bool is_chord) const;
  /// Turn of the material of a group about a unit normal in a duration, against its body [rad].
  double turn(int32_t group, const Vec3& normal, std::span<const Vec3> x, double duration) const;

 private:
  /// Null of groups that have none.
  const MovingSurface* find(int32_t group) const;

  std::vector<MovingSurface> surfaces_;
  std::vector<int32_t> surface_of_group_;  ///< -1: none
};

}  // namespace stark
