// Limit of the strain of solids: psi = k/3 S (1 + hardening S/(S + limit^3)), S = sum_i max(0, e_i - limit)^3
// over the eigenvalues e_i of the Green strain; published without hardening. [theory eq. 14]
#include <stark/models/strain_excess.h>

namespace stark::models {

SolidLaw strain_limit() {
  SolidLaw law = define_solid_law(
      "strain_limit", "limit of the eigenvalues of the Green strain",
      [](PotentialBuilder& b, const SolidDeformation& deformation) {
        const Scalar limit = strain_limit_parameter(b);
        const Mat3 F = deformation.F();
        const Mat3 A = 0.5 * (transpose(F) * F) - (0.5 + limit) * Mat3::identity();
        const Scalar xx = square(A(0, 1)), yy = square(A(1, 2)), zz = square(A(0, 2));
        const Scalar I1 = trace(A);
        const Scalar I2 = A(0, 0) * A(1, 1) - xx + A(1, 1) * A(2, 2) - yy + A(2, 2) * A(0, 0) - zz;
        const Scalar I3 = A(0, 0) * A(1, 1) * A(2, 2) + 2.0 * A(0, 1) * A(1, 2) * A(0, 2) - A(0, 0) * yy -
                          A(1, 1) * zz - A(2, 2) * xx;
        return strain_limit_density(b, limit, positive_cubes(I1, I2, I3));
      });
  law.one_sided = true;
  law.sample = [](std::mt19937_64& random) {
    std::uniform_real_distribution<double> limit(0.002, 0.02);
    return std::map<std::string, std::vector<double>>{{"strain_limit", {limit(random)}}};
  };
  return law;
}

}  // namespace stark::models
