// Smoothed Coulomb friction with lagged normal force and tangent plane: E = mu lambda f0(|u_T|), u_T the
// tangential part of u = sum_i w_i d_i + s_i (m . d_i) + a, d_i = x_i - x_i^ref the motions, w the lagged
// weights of the points where friction acts, s what the turning of a triangle of unit normal m moves them by
// (friction_stencil.h) and a the deflection of the bristles at the start of the step [theory eq. 19,
// 20]. f0(y) = y^2/eps - y^3/(3 eps^2) + eps/3 below eps = stick_displacement, y above [Li et al. 2020,
// eq. 17]: C1 with bounded curvature, so the force has magnitude mu lambda whenever the contact slips.
//
// f0 is concave in y^2, so the parabola mu lambda/2 (f0'(y_k)/y_k) |u_T|^2 through an iterate k has its force
// and lies above the energy [Hunter and Lange 2004, majorisation]. Newton's method takes its curvature where
// the model without curvature along the slip overshoots the end of sliding again and again.
//
// Anisotropic friction measures u in the metric of an ellipse, |A u| in place of |u_T| with the rows
// m_1 t_1 and m_2 t_2 of A: axes of the tangent plane times their shares of the larger coefficient. The
// energy is then the support function of the ellipse of the forces |A^-1 f| <= mu lambda, so that sliding
// dissipates the most that the ellipse allows [Moreau 1970; Michalowski and Mroz 1978: the associated sliding
// rule; theory eq. 20b].
#include <stark/mechanics/define.h>

