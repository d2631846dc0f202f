// Quadratic bending of a flat rest shape: E = k/2 3/(A_a + A_b) |sum_i K_i x_i|^2 with cotangent weights K of
// the rest shape. [Bergou et al. 2006, "A Quadratic Bending Model for Inextensible Surfaces"; the paper's
// sec. III-C, IV-A with k the stiffness parameter k_b.] The Hessian is constant. Damping: that of
// discrete_shell_bending, of fold angles. The same form of the motion within the step would be quadratic,
// too, but brake folds that turn. [theory eq. 12, 13]
#include <stark/models/shells/hinge.h>

namespace stark::models {

namespace {

Scalar cotangent(const Vec3& a, const Vec3& b) { return dot(a, b) / norm(cross(a, b)); }

Scalar quadratic_energy(PotentialBuilder& b) {
  const Scalar k = b.parameter("bending_stiffness", "J", "bending stiffness");
  const Vec3 e = b.X(1) - b.X(0), a0 = b.X(2) - b.X(0), b0 = b.X(3) - b.X(0);
  const Vec3 a1 = b.X(2) - b.X(1), b1 = b.X(3) - b.X(1);
  const Scalar a_at_0 = cotangent(e, a0), b_at_0 = cotangent(e, b0);
  const Scalar a_at_1 = cotangent(-e, a1), b_at_1 = cotangent(-e, b1);
  const Scalar weights[4] = {a_at_1 + b_at_1, a_at_0 + b_at_0, -(a_at_0 + a_at_1), -(b_at_0 + b_at_1)};
  Vec3 curvature = weights[0] * b.x(0);
  for (int i = 1; i < 4; ++i) curvature = curvature + weights[i] * b.x(i);
  return 0.5 * k * squared_norm(curvature);
}

}  // namespace

PotentialDefinition flat_bending() {
  PotentialDefinition definition =
      define_potential("flat_bending", 4, "quadratic bending of a flat rest shape",
                       [](PotentialBuilder& b) { return quadratic_energy(b) * hinge_weight(b); });
  definition.sample = sample_hinge;
  return definition;
}

PotentialDefinition damped_flat_bending() {
  PotentialDefinition definition =
      define_potential("damped_flat_bending", 4, "quadratic bending of a flat rest shape, fold angles damped",
                       [](PotentialBuilder& b) {
                         const Scalar viscous = viscous_energy(b) * squared_norm(rest_hinge(b).edge);
                         return (quadratic_energy(b) + viscous) * hinge_weight(b);
                       });
  definition.sample = sample_hinge;
  return definition;
}

}  // namespace stark::models
