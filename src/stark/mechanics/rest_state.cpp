// See rest_state.h.
#include <stark/mechanics/rest_state.h>

namespace stark::rest_state {

using symbolic::Scalar;
using Point = PotentialBuilder::Position;

namespace {

/// 1 + alpha T, 1 without a temperature. [theory eq. 15d]
Scalar thermal_stretch(PotentialBuilder& b, const std::set<std::string>& fields) {
  if (!fields.contains(kTemperature)) return 1.0;
  const Scalar expansion = b.parameter(kThermalExpansion, "1/K", "thermal expansion coefficient");
  return 1.0 + expansion * b.data(kTemperature, "K", "temperature above that of the rest shape");
}

/// Growth of solids times thermal stretch: what the rest shape has become.
symbolic::Mat3 rest_gradient(PotentialBuilder& b, const std::set<std::string>& fields) {
  symbolic::Mat3 G = symbolic::Mat3::identity();
  if (fields.contains(kGrowth)) {
    const auto values = b.data_array(kGrowth, 9, "1", "stretch of the rest shape, a tensor");
    for (int i = 0; i < 9; ++i) G(i / 3, i % 3) = values[i];
  }
  return G * thermal_stretch(b, fields);
}

Scalar stretch_of_rest(PotentialBuilder& b, const std::set<std::string>& fields) {
  const Scalar thermal = thermal_stretch(b, fields);
  return fields.contains(kGrowth) ? b.data(kGrowth, "1", "stretch of the rest shape") * thermal : thermal;
}

bool stretches(const std::set<std::string>& fields) {
  return fields.contains(kGrowth) || fields.contains(kTemperature);
}

/// (tan(a/2) + sin(a/2))/a: what the turn of the frames of a segment by the angle a is to the law of a rod.
Scalar turn_measure(const Scalar& square_of_angle) {
  const Scalar small = 1.0 + square_of_angle * (1.0 / 48.0);
  const Scalar angle = sqrt(max(square_of_angle, 1e-6));  // below, the series is exact to rounding
  const Scalar half = 0.5 * angle;
  return select(square_of_angle < 1e-6, small, (tan(half) + sin(half)) / angle);
}

/// Strains of a rod beyond those of its rest state. [theory eq. 15f]
RodStrain beyond_rest(PotentialBuilder& b, const std::set<std::string>& fields, const RodStrain& strain) {
  const Scalar inverse = 1.0 / stretch_of_rest(b, fields);
  symbolic::Vec3 natural(0.0, 0.0, 0.0);
  if (fields.contains(kNaturalCurvature)) {
    const auto curvature = b.data_array(kNaturalCurvature, 2, "1/m", "curvature without load");
    natural[0] = curvature[0];
    natural[1] = curvature[1];
  }
  if (fields.contains(kNaturalTwist)) natural[2] = b.data(kNaturalTwist, "rad/m", "twist without load");
  const Scalar length = norm(b.X(1) - b.X(0)) / inverse;
  const Scalar measure = turn_measure(squared_norm(natural) * square(length));
  RodStrain beyond = strain;
  beyond.stretch = strain.stretch * inverse;
  for (int k = 0; k < 2; ++k) beyond.curvature[k] = strain.curvature[k] * inverse - natural[k] * measure;
  beyond.twist = strain.twist * inverse - natural[2] * measure;
  return beyond;
}

Scalar active_stress(PotentialBuilder& b) {
  return b.data(kActiveStress, "Pa", "active stress along the fibres");
}

symbolic::Vec3 fiber_direction(PotentialBuilder& b) {
  return b.direction(kFiberDirection, "direction of the fibres at rest");
}

/// Stretch of the fibres of a triangle of a shell, whose points are those of b.
Scalar stretch_in_triangle(PotentialBuilder& b) {
  const symbolic::Vec3 first = b.X(1) - b.X(0), second = b.X(2) - b.X(0), fiber = fiber_direction(b);
  // a * first + c * second is the projection of the direction, times a number that the quotient leaves out.
  const Scalar along_first = dot(first, fiber), along_second = dot(second, fiber), mixed = dot(first, second);
  const Scalar a = along_first * squared_norm(second) - along_second * mixed;
  const Scalar c = along_second * squared_norm(first) - along_first * mixed;
  const symbolic::Vec3 now = (b.x(1) - b.x(0)) * a + (b.x(2) - b.x(0)) * c;
  return norm(now) / norm(first * a + second * c);
}

}  // namespace

SolidLaw with_fields(const SolidLaw& law, const std::set<std::string>& fields) {
  SolidLaw result = law;
  if (stretches(fields))
    result.psi = [psi = law.psi, fields](PotentialBuilder& b, const SolidDeformation& deformation) {
      const symbolic::Mat3 G = rest_gradient(b, fields), inverse_G = inverse(G);
      const SolidDeformation elastic{[&](Point p) { return deformation.F_of(p) * inverse_G; }};
      return determinant(G) * psi(b, elastic);
    };
  if (fields.contains(kActiveStress))  // theory eq. 15e
    result.psi = [psi = result.psi](PotentialBuilder& b, const SolidDeformation& deformation) {
      const Scalar stretch = norm(deformation.F() * fiber_direction(b));
      return psi(b, deformation) + active_stress(b) * (stretch - 1.0);
    };
  result.zero_at_rest = false;  // the rest state decides
  result.one_sided = false;
  return result;
}

ShellLaw with_fields(const ShellLaw& law, const std::set<std::string>& fields) {
  ShellLaw result = law;
  if (stretches(fields))
    result.psi = [psi = law.psi, fields](PotentialBuilder& b, const ShellDeformation& deformation) {
      const Scalar stretch = stretch_of_rest(b, fields), inverse = 1.0 / stretch;
      const ShellDeformation elastic{[&](Point p) { return deformation.F_of(p) * inverse; }};
      return square(stretch) * psi(b, elastic);
    };
  if (fields.contains(kActiveStress))  // theory eq. 15e
    result.psi = [psi = result.psi](PotentialBuilder& b, const ShellDeformation& deformation) {
      return psi(b, deformation) + active_stress(b) * (stretch_in_triangle(b) - 1.0);
    };
  result.zero_at_rest = false;
  result.one_sided = false;
  return result;
}

RodLaw with_fields(const RodLaw& law, const std::set<std::string>& fields) {
  RodLaw result = law;
  result.psi = [psi = law.psi, fields](PotentialBuilder& b, const RodDeformation& deformation) {
    const RodDeformation elastic{[&] { return beyond_rest(b, fields, deformation.strain()); },
                                 [&] { return beyond_rest(b, fields, deformation.strain_prev()); }};
    const Scalar energy = stretch_of_rest(b, fields) * psi(b, elastic);
    if (!fields.contains(kActiveForce)) return energy;
    const Scalar force = b.data(kActiveForce, "N", "active force along the rod");
    return energy + force * (deformation.strain().stretch - 1.0);
  };
  result.zero_at_rest = false;
  return result;
}

std::set<std::string> stretching(const std::set<std::string>& fields) {
  std::set<std::string> found;
  for (const char* name : {kGrowth, kTemperature})
    if (fields.contains(name)) found.insert(name);
  return found;
}

GrownEdge grown_edge(PotentialBuilder& b, const std::set<std::string>& fields, const symbolic::Vec3& edge,
                     bool is_solid) {
  if (is_solid) {
    const symbolic::Mat3 G = rest_gradient(b, fields);
    return {G * edge, determinant(G)};
  }
  const Scalar stretch = stretch_of_rest(b, fields);
  return {edge * stretch, square(stretch)};
}

}  // namespace stark::rest_state
