// Limit of the Green strain in tetrahedra and triangles: energy, force and stiffness against sums over
// eigenvalues, which are equal, nearly equal, at the limit or zero; derivatives against differences.
#include <doctest/doctest.h>

#include <algorithm>

#include <stark/base/rotation.h>
#include <support/finite_differences.h>
#include <support/law_checks.h>

using namespace stark;
using namespace stark::test;

namespace {

constexpr double kLimit = 0.1, kStiffness = 1e4, kThickness = 1e-2;

/// A limit on an element, its points mapped by F; energies over its size [J/m^3].
struct Limit {
  Limit(const PotentialDefinition& definition, const std::vector<Vec3>& X, double volume, double hardening)
      : potential(compiled(definition)),
        sample(element(X, X,
                       {{"strain_limit", kLimit},
                        {"strain_limit_stiffness", kStiffness},
                        {"strain_limit_hardening", hardening},
                        {"thickness", kThickness}})),
        size(volume) {}

  double density(const Mat3& F) const { return energy(potential, sample, mapped(F, sample.X)) / size; }
  std::vector<double> force(const Mat3& F) const { return gradient(potential, sample, mapped(F, sample.X)); }
  std::vector<double> stiffness(const Mat3& F) const {
    return hessian(potential, sample, mapped(F, sample.X));
  }

  Potential potential;
  FilledSample sample;
  double size;
};

Limit of_tet(double hardening) {
  const auto& X = kLawTet;
  return {tet4(models::strain_limit()), X, dot(X[1] - X[0], cross(X[2] - X[0], X[3] - X[0])) / 6.0,
          hardening};
}
Limit of_triangle(double hardening) {
  const auto& X = kLawTriangle;
  return {models::membrane_strain_limit(), X, 0.5 * kThickness * norm(cross(X[1] - X[0], X[2] - X[0])),
          hardening};
}

double stretch_of(double green) { return std::sqrt(1.0 + 2.0 * green); }

/// Strains by their excess over the limit: far above, at it, within rounding of it, below; equal and nearly
/// equal ones in all places.
std::vector<Vec3> excesses() {
  const std::vector<double> levels{0.5,   0.3,   0.3 + 1e-9, 1e-3,        1e-8, 0.0,
                                   -1e-8, -1e-3, -0.2,       -0.2 - 1e-9, -0.5};
  std::vector<Vec3> result;
  for (const double a : levels)
    for (const double b : levels)
      for (const double c : levels) result.push_back({a, b, c});
  return result;
}

double sum_of_cubes(const Vec3& excess, int count) {
  double sum = 0.0;
  for (int i = 0; i < count; ++i) sum += std::pow(std::max(0.0, excess[i]), 3);
  return sum;
}

double expected_density(const Vec3& excess, int count, double hardening) {
  const double S = sum_of_cubes(excess, count);
  return kStiffness / 3.0 * S * (1.0 + hardening * S / (S + std::pow(kLimit, 3)));
}

/// R diag(stretches) with the strains in arbitrary directions: of triangles in their plane.
Mat3 gradient_of(const Vec3& excess, bool in_plane, RandomPoints& random) {
  const Mat3 R = exp_rotation(random.point() * 2.0);
  const Mat3 Q = exp_rotation(in_plane ? Vec3{0, 0, 3.0 * random.point().x} : random.point() * 2.0);
  const Vec3 s{stretch_of(kLimit + excess.x), stretch_of(kLimit + excess.y),
               in_plane ? 1.0 : stretch_of(kLimit + excess.z)};
  return R * Mat3::diagonal(s) * transpose(Q);
}

}  // namespace

TEST_CASE("the energy is that of the eigenvalues of the Green strain above the limit") {
  RandomPoints random(3);
  for (const double hardening : {0.0, 500.0})
    for (const Vec3& excess : excesses()) {
      CAPTURE(excess.x);
      CAPTURE(excess.y);
      CAPTURE(excess.z);
      for (const bool in_plane : {false, true}) {
        const Limit limit = in_plane ? of_triangle(hardening) : of_tet(hardening);
        const double expected = expected_density(excess, in_plane ? 2 : 3, hardening);
        // Errors of strains are felt times the derivative, which vanishes at the limit. Strains on both sides
        // of it are told apart to rounding over their distance, 1e-17/1e-3: within 1e-8 to 1e-24 of the
        // cubes.
        const double S = sum_of_cubes(excess, in_plane ? 2 : 3);
        const double slope = kStiffness * std::cbrt(S * S) * (1.0 + hardening);
        CHECK(std::fabs(limit.density(gradient_of(excess, in_plane, random)) - expected) <=
              1e-13 * slope + 1e-12 * expected + 1e-24 * kStiffness);
      }
    }
}