namespace stark::models {

namespace {

/// How far the bristles are bent at the iterate [m].
Vec3 deflection(PotentialBuilder& b) {
  Vec3 u = b.data3("deflection", "m", "deflection of the bristles at the start of the step");
  // Two points have no triangle.
  const bool turns = b.point_count() > 2;
  const Vec3 facing = turns ? b.data3("facing", "1", "unit normal of the triangle that carries the point")
                            : Vec3{Scalar(0.0), Scalar(0.0), Scalar(0.0)};
  for (int i = 0; i < b.point_count(); ++i) {
    const std::string index = std::to_string(i);
    const Vec3 motion = b.x(i) - b.x_prev(i);
    u = u + b.data("weight" + index, "1", "signed weight of the point") * motion;
    if (turns)
      u = u + b.data3("slope" + index, "1", "motion by that of the point along facing") * dot(facing, motion);
  }
  return u;
}

/// f0 of the root of s, the square of the deflection u, or its model at the iterate [theory eq. 20d].
Scalar smoothed(PotentialBuilder& b, const Scalar& eps, const Scalar& s, const Vec3& u) {
  // Below 1e-8 eps the root is held constant: its curvature is unbounded there while the energy's is
  // 2/eps.
  const Scalar y = sqrt(max(s, square(1e-8 * eps)));
  const Scalar stick = s / eps - s * y / (3.0 * square(eps)) + eps / 3.0;
  const Scalar slope = b.data("slope", "1/m", "f0'(y) / y at the iterate");
  const Vec3 pull = b.data3("pull", "1", "phi'(y) times the dual force over its limit"),
             way = b.data3("way", "1", "unit vector along the deflection at the iterate");
  const Scalar p = dot(pull, u) - b.data("pull_at_iterate", "m", "pull . u there"),
               q = dot(way, u) - b.data("way_at_iterate", "m", "way . u there");
  const Scalar is_model = b.parameter("is_model", "1", "1 for the model at the iterate, else 0");
  return select(is_model > 0.5, 0.5 * slope * (s - p * q), select(s < square(eps), stick, y));
}

Scalar isotropic(PotentialBuilder& b) {
  const Scalar limit = b.data("limit", "N", "friction coefficient times normal force");
  const Vec3 normal = b.data3("normal", "1", "unit normal of the contact");
  const Scalar eps =
      b.parameter("stick_displacement", "m", "deflection of the bristles at which sliding begins");
  const Vec3 u = deflection(b);
  const Vec3 tangential = u - normal * dot(normal, u);
  return limit * smoothed(b, eps, squared_norm(tangential), u);
}

Scalar anisotropic(PotentialBuilder& b) {
  const Scalar limit = b.data("limit", "N", "larger friction coefficient times normal force");
  const Vec3 along = b.data3("along", "1", "unit tangent times its share of the larger coefficient"),
             across = b.data3("across", "1", "the tangent normal to it, times its share");
  const Scalar eps =
      b.parameter("stick_displacement", "m", "deflection of the bristles at which sliding begins");
  const Vec3 u = deflection(b);
  return limit * smoothed(b, eps, square(dot(along, u)) + square(dot(across, u)), u);
}

PotentialDefinition friction_potential(const std::string& name, int point_count, const std::string& doc,
                                       Scalar (*law)(PotentialBuilder&)) {
  PotentialDefinition definition =
      define_potential(name + "_" + std::to_string(point_count), point_count,
                       doc + " of " + std::to_string(point_count) + " points", law);
  definition.rotation_invariant = false;  // the tangent plane is frozen
  definition.sample = [point_count](std::mt19937_64& random) {
    std::uniform_real_distribution<double> unit(-1.0, 1.0);
    const auto random_vector = [&] { return stark::Vec3{unit(random), unit(random), unit(random)}; };
    PotentialSample sample;
    stark::Vec3 sum;  // of the slopes: zero, as of the weights, so that translations bend no bristles
    for (int i = 0; i < point_count; ++i) {
      sample.X.push_back(random_vector());
      sample.x_prev.push_back(sample.X.back());
      sample.x.push_back(sample.X.back() + random_vector() * 0.5);
      sample.values["weight" + std::to_string(i)] = {i == 0 ? 1.0 : -1.0 / (point_count - 1)};
      const bool is_last = i + 1 == point_count;
      const stark::Vec3 slope = i == 0 ? stark::Vec3{} : is_last ? sum * -1.0 : random_vector() * 0.2;
      sum += slope;
      if (point_count > 2) sample.values["slope" + std::to_string(i)] = {slope.x, slope.y, slope.z};
    }
    const stark::Vec3 facing = normalized(random_vector());
    if (point_count > 2) sample.values["facing"] = {facing.x, facing.y, facing.z};
    const stark::Vec3 n = normalized(random_vector()), a = random_vector() * 0.3;
    const stark::Vec3 t = normalized(cross(n, random_vector())), q = cross(n, t) * 0.3;
    sample.values["normal"] = {n.x, n.y, n.z};
    sample.values["along"] = {t.x, t.y, t.z};
    sample.values["across"] = {q.x, q.y, q.z};
    sample.values["deflection"] = {a.x, a.y, a.z};
    sample.values["stick_displacement"] = {0.5};
    sample.values["slope"] = {1.5};
    const stark::Vec3 w = random_vector() * 0.5;
    sample.values["pull"] = {w.x, w.y, w.z};
    sample.values["way"] = {t.x, t.y, t.z};
    sample.values["pull_at_iterate"] = {0.1 * unit(random)};
    sample.values["way_at_iterate"] = {0.1 * unit(random)};
    sample.values["is_model"] = {unit(random) > 0.0 ? 1.0 : 0.0};
    return sample;
  };
  return definition;
}

PotentialDefinition isotropic_friction(int point_count) {
  return friction_potential("friction", point_count, "smoothed Coulomb friction", isotropic);
}

PotentialDefinition anisotropic_friction(int point_count) {
  return friction_potential("anisotropic_friction", point_count,
                            "smoothed Coulomb friction that depends on the direction,", anisotropic);
}

}  // namespace

PotentialDefinition friction_2() { return isotropic_friction(2); }
PotentialDefinition friction_3() { return isotropic_friction(3); }
PotentialDefinition friction_4() { return isotropic_friction(4); }
PotentialDefinition friction_5() { return isotropic_friction(5); }
PotentialDefinition friction_6() { return isotropic_friction(6); }
PotentialDefinition anisotropic_friction_2() { return anisotropic_friction(2); }
PotentialDefinition anisotropic_friction_3() { return anisotropic_friction(3); }
PotentialDefinition anisotropic_friction_4() { return anisotropic_friction(4); }
PotentialDefinition anisotropic_friction_5() { return anisotropic_friction(5); }
PotentialDefinition anisotropic_friction_6() { return anisotropic_friction(6); }

}  // namespace stark::models
