// Fibres of one direction in a stable Neo-Hookean matrix: the anisotropic term of Holzapfel, Gasser and
// Ogden. psi = psi_matrix + k1/(2 k2) (exp(k2 <I4 - 1>^2) - 1), I4 = a . C a with the unit direction a at
// rest: fibres resist tension only, <x> = max(x, 0). [Holzapfel, Gasser, Ogden 2000, eq. 55] Small extension
// along the fibres meets 4 k1 more than the matrix gives.
#include <stark/models/elastic_constants.h>

namespace stark::models {

SolidLaw stable_neo_hookean();

SolidLaw fiber_reinforced() {
  const SolidLaw fibers = define_solid_law(
      "fibers", "fibres that stiffen exponentially in tension",
      [](PotentialBuilder& b, const SolidDeformation& deformation) {
        const Scalar k1 = b.parameter("fiber_stiffness", "Pa", "stiffness k1 of the fibres", non_negative());
        const Scalar k2 = b.parameter("fiber_exponent", "1", "exponent k2 of the fibres", positive());
        const Vec3 stretched =
            deformation.F() * b.direction("fiber_direction", "direction of the fibres at rest");
        const Scalar excess = max(squared_norm(stretched) - 1.0, 0.0);
        return k1 / (2.0 * k2) * (exp(k2 * square(excess)) - 1.0);
      });
  SolidLaw law = sum("fiber_reinforced", {stable_neo_hookean(), fibers});
  law.doc = "stable Neo-Hookean elasticity with fibres of one direction";
  law.isotropic = false;
  return law;
}

}  // namespace stark::models
