// Newton's method where rounding hides the decrease of energies or is all that is left of forces.
#include <doctest/doctest.h>

#include <cmath>
#include <functional>

#include <support/analytic_objective.h>

using namespace stark;
using namespace stark::test;

namespace {

/// Energies that are known to 2e-9 J: fewer than `most` iterations where the objective says so, and more, or
/// no end, where it does not.
void check_that_noise_helps(const std::function<Analytic::Value(const Vec3&)>& rough, const Vec3& start,
                            int most) {
  Analytic objective(rough, start), blind(rough, start);
  objective.noise = 2e-9;
  Solver solver(tight()), other(tight());
  const SolveReport report = solver.minimize(objective);
  CHECK(report.status == SolveStatus::Converged);
  CHECK(report.iterations < most);
  const SolveReport longer = other.minimize(blind);
  CHECK((longer.status != SolveStatus::Converged || longer.iterations > report.iterations));
}

}  // namespace

TEST_CASE("where rounding hides the decrease, full steps are taken on the word of the gradient") {
  // Rounding of 1e-9, a million times what the magnitude of the energies shows.
  const auto rough = [](const Vec3& x) {
    Analytic::Value value = cosh_sum(x);
    value.energy += 1e-9 * std::sin(1e15 * x.x);
    return value;
  };
  Analytic objective(rough, {2.0, -1.5, 1.0});
  Solver solver(tight());
  const SolveReport report = solver.minimize(objective);
  CHECK(report.status == SolveStatus::Converged);
  CHECK(report.iterations < 12);
  CHECK(norm(cosh_sum(objective.x).gradient) < 1e-9);
}

TEST_CASE("where energies are all rounding the minimisation ends well") {
  // A residual tolerance that no arithmetic reaches, and energies of 1e20 J elsewhere.
  NewtonSettings settings = tight();
  settings.residual_tolerance = 1e-300;
  Analytic objective([](const Vec3& x) { return cosh_sum(x); }, {2.0, -1.5, 1.0});
  objective.extra_magnitude = 1e20;
  Solver solver(settings);
  const SolveReport report = solver.minimize(objective);
  CHECK(is_success(report.status));
  CHECK(report.iterations < 30);
}

TEST_CASE("tolerances below rounding are met where nothing but rounding is left, and not before") {
  NewtonSettings settings = tight();
  settings.residual_tolerance = 1e-30;
  // Forces that are known to 1e-10, of energies that are known to 1e-16.
  const auto rough = [](const Vec3& x) {
    Analytic::Value value = cosh_sum(x);
    value.gradient.x += 1e-10 * std::sin(1e18 * x.x);
    return value;
  };
  Analytic objective(rough, {2.0, -1.5, 1.0});
  objective.rounding = 2e-10;
  Solver solver(settings);
  const SolveReport report = solver.minimize(objective);
  CHECK(report.status == SolveStatus::Converged);
  CHECK(report.is_at_rounding);
  CHECK(report.residual < 2e-10);
  CHECK(report.iterations < 12);
  // Without the floor the same ends at round-off, in more iterations.
  Analytic endless(rough, {2.0, -1.5, 1.0});
  Solver other(settings);
  const SolveReport longer = other.minimize(endless);
  CHECK(longer.status == SolveStatus::RoundOff);
  CHECK_FALSE(longer.is_at_rounding);
  CHECK(longer.iterations > report.iterations);
  // A floor changes nothing where tolerances are met.
  Analytic met(cosh_sum, {2.0, -1.5, 1.0}), same(cosh_sum, {2.0, -1.5, 1.0});
  met.rounding = 1e9;
  Solver third(tight()), fourth(tight());
  const SolveReport with = third.minimize(met), without = fourth.minimize(same);
  CHECK_FALSE(with.is_at_rounding);
  CHECK(with.iterations == without.iterations);
  CHECK(met.x == same.x);
}

TEST_CASE("where the decrease is below the noise of energies, full steps are taken at once") {
  // Rounding of 3e-13 in energies of 1 J: 300 times what their magnitude shows.
  const auto rough = [](const Vec3& x) {
    Analytic::Value value = cosh_sum(x);
    value.energy += 3e-13 * std::sin(1e15 * x.x);
    return value;
  };
  Analytic objective(rough, {2.0, -1.5, 1.0});
  NewtonSettings settings = tight();
  settings.residual_tolerance = 1e-13;
  Solver solver(settings);
  const SolveReport report = solver.minimize(objective);
  CHECK(report.status == SolveStatus::Converged);
  CHECK(report.residual < 1e-13);
  CHECK(report.iterations < 12);
}

