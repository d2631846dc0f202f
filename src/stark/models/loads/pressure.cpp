// Pressure inside a closed surface: E = -p V with the enclosed volume V, the sum over outward triangles of
// (x_0 - o) . ((x_1 - o) x (x_2 - o)) / 6. The sum does not depend on the origin o, single triangles do: with
// o near the body their Hessians are of the size of the body, not of its distance from the world's origin.
// The force on a vertex is p/3 times the area vectors of its triangles, at their present size and direction.
// [theory eq. 15a]
#include <stark/mechanics/define.h>

namespace stark::models {

PotentialDefinition pressure() {
  PotentialDefinition definition =
      define_potential("pressure", 3, "pressure inside a closed surface", [](PotentialBuilder& b) {
        const Scalar p = b.parameter("pressure", "Pa", "pressure inside over that outside");
        const Vec3 origin =
            b.parameter3("origin", "m", "any point near the body, the same for all triangles");
        return -p / 6.0 * dot(b.x(0) - origin, cross(b.x(1) - origin, b.x(2) - origin));
      });
  definition.translation_invariant = definition.rotation_invariant = false;  // only the sum is
  return definition;
}

}  // namespace stark::models
