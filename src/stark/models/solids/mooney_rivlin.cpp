// Mooney-Rivlin elasticity, compressible by a split into change of shape and of volume.
// psi = c10 (J^(-2/3) I1 - 3) + c01 (J^(-4/3) I2 - 3) + K/2 (J - 1)^2 [Holzapfel 2000, sec. 6.5]. Small
// strains: shear modulus 2 (c10 + c01), bulk modulus K. The rest state is free of stress whatever the
// constants. Not defined at J <= 0: such a trial is refused by the line search.
#include <stark/mechanics/define.h>

namespace stark::models {

SolidLaw mooney_rivlin() {
  return define_solid_law(
      "mooney_rivlin", "compressible Mooney-Rivlin elasticity",
      [](PotentialBuilder& b, const SolidDeformation& deformation) {
        const Scalar c10 = b.parameter("c10", "Pa", "coefficient of the first invariant", positive());
        const Scalar c01 = b.parameter("c01", "Pa", "coefficient of the second invariant", non_negative());
        const Scalar K = b.parameter("bulk_modulus", "Pa", "bulk modulus", positive());
        const Mat3 F = deformation.F();
        const Mat3 C = transpose(F) * F;
        const Scalar J = determinant(F), I1 = trace(C);
        const Scalar I2 = 0.5 * (square(I1) - squared_norm(C));
        const Scalar isochoric = pow(J, -2.0 / 3.0);
        return c10 * (isochoric * I1 - 3.0) + c01 * (square(isochoric) * I2 - 3.0) +
               0.5 * K * square(J - 1.0);
      });
}

}  // namespace stark::models
