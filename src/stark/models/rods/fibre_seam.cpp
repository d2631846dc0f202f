// A fibre in a body turns about itself with the body: E = k (1 - cos(a - a_0)), where a is the angle, about
// the fibre, from its first axis to a vertex of the body next to it. Without it a straight round fibre could
// spin on the spot. [theory eq. 31a]
#include <stark/mechanics/define.h>

namespace stark::models {

namespace {

/// Part of the way to the neighbour across the fibre, in the axes d1, d2, as a unit vector. Points: node,
/// neighbour, d1, d2.
std::array<Scalar, 2> bearing(PotentialBuilder& b, Vec3 (PotentialBuilder::*p)(int)) {
  const Vec3 way = (b.*p)(1) - (b.*p)(0);
  const Scalar along_1 = dot(way, (b.*p)(2)), along_2 = dot(way, (b.*p)(3));
  const Scalar inverse = 1.0 / sqrt(square(along_1) + square(along_2));
  return {along_1 * inverse, along_2 * inverse};
}

PotentialSample sample_seam(std::mt19937_64& random) {
  std::uniform_real_distribution<double> small(-0.2, 0.2);
  const auto near = [&](const stark::Vec3& p) {
    return p + stark::Vec3{small(random), small(random), small(random)};
  };
  const auto shape = [&] {
    return std::vector<stark::Vec3>{near({0, 0, 0}), near({0.7, 0.5, 0.3}), near({1, 0, 0}), near({0, 1, 0})};
  };
  return {.X = shape(), .x_prev = shape(), .x = shape(), .values = {}};
}

}  // namespace

PotentialDefinition fibre_seam() {
  PotentialDefinition definition = define_potential(
      "fibre_seam", 4, "turning of a fibre about itself with its body", [](PotentialBuilder& b) {
        const Scalar k = b.data("stiffness", "N m", "torque for a turn of 1 rad");
        const auto now = bearing(b, &PotentialBuilder::x), rest = bearing(b, &PotentialBuilder::X);
        // Equal to 1 - cos(a - a_0), without its cancellation.
        return 0.5 * k * (square(now[0] - rest[0]) + square(now[1] - rest[1]));
      });
  definition.translation_invariant = false;  // two of the points are directions
  definition.zero_at_rest = true;
  definition.sample = sample_seam;
  return definition;
}

}  // namespace stark::models
