// Step lengths: shorter where energies rise, longer where they fall on, within what bounds them.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include <support/analytic_objective.h>

using namespace stark;
using namespace stark::test;

TEST_CASE("overshooting steps are shortened until the energy falls") {
  // sqrt(1 + x^2): full Newton steps from |x| > 1 diverge, x -> -x^3.
  Analytic objective(
      [](const Vec3& x) {
        const double s = std::sqrt(1.0 + x.x * x.x);
        const Mat3 H = Mat3::diagonal({1.0 / (s * s * s), 1.0, 1.0});
        return Analytic::Value{s + 0.5 * (x.y * x.y + x.z * x.z), {x.x / s, x.y, x.z}, H, H};
      },
      {3, 1, 0});
  Solver solver(tight());
  const SolveReport report = solver.minimize(objective);
  CHECK(report.status == SolveStatus::Converged);
  CHECK(report.backtracks > 0);
  CHECK(norm(objective.x) < 1e-8);
}

TEST_CASE("a step bound limits each step and the minimum is reached all the same") {
  Analytic objective(quadratic, {5, -7, 11});
  objective.bound = 0.5;
  NewtonSettings settings = tight();
  settings.residual_tolerance = 1e-6;  // with half steps energies become equal to rounding before 1e-9 N
  Solver solver(settings);
  const SolveReport report = solver.minimize(objective);
  CHECK(report.status == SolveStatus::Converged);
  // Each step halves the forces. Those within the tolerance go on as long as something is in their way.
  const int to_tolerance = static_cast<int>(std::log2(norm(quadratic({5, -7, 11}).gradient) / 1e-6));
  CHECK(report.iterations >= to_tolerance);
  CHECK(report.iterations <= to_tolerance + 12);
  CHECK(norm(quadratic(objective.x).gradient) < 1e-6);
}

TEST_CASE("steps into infinite energies are shortened; if none is left the line search has failed") {
  Analytic wall(
      [](const Vec3& x) {  // -log x + x: infinite for x <= 0
        const Mat3 H = Mat3::diagonal({1.0 / (x.x * x.x), 1.0, 1.0});
        return Analytic::Value{
            x.x - std::log(x.x) + 0.5 * (x.y * x.y + x.z * x.z), {1.0 - 1.0 / x.x, x.y, x.z}, H, H};
      },
      {5, 0, 0});
  Solver solver(tight());
  CHECK(solver.minimize(wall).status == SolveStatus::Converged);
  CHECK(wall.x.x == doctest::Approx(1.0));

  Analytic trapped(quadratic, {5, 0, 0});
  trapped.feasible = false;
  const SolveReport report = solver.minimize(trapped);
  CHECK(report.status == SolveStatus::LineSearchFailed);
  CHECK(trapped.x == Vec3{5, 0, 0});
}

TEST_CASE("steps that a matrix makes too short are lengthened, as far as the energy falls") {
  // A parabola whose projected matrix is twenty times too stiff: the full step is a twentieth of the way.
  const auto stiff = [](const Vec3& x) {
    return Analytic::Value{0.5 * dot(x, x), x, Mat3::diagonal({-1.0, -1.0, -1.0}), Mat3::identity() * 20.0};
  };
  Analytic objective(stiff, {1, 2, 3});
  const SolveReport report = Solver(tight()).minimize(objective);
  CHECK(report.status == SolveStatus::Converged);
  CHECK(norm(objective.x) < 1e-9);
  CHECK(report.iterations <= 15);  // of lengths 16 or 32; full steps alone take 430
  // What bounds full steps bounds longer ones.
  Analytic bounded(stiff, {1, 2, 3});
  bounded.bound = 0.5;
  NewtonSettings few = tight();
  few.max_iterations = 5;
  CHECK(Solver(few).minimize(bounded).last_step_length == 0.5);
}