TEST_CASE("below the limit there is no energy, force or stiffness") {
  RandomPoints random(4);
  for (const Vec3& excess : {Vec3{-1e-3, -0.2, -0.3}, Vec3{-0.2, -0.2, -0.2}, Vec3{-1e-6, -1e-6, -1e-6},
                             Vec3{-0.1, -0.1, -0.1}, Vec3{-0.6, -0.6, -0.1}})
    for (const bool in_plane : {false, true}) {
      const Limit limit = in_plane ? of_triangle(500.0) : of_tet(500.0);
      const std::vector<Vec3> x = mapped(gradient_of(excess, in_plane, random), limit.sample.X);
      CHECK(largest(evaluate(limit.potential, limit.sample, symbolic::Order::Hessian, x)) == 0.0);
    }
}

TEST_CASE("forces and stiffnesses agree with differences wherever strains meet each other or the limit") {
  RandomPoints random(5);
  double worst_force = 0.0, worst_stiffness = 0.0;
  for (const double hardening : {0.0, 500.0})
    for (const Vec3& excess : excesses())
      for (const bool in_plane : {false, true}) {
        if (in_plane && excess.z != 0.0) continue;
        const Limit limit = in_plane ? of_triangle(hardening) : of_tet(hardening);
        const Mat3 F = gradient_of(excess, in_plane, random);
        const Mat3 rate = Mat3::from_columns(random.point(), random.point(), random.point());
        const std::vector<Vec3> u = mapped(rate, limit.sample.X);
        CAPTURE(excess.x);
        CAPTURE(excess.y);
        CAPTURE(excess.z);
        CAPTURE(in_plane);
        const double scale = kStiffness * limit.size * (1.0 + hardening);
        const double force =
            differentiate_scalar([&](double t) { return limit.density(F + rate * t) * limit.size; }, 2e-3);
        worst_force = std::max(worst_force, std::fabs(work(limit.force(F), u) - force) / scale);
        const std::vector<double> change =
            differentiate([&](double t) { return limit.force(F + rate * t); }, 2e-3);
        const std::vector<double> H = limit.stiffness(F);
        for (size_t i = 0; i < change.size(); ++i) {
          double row = 0.0;
          for (size_t j = 0; j < change.size(); ++j)
            row += H[i * change.size() + j] * u[j / 3][static_cast<int>(j % 3)];
          worst_stiffness = std::max(worst_stiffness, std::fabs(row - change[i]) / scale);
        }
      }
  MESSAGE("worst force " << worst_force << ", worst stiffness " << worst_stiffness);
  CHECK(worst_force < 1e-8);
  // The third derivative jumps where a strain crosses the limit: differences with a step t are good to t
  // there.
  CHECK(worst_stiffness < 1e-3);
}

TEST_CASE("the stiffness is continuous across the limit and where strains meet") {
  RandomPoints random(6);
  for (const bool in_plane : {false, true}) {
    const Limit limit = in_plane ? of_triangle(500.0) : of_tet(500.0);
    for (const Vec3& excess : {Vec3{0.3, 0.0, -0.2}, Vec3{0.3, 0.0, 0.0}, Vec3{0.0, 0.0, 0.0},
                               Vec3{0.3, 0.3, 0.3}, Vec3{0.3, 0.3, 0.0}, Vec3{0.3, 0.3, -0.2},
                               Vec3{0.3, -0.2, -0.2}, Vec3{0.0, 0.0, -0.4}, Vec3{0.0, -0.4, -0.4}}) {
      const Mat3 F = gradient_of(excess, in_plane, random);
      const std::vector<double> here = limit.stiffness(F);
      for (const double step : {1e-12, 1e-9, 1e-6}) {
        const Mat3 rate = Mat3::from_columns(random.point(), random.point(), random.point());
        const std::vector<double> there = limit.stiffness(F + rate * step);
        double difference = 0.0;
        for (size_t i = 0; i < here.size(); ++i)
          difference = std::max(difference, std::fabs(there[i] - here[i]));
        // The third derivative is bounded: k times hardening over the limit and squares of rest gradients.
        // Two strains that meet at the limit are known to the root of rounding, 1e-8.
        CHECK(difference < (5e6 * step + 1e-6) * kStiffness * limit.size);
        CHECK(std::isfinite(difference));
      }
    }
  }
}

TEST_CASE("exactly at the limit in every direction nothing is singular") {
  const double s = stretch_of(kLimit);
  for (const Limit& limit : {of_tet(500.0), of_triangle(500.0)})
    for (const Mat3& F : {Mat3::identity() * s, Mat3::diagonal({s, s, 0.5}), Mat3::diagonal({s, 0.5, 0.5})})
      for (const double value : limit.stiffness(F)) CHECK(std::fabs(value) < 1e-8 * kStiffness);
}
