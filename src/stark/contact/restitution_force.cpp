// The force that brings a relative speed u of two rigid bodies to a target within limits: E = sigma/c psi(y),
// y = c (target - u), where psi' is y between the limits and stays there beyond, so that the force along u is
// psi'(y). u = sum_i g_i . (x_i - x_i^ref) / sigma, with the shares g_i of a unit force between the bodies.
// [theory eq. 19b]
#include <stark/mechanics/define.h>

namespace stark::models {

PotentialDefinition restitution() {
  constexpr int kPoints = 6;
  PotentialDefinition definition = define_potential(
      "restitution", kPoints, "force that gives back a part of the speed of an impact",
      [](PotentialBuilder& b) {
        const Scalar target = b.data("target", "m/s", "speed to be reached");
        const Scalar gain = b.data("gain", "N s/m", "force by a unit of speed that is missing");
        const Scalar push = b.data("push", "N", "largest force apart");
        const Scalar pull = b.data("pull", "N", "largest force together");
        const Scalar duration = b.parameter("duration", "s", "over which velocities are displacements");
        Scalar way = 0.0;
        for (int i = 0; i < kPoints; ++i)
          way = way + dot(b.data3("share" + std::to_string(i), "1", "of a unit force"), b.x(i) - b.x_prev(i));
        const Scalar y = gain * (target - way / duration);
        const Scalar above = push * (y - 0.5 * push), below = pull * (-y - 0.5 * pull);
        const Scalar psi = select(y > push, above, select(y < -pull, below, 0.5 * square(y)));
        return duration / gain * psi;
      });
  definition.rotation_invariant = false;     // the direction is frozen
  definition.translation_invariant = false;  // so that nothing needs to be assumed of the shares
  return definition;
}

}  // namespace stark::models
