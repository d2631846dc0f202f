// Smoothed Coulomb friction with lagged normal force and tangent plane: E = mu lambda f0(|u_T|), u_T the
// tangential part of u = sum_i w_i (x_i - x_i^ref) + a, w the lagged weights of the closest points and a the
// deflection of the bristles at the start of the step [docs/theory.md, Friction]. f0(y) = y^2/eps - y^3/(3
// eps^2) + eps/3 below eps = stick_displacement, y above [Li et al. 2020, eq. 17]: C1 with bounded curvature,
// so the force has magnitude mu lambda whenever the contact slips.
//
// f0 is concave in y^2, so the parabola mu lambda/2 (f0'(y_k)/y_k) |u_T|^2 through an iterate k has its force
// and lies above the energy [Hunter and Lange 2004, majorisation]. Newton's method takes its curvature where
// the model without curvature along the slip overshoots the end of sliding again and again.
#include <stark/mechanics/define.h>

namespace stark::models {

namespace {

PotentialDefinition friction_potential(int point_count) {
  PotentialDefinition definition = define_potential(
      "friction_" + std::to_string(point_count), point_count,
      "smoothed Coulomb friction of " + std::to_string(point_count) + " points",
      [point_count](PotentialBuilder& b) {
        const Scalar limit = b.data("limit", "N", "friction coefficient times normal force");
        const Vec3 normal = b.data3("normal", "1", "unit normal of the contact");
        const Scalar eps =
            b.parameter("stick_displacement", "m", "deflection of the bristles at which sliding begins");
        Vec3 u = b.data3("deflection", "m", "deflection of the bristles at the start of the step");
        for (int i = 0; i < point_count; ++i)
          u = u + b.data("weight" + std::to_string(i), "1", "signed weight of the point") *
                      (b.x(i) - b.x_prev(i));
        const Vec3 tangential = u - normal * dot(normal, u);
        const Scalar s = squared_norm(tangential);
        // Below 1e-8 eps the root is held constant: its curvature is unbounded there while the energy's is
        // 2/eps.
        const Scalar y = sqrt(max(s, square(1e-8 * eps)));
        const Scalar stick = s / eps - s * y / (3.0 * square(eps)) + eps / 3.0;
        const Scalar slope = b.data("slope", "1/m", "f0'(y) / y at the iterate");
        const Scalar majorant = b.parameter("majorant", "1", "1 for the parabola above the energy, else 0");
        return limit * select(majorant > 0.5, 0.5 * slope * s, select(s < square(eps), stick, y));
      });
  definition.rotation_invariant = false;  // the tangent plane is frozen
  definition.sample = [point_count](std::mt19937_64& random) {
    std::uniform_real_distribution<double> unit(-1.0, 1.0);
    const auto random_vector = [&] { return stark::Vec3{unit(random), unit(random), unit(random)}; };
    PotentialSample sample;
    for (int i = 0; i < point_count; ++i) {
      sample.X.push_back(random_vector());
      sample.x_prev.push_back(sample.X.back());
      sample.x.push_back(sample.X.back() + random_vector() * 0.5);
      sample.values["weight" + std::to_string(i)] = {i == 0 ? 1.0 : -1.0 / (point_count - 1)};
    }
    const stark::Vec3 n = normalized(random_vector()), a = random_vector() * 0.3;
    sample.values["normal"] = {n.x, n.y, n.z};
    sample.values["deflection"] = {a.x, a.y, a.z};
    sample.values["stick_displacement"] = {0.5};
    sample.values["slope"] = {1.5};
    sample.values["majorant"] = {unit(random) > 0.0 ? 1.0 : 0.0};
    return sample;
  };
  return definition;
}

}  // namespace

PotentialDefinition friction_2() { return friction_potential(2); }
PotentialDefinition friction_3() { return friction_potential(3); }
PotentialDefinition friction_4() { return friction_potential(4); }

}  // namespace stark::models
