// Kelvin-Voigt damping of a rod: the stiffnesses of the section times a relaxation time resist the rates of
// stretch, curvature and twist, as the incremental potential tau/(2h) sum_i K_i (e_i - e_i^n)^2. [Lang,
// Linn, Arnold 2011, "Multi-body dynamics simulation of geometrically exact Cosserat rods"; theory eq. 31]
#include <stark/mechanics/define.h>

namespace stark::models {

RodLaw rod_damping() {
  return define_rod_law(
      "rod_damping", "viscosity of stretch, bending and twist",
      [](PotentialBuilder& b, const RodDeformation& deformation) {
        const RodStrain now = deformation.strain(), before = deformation.strain_prev();
        const Scalar axial = b.parameter("axial_stiffness", "N", "force for unit stretch", positive());
        const Scalar bending_1 =
            b.parameter("bending_stiffness_1", "N m^2", "bending stiffness about the first axis", positive());
        const Scalar bending_2 = b.parameter("bending_stiffness_2", "N m^2",
                                             "bending stiffness about the second axis", positive());
        const Scalar torsional =
            b.parameter("torsional_stiffness", "N m^2", "torque for a twist of 1 rad/m", positive());
        const Scalar time =
            b.parameter("strain_damping", "s", "relaxation time of the strains", non_negative());
        const Scalar rates = axial * square(now.stretch - before.stretch) +
                             bending_1 * square(now.curvature[0] - before.curvature[0]) +
                             bending_2 * square(now.curvature[1] - before.curvature[1]) +
                             torsional * square(now.twist - before.twist);
        return 0.5 * time / b.time_step() * rates;
      });
}

}  // namespace stark::models
