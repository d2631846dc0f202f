// Weight of a lumped mass: E = -m g . x.
#include <stark/mechanics/define.h>

namespace stark::models {

PotentialDefinition gravity() {
  PotentialDefinition definition =
      define_potential("gravity", 1, "weight of a lumped mass", [](PotentialBuilder& b) {
        const Scalar mass = b.data("mass", "kg", "lumped mass");
        return -(mass * dot(b.parameter3("gravity", "m/s^2", "acceleration of gravity"), b.x(0)));
      });
  definition.translation_invariant = definition.rotation_invariant = false;
  return definition;
}

}  // namespace stark::models