TEST_CASE("energies that vanish at rest round by more than they are") {
  // By 1e-9 J, as terms of what is stiff and unstrained do that cancel.
  const auto rough = [](const Vec3& x) {
    Analytic::Value value;
    for (int c = 0; c < 3; ++c) {
      value.energy += std::cosh(x[c]) - 1.0;
      value.gradient[c] = std::sinh(x[c]);
      value.hessian(c, c) = std::cosh(x[c]);
    }
    value.projected = value.hessian;
    value.energy += 1e-9 * std::sin(1e15 * x.x);
    return value;
  };
  check_that_noise_helps(rough, {2e-5, -1.5e-5, 1e-5}, 6);
}

TEST_CASE("steps that reduce no force and move nothing end where forces are rounding") {
  // Forces are known to 1e-10, and energies say nothing of it: their magnitude is as small as their noise.
  const auto rough = [](const Vec3& x) {
    const Mat3 H = Mat3::identity();
    return Analytic::Value{0.5 * dot(x, x), x + Vec3{1e-10, 0, 0} * std::sin(1e18 * x.x + 1.0), H, H};
  };
  NewtonSettings settings = tight();
  settings.residual_tolerance = 1e-30;
  settings.step_tolerance = 1e-3;
  Analytic objective(rough, {2.0, -1.5, 1.0});
  objective.rounding = 2e-10;
  objective.noise = 1e-19;
  Solver solver(settings);
  const SolveReport report = solver.minimize(objective);
  CHECK(report.status == SolveStatus::Converged);
  CHECK(report.is_at_rounding);
  CHECK(report.iterations < 12);
  // More than rounding is left where that is a hundredth.
  Analytic unbalanced(rough, {2.0, -1.5, 1.0});
  unbalanced.rounding = 1e-12;
  Solver other(settings);
  CHECK_FALSE(other.minimize(unbalanced).is_at_rounding);
}

TEST_CASE("forces whose products underflow are none") {
  // The square of the force is 1e-316, its product with the direction zero.
  const double stiffness = 1e10;
  const auto stiff = [&](const Vec3& x) {
    const Mat3 H = Mat3::identity() * stiffness;
    return Analytic::Value{0.5 * stiffness * dot(x, x), x * stiffness, H, H};
  };
  Analytic objective(stiff, {1e-168, 0.0, 0.0});
  Solver solver(tight());
  const SolveReport report = solver.minimize(objective);
  CHECK(report.status == SolveStatus::Converged);
  CHECK(report.iterations == 0);
  CHECK(report.residual == doctest::Approx(1e-158));
}

TEST_CASE("half of a step that raises the energy by more than the whole one shows rounding") {
  // Energies that are known to 2e-9 J, by the last bits of positions: less than a thousandth of the first
  // step changes none of those.
  const double start = 1e-5, bit = 0.8e-8;
  const auto rough = [&](const Vec3& x) {
    Analytic::Value value{0.5 * dot(x, x), x, Mat3::identity(), Mat3::identity()};
    const double cell = std::floor((x.x - start) / bit + 0.5);
    if (cell != 0.0) value.energy += 1e-9 * (1.0 + 0.5 * std::sin(cell));
    return value;
  };
  check_that_noise_helps(rough, {start, 0.0, 0.0}, 4);
}

TEST_CASE("a tiny step that gains more than its slope shows rounding") {
  // Energies are known to 2e-9 J. All but a hundredth of the first step seems to raise it, and that to lower
  // it by ten times what the slope says.
  const double start = 1e-5;
  const auto rough = [&](const Vec3& x) {
    Analytic::Value value{0.5 * dot(x, x), x, Mat3::identity(), Mat3::identity()};
    const double cell = std::floor((start - x.x) / start * 200.0);
    if (cell != 0.0) value.energy += cell == 1.0 ? -1e-11 : 5e-12 * cell;
    return value;
  };
  check_that_noise_helps(rough, {start, 0.0, 0.0}, 3);
}