TEST_CASE(
    "full steps into a barrier that is hardly touched are lengthened, as it takes them half of the way") {
  // Depth below a contact distance of 1: the energy of a barrier near it, and a weight that it carries.
  const double weight = 1e-9;
  Analytic objective(
      [&](const Vec3& x) {
        const double depth = std::max(0.0, x.x);
        const Mat3 H = Mat3::diagonal({6.0 * depth + 1e-6, 1.0, 1.0});
        return Analytic::Value{
            depth * depth * depth - weight * x.x, {3.0 * depth * depth - weight, 0, 0}, H, H};
      },
      {1.0, 0, 0});
  NewtonSettings settings = tight();
  settings.residual_tolerance = 1e-3 * weight;
  const SolveReport report = Solver(settings).minimize(objective);
  CHECK(report.status == SolveStatus::Converged);
  CHECK(objective.x.x == doctest::Approx(std::sqrt(weight / 3.0)).epsilon(1e-3));
  CHECK(report.iterations <= 12);  // full steps alone halve the depth, and take 20
}

TEST_CASE("a shortened step that met nothing goes on to what the longer one met") {
  // A slope down to a stiff spring, which the Hessian knows nothing of before it is touched at 0.9.
  const auto bumper = [](const Vec3& x) {
    const double depth = std::max(0.0, x.x - 0.9);
    const Mat3 H = Mat3::diagonal({1.0 + (depth > 0.0 ? 1e6 : 0.0), 1.0, 1.0});
    return Analytic::Value{
        0.5 * (x.x - 1.3) * (x.x - 1.3) + 0.5e6 * depth * depth, {x.x - 1.3 + 1e6 * depth, 0, 0}, H, H};
  };
  Analytic objective(bumper, {0, 0, 0});
  NewtonSettings settings = tight();
  settings.max_iterations = 1;
  Solver solver(settings);
  CHECK(solver.minimize(objective).backtracks > 0);
  // Half of the step ends at 0.65; a sixteenth of that before the spring, or in it.
  CHECK(objective.x.x > 0.9 - 1.3 / 16.0);
  settings.max_iterations = 100;
  objective.x = {};
  CHECK(Solver(settings).minimize(objective).status == SolveStatus::Converged);
  CHECK(objective.x.x == doctest::Approx(0.9 + 0.4 / 1e6).epsilon(1e-6));
}

TEST_CASE("a full step that fits its model is not lengthened") {
  Analytic objective(cosh_sum, {2.0, -1.5, 1.0});
  Solver solver(tight());
  CHECK(solver.minimize(objective).last_step_length <= 1.0);
}

TEST_CASE("a step far into something stiff is shortened by the power with which its energy shrinks") {
  // A parabola with its minimum at 1 and the cube of a depth from 0.001 on, which the Hessian does not know
  // at the start: the full step has to be halved ten times.
  const auto cube = [](const Vec3& x) {
    const double depth = std::max(0.0, x.x - 1e-3);
    const Mat3 H = Mat3::diagonal({1.0 + 6e6 * depth, 1.0, 1.0});
    return Analytic::Value{0.5 * (x.x - 1.0) * (x.x - 1.0) + 1e6 * depth * depth * depth,
                           {x.x - 1.0 + 3e6 * depth * depth, 0, 0},
                           H,
                           H};
  };
  Analytic objective(cube, {0, 0, 0});
  NewtonSettings settings = tight();
  settings.max_iterations = 1;
  Solver solver(settings);
  const SolveReport first = solver.minimize(objective);
  CHECK(first.last_step_length <= std::ldexp(1.0, -9));
  CHECK(first.last_step_length >= std::ldexp(1.0, -11));  // no shorter than halving alone would find
  CHECK(first.backtracks <= 6);                           // which takes nine or ten trials
  settings.max_iterations = 100;
  objective.x = {};
  CHECK(Solver(settings).minimize(objective).status == SolveStatus::Converged);
  CHECK(cube(objective.x).gradient.x == doctest::Approx(0.0).epsilon(1e-6));
}
