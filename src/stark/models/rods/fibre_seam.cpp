// A fibre in a body turns about itself with the body: E = k (1 - cos(a - a_0)), where a is the angle, about
// the fibre, from its first axis to a vertex of the body next to it. Without it a straight round fibre could
// spin on the spot. [theory eq. 31a]
#include <stark/mechanics/define.h>

namespace stark::models {

namespace {

/// Of the way across at rest: a neighbour that comes nearer to the line of the fibre tells less of its turn.
constexpr double kNearest = 0.2;

/// Way to the neighbour across the fibre, in the axes d1, d2. Points: node, neighbour, d1, d2.
std::array<Scalar, 2> across(PotentialBuilder& b, Vec3 (PotentialBuilder::*p)(int)) {
  const Vec3 way = (b.*p)(1) - (b.*p)(0);
  return {dot(way, (b.*p)(2)), dot(way, (b.*p)(3))};
}

/// 1/sqrt(s), below a limit by its parabola there: the way across has no direction where it vanishes.
Scalar inverse_root(const Scalar& s, const Scalar& limit) {
  const Scalar t = s / limit;
  const Scalar near = (15.0 - 10.0 * t + 3.0 * square(t)) / (8.0 * sqrt(limit));
  return select(s < limit, near, 1.0 / sqrt(max(s, limit)));
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
        const auto now = across(b, &PotentialBuilder::x), rest = across(b, &PotentialBuilder::X);
        const Scalar squared = square(now[0]) + square(now[1]), at_rest = square(rest[0]) + square(rest[1]);
        const Scalar inverse = inverse_root(squared, kNearest * kNearest * at_rest);
        const Scalar inverse_at_rest = 1.0 / sqrt(at_rest);
        // Equal to 1 - cos(a - a_0), without its cancellation.
        return 0.5 * k *
               (square(now[0] * inverse - rest[0] * inverse_at_rest) +
                square(now[1] * inverse - rest[1] * inverse_at_rest));
      });
  definition.translation_invariant = false;  // two of the points are directions
  definition.zero_at_rest = true;
  definition.sample = sample_seam;
  return definition;
}

}  // namespace stark::models
