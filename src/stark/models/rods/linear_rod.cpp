// Kirchhoff's rod with stretch: psi = (EA (stretch - 1)^2 + B1 k1^2 + B2 k2^2 + C tau^2) / 2 with changes of
// curvature k and twist tau. [Antman 2005, "Nonlinear Problems of Elasticity", ch. VIII; theory eq. 30]
#include <stark/mechanics/define.h>

namespace stark::models {

RodLaw linear_rod() {
  return define_rod_law(
      "linear_rod", "quadratic energy of stretch, bending and twist",
      [](PotentialBuilder& b, const RodDeformation& deformation) {
        const RodStrain s = deformation.strain();
        const Scalar axial = b.parameter("axial_stiffness", "N", "force for unit stretch", positive());
        const Scalar bending_1 =
            b.parameter("bending_stiffness_1", "N m^2", "bending stiffness about the first axis", positive());
        const Scalar bending_2 = b.parameter("bending_stiffness_2", "N m^2",
                                             "bending stiffness about the second axis", positive());
        const Scalar torsional =
            b.parameter("torsional_stiffness", "N m^2", "torque for a twist of 1 rad/m", positive());
        return 0.5 * (axial * square(s.stretch - 1.0) + bending_1 * square(s.curvature[0]) +
                      bending_2 * square(s.curvature[1]) + torsional * square(s.twist));
      });
}

}  // namespace stark::models
