// Bending of hinges with rest angles: E = k/2 3 |e|^2 / (A_a + A_b) (theta - theta_0)^2 with the signed fold
// angle. [Grinspun et al. 2003, "Discrete Shells"; normalised such that it agrees with the quadratic model of
// Bergou et al. 2006 for small angles.] Damping: d/(2 h) 3 |e|^2 / (A_a + A_b) (theta - theta_n)^2.
// [theory eq. 13]
#include <stark/models/shells/hinge.h>

namespace stark::models {

PotentialSample sample_hinge(std::mt19937_64& random) {
  std::uniform_real_distribution<double> noise(-0.1, 0.1);
  const auto near = [&](stark::Vec3 p) {
    return p + stark::Vec3{noise(random), noise(random), noise(random)};
  };
  const std::vector<stark::Vec3> flat{{0, 0, 0}, {1, 0, 0}, {0.4, 0.9, 0}, {0.6, -0.8, 0}};
  PotentialSample sample;
  for (const stark::Vec3& p : flat) {
    sample.X.push_back(near(p));
    sample.x_prev.push_back(near(p + stark::Vec3{0, 0, 0.3 * p.y * p.y}));
    sample.x.push_back(near(p + stark::Vec3{0, 0, 0.3 * p.y * p.y}));
  }
  return sample;
}

PotentialDefinition discrete_shell_bending() {
  PotentialDefinition definition =
      define_potential("discrete_shell_bending", 4, "bending of hinges with the rest angles of the mesh",
                       [](PotentialBuilder& b) {
                         const Scalar k = b.parameter("bending_stiffness", "J", "bending stiffness");
                         const HingeGeometry rest = rest_hinge(b);
                         const Scalar theta = fold_angle(hinge_at(b, &PotentialBuilder::x));
                         const Scalar elastic = 0.5 * k * square(theta - fold_angle(rest));
                         return (elastic + viscous_energy(b)) * hinge_weight(b) * squared_norm(rest.edge);
                       });
  definition.zero_at_rest = true;
  definition.sample = sample_hinge;
  return definition;
}

}  // namespace stark::models
