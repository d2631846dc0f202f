// Where two convex flat faces lie on each other: the centre of an even pressure there, and how much nearer to
// it than the corners of that area the points are on which it presses.
#pragma once

#include <optional>
#include <span>

#include <stark/geometry/mesh.h>

namespace stark {

struct PressedArea {
  Vec3 centre;        ///< in the plane of the first face, if that is normal to the direction [m]
  double part = 1.0;  ///< mean distance of its points from the centre over that of its corners, at most 1
  double of_smaller = 0.0;  ///< its area over that of the smaller face
  bool is_inside = false;   ///< the first face lies inside of the other, without a corner at its border
};

/// Of the faces with these corners, in any order, seen along a unit normal. None where they do not lie on
/// each other, or one of them is not convex.
std::optional<PressedArea> find_pressed_area(std::span<const Vec3> face, std::span<const Vec3> other,
                                             const Vec3& normal);

}  // namespace stark
