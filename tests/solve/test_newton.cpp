// Newton's method on analytic objectives: convergence, projection, line search, and every way to end.
#include <doctest/doctest.h>

#include <chrono>
#include <cmath>
#include <limits>
#include <thread>

#include <stark/base/psd.h>
#include <support/analytic_objective.h>

using namespace stark;
using namespace stark::test;

namespace {

/// A parabola along x whose Hessian is too soft: each step goes two thirds of the way too far.
Analytic::Value soft(const Vec3& p) {
  const Mat3 H = Mat3::diagonal({0.6, 1.0, 1.0});
  return {0.5 * dot(p, p), p, H, H};
}

}  // namespace

TEST_CASE("a quadratic function takes one iteration") {
  Analytic objective(quadratic, {5, -7, 11});
  Solver solver(tight());
  const SolveReport report = solver.minimize(objective);
  CHECK(report.status == SolveStatus::Converged);
  CHECK(report.iterations == 1);
  CHECK(report.projected_iterations == 0);
  CHECK(report.backtracks == 0);
  CHECK(report.last_step_length == 1.0);
  CHECK(norm(quadratic(objective.x).gradient) < 1e-13);
}

TEST_CASE("a start at the minimum takes none") {
  Analytic objective(
      [](const Vec3& x) {
        return Analytic::Value{dot(x, x), x * 2.0, Mat3::identity() * 2.0, Mat3::identity() * 2.0};
      },
      {});
  Solver solver(tight());
  const SolveReport report = solver.minimize(objective);
  CHECK(report.status == SolveStatus::Converged);
  CHECK(report.iterations == 0);
  CHECK(objective.x == Vec3{});
}

TEST_CASE("a guess is where the minimisation begins if its energy is lower and nothing is in the way") {
  const std::vector<double> good = {1.0, 0.4, 0.5}, bad = {-20.0, 0.0, 0.0};
  const auto from = [](const std::vector<double>& guess, const auto& change) {
    Analytic objective(rosenbrock, {-1.2, 0.0, -0.5});
    change(objective);
    Solver solver(tight());
    const SolveReport report = solver.newton.minimize(objective, 1.0, guess);
    return std::pair(report, objective);
  };
  const auto as_it_is = [](Analytic&) {};
  const auto [without, end] = from({}, as_it_is);
  const auto [with, same_end] = from(good, as_it_is);
  CHECK(without.status == SolveStatus::Converged);
  CHECK(with.status == SolveStatus::Converged);
  CHECK(norm(end.x - Vec3{1, 1, 0}) < 1e-9);
  CHECK(norm(same_end.x - Vec3{1, 1, 0}) < 1e-9);
  CHECK(with.iterations < without.iterations);

  // Uphill, against something, in the way of something, or while prescribed parts move: as without.
  CHECK(from(bad, as_it_is).second.residuals == end.residuals);
  const auto pushed = [](Analytic& objective) { objective.contact = 1e3; };
  CHECK(from(good, pushed).second.residuals == end.residuals);
  const auto half_way = [](Analytic& objective) { objective.bound = 0.5; };
  CHECK(from(good, half_way).second.residuals == from({}, half_way).second.residuals);
  const auto moving = [](Analytic& objective) { objective.pending = true; };
  CHECK(from(good, moving).second.residuals == from({}, moving).second.residuals);
  CHECK(from(good, moving).second.gradients == from({}, moving).second.gradients);
}

TEST_CASE("where the last Hessian is good enough, convergence is found without a new one") {
  // From nearby, the second direction is far below the tolerance: the gradient alone tells.
  Analytic objective(cosh_sum, {0.32, -0.2, 0.45});
  const NewtonSettings settings{
      .acceleration_tolerance = 1e-2, .residual_tolerance = 0.0, .step_tolerance = 1e-1};
  Solver solver(settings);
  const SolveReport report = solver.minimize(objective);
  CHECK(report.status == SolveStatus::Converged);
  CHECK(report.iterations == 1);
  CHECK(objective.linearizations == 1);
  CHECK(objective.gradients == 1);
  CHECK(objective.accepted == 2);  // the direction of the last Hessian is taken as well
  CHECK(report.last_motion < settings.step_tolerance);
  CHECK(report.acceleration < settings.acceleration_tolerance);
  CHECK(norm(cosh_sum(objective.x).gradient) < 0.1 * report.residual);
}

TEST_CASE("where it contracts too little, the Hessian is formed anew and the minimum is the same") {
  Analytic objective(soft, {1.0, 0.2, -0.1});
  const NewtonSettings settings{
      .acceleration_tolerance = 1e-1, .residual_tolerance = 0.0, .step_tolerance = 1e-3};
  Solver solver(settings);
  const SolveReport report = solver.minimize(objective);
  CHECK(report.status == SolveStatus::Converged);
  CHECK(objective.gradients > 0);
  CHECK(objective.linearizations >= report.iterations);
  // The motion that was left at the end bounds the distance: x / 0.6 < 1e-3.
  CHECK(std::fabs(objective.x.x) < 6e-4);
}

TEST_CASE("after a refresh of lagged quantities the last Hessian serves once more") {
  Analytic objective(quadratic, {5, -7, 11});
  objective.lag_rounds = 3;
  objective.lag_change = 1e-3;
  const NewtonSettings settings{
      .acceleration_tolerance = 1e-6, .residual_tolerance = 0.0, .step_tolerance = 1e-6};
  Solver solver(settings);
  const SolveReport report = solver.minimize(objective);
  CHECK(report.status == SolveStatus::Converged);
  CHECK(report.lag_updates == 3);
  CHECK(objective.linearizations == 2);  // to step, and to see that it was enough
  CHECK(objective.gradients == 3);
}

TEST_CASE("Rosenbrock's valley is followed to its end") {
  for (const Vec3& start : {Vec3{-1.2, 1.0, 0.5}, Vec3{3, -4, 1}, Vec3{0, 5, 0}}) {
    Analytic objective(rosenbrock, start);
    Solver solver(tight());
    const SolveReport report = solver.minimize(objective);
    CHECK(report.status == SolveStatus::Converged);
    CHECK(norm(objective.x - Vec3{1, 1, 0}) < 1e-10);
    CHECK(report.iterations < 60);
  }
}

TEST_CASE("convergence is quadratic") {
  Analytic objective(cosh_sum, {2.0, -1.5, 1.0});
  NewtonSettings settings = tight();
  settings.residual_tolerance = 1e-13;
  Solver solver(settings);
  REQUIRE(is_success(solver.minimize(objective).status));
  // Observed order from the last three residuals above rounding.
  const std::vector<double>& r = objective.residuals;
  double order = 0.0;
  for (size_t k = 2; k < r.size(); ++k)
    if (r[k] > 1e-13 && r[k] < 1e-3) order = std::log(r[k] / r[k - 1]) / std::log(r[k - 1] / r[k - 2]);
  CHECK(order > 1.8);
}

TEST_CASE("where the matrix is indefinite, elements are projected and the descent goes on") {
  Analytic objective(pendulum, {2.5, 0.3, -0.2});
  Solver solver(tight());
  const SolveReport report = solver.minimize(objective);
  CHECK(report.status == SolveStatus::Converged);
  CHECK(report.projected_iterations > 0);
  CHECK(report.projected_iterations < report.iterations + 1);
  // A minimum, not necessarily the nearest one: the first projected step is long.
  CHECK(norm(pendulum(objective.x).gradient) < 1e-9);
  CHECK(pendulum(objective.x).hessian(0, 0) > 0.0);
  CHECK(pendulum(objective.x).energy < pendulum({2.5, 0.3, -0.2}).energy);

  NewtonSettings never = tight();
  never.projection = Projection::Never;
  Analytic raw(pendulum, {2.5, 0.3, -0.2});
  Solver strict(never);
  CHECK(strict.minimize(raw).status == SolveStatus::LinearSolveFailed);
  CHECK(raw.x == Vec3{2.5, 0.3, -0.2});

  NewtonSettings always = tight();
  always.projection = Projection::Always;
  Analytic projected(pendulum, {0.5, 0.3, -0.2});
  Solver careful(always);
  const SolveReport all = careful.minimize(projected);
  CHECK(all.status == SolveStatus::Converged);
  CHECK(all.projected_iterations == all.iterations + 1);  // the last one only finds that it has converged
}

TEST_CASE("an iterate within the tolerances goes on if its last direction was cut short") {
  Analytic objective(quadratic, {5, -7, 11});
  objective.bound = 0.5;
  NewtonSettings settings = tight();
  settings.residual_tolerance = 1e3;  // met at the start
  Solver solver(settings);
  CHECK(solver.minimize(objective).status == SolveStatus::Converged);
  CHECK(norm(quadratic(objective.x).gradient) <
        norm(quadratic({5, -7, 11}).gradient) / 4000.0);  // 2^12 = 4096
}

TEST_CASE("gradients that are not finite end the minimisation at once") {
  Analytic objective(
      [](const Vec3& x) {
        Analytic::Value v = quadratic(x);
        if (x.x < 1.0) v.gradient.y = std::numeric_limits<double>::quiet_NaN();
        return v;
      },
      {5, 0, 0});
  Solver solver(tight());
  const SolveReport report = solver.minimize(objective);
  CHECK(report.status == SolveStatus::NotFinite);
  CHECK(objective.accepted == 1);
  CHECK_FALSE(is_success(report.status));
}

TEST_CASE("Hessians that are not finite are a failure of the linear solve") {
  Analytic objective(
      [](const Vec3& x) {
        Analytic::Value v = quadratic(x);
        v.hessian(0, 0) = v.projected(0, 0) = std::numeric_limits<double>::quiet_NaN();
        return v;
      },
      {5, 0, 0});
  Solver solver(tight());
  CHECK(solver.minimize(objective).status == SolveStatus::LinearSolveFailed);
  CHECK(objective.accepted == 0);
}

TEST_CASE("interrupts are asked for between iterations") {
  Analytic objective(rosenbrock, {-1.2, 1.0, 0.5});
  Solver solver(tight());
  int asked = 0;
  solver.newton.set_interrupt([&] { return ++asked > 3; });
  const SolveReport report = solver.minimize(objective);
  CHECK(report.status == SolveStatus::Interrupted);
  CHECK(report.iterations == 3);
  CHECK(objective.linearizations == 3);
}

TEST_CASE("interrupts are asked for within iterations that take long") {
  const auto slow = [](const Vec3& x) {
    std::this_thread::sleep_for(std::chrono::milliseconds(120));
    return rosenbrock(x);
  };
  Analytic objective(slow, {-1.2, 1.0, 0.5});
  Solver solver(tight());
  int asked = 0;
  solver.newton.set_interrupt([&] { return ++asked == 2; });  // first before the derivatives, then after
  CHECK(solver.minimize(objective).status == SolveStatus::Interrupted);
  CHECK(objective.linearizations == 1);
  CHECK(objective.accepted == 0);
  CHECK(objective.x == Vec3{-1.2, 1.0, 0.5});
}

TEST_CASE("a deadline ends a minimisation between iterations, and only then") {
  using Clock = std::chrono::steady_clock;
  Analytic objective(rosenbrock, {-1.2, 1.0, 0.5});
  Solver solver(tight());
  solver.newton.set_deadline(Clock::now());
  const SolveReport late = solver.minimize(objective);
  CHECK(late.status == SolveStatus::TimeBudget);
  CHECK(late.iterations == 0);
  CHECK(objective.x == Vec3{-1.2, 1.0, 0.5});
  solver.newton.set_deadline(Clock::now() + std::chrono::hours(1));
  CHECK(solver.minimize(objective).status == SolveStatus::Converged);
  Analytic again(rosenbrock, {-1.2, 1.0, 0.5});
  solver.newton.set_deadline({});
  solver.minimize(again);
  CHECK(again.x == objective.x);
}

TEST_CASE("an iterate beyond any scale ends the minimisation") {
  struct Slope final : Objective {
    int32_t block_count() const override { return 1; }
    void linearize(bool, std::span<double> g, BlockMatrix& H) override {
      H.pattern = BlockPattern::from_pairs(1, {});
      H.set_zero();
      g[0] = 1.0;
      g[1] = g[2] = 0.0;
      for (int c = 0; c < 3; ++c) H.values[4 * c] = 1e-3;
    }
    void evaluate_gradient(std::span<double> g) override {
      BlockMatrix unused;
      linearize(false, g, unused);
    }
    bool has_pending_motion() const override { return false; }
    Residual residual(std::span<const double>) const override { return {1.0, 1.0}; }
    double motion(std::span<const double> d) const override { return std::fabs(d[0]); }
    double bound_step(std::span<const double>, double, double) override { return 1.0; }
    TrialEnergy try_step(std::span<const double> d, double alpha) override {
      trial = x + d[0] * alpha;
      return {true, d[0] * alpha, 1.0};
    }
    void accept_trial() override { x = trial; }
    bool has_run_away() const override { return std::fabs(x) > 5500.0; }
    double x = 0.0, trial = 0.0;
  } slope;
  const SolveReport report = Solver(tight()).minimize(slope);
  CHECK(report.status == SolveStatus::RunAway);
  CHECK(report.iterations == 6);  // of 1000 each
}

TEST_CASE("what keeps steps short again and again is asked to give way") {
  const auto bowl = [](const Vec3& x) {
    return Analytic::Value{0.5 * squared_norm(x), x, Mat3::identity(), Mat3::identity()};
  };
  const Vec3 start{1.0, 2.0, 3.0};
  Analytic soft(bowl, start), hard(bowl, start), wide(bowl, start);
  soft.bound = hard.bound = 0.01;
  wide.bound = 0.1;
  soft.gives_way = true;

  CHECK(Solver(tight()).minimize(soft).status == SolveStatus::Converged);
  CHECK(soft.reliefs == 1);
  const SolveReport report = Solver(tight()).minimize(hard);
  CHECK(report.status == SolveStatus::MaxIterations);
  CHECK(hard.reliefs == report.iterations / 6);
  CHECK(Solver(tight()).minimize(wide).status == SolveStatus::Converged);
  CHECK(wide.reliefs == 0);
}

TEST_CASE("the last step does not leave more force than the tolerances allow") {
  // Beside the top of a hill, with a projected matrix that has a hundredth of its curvature.
  const auto hill = [](const Vec3& x) {
    return Analytic::Value{0.5 * (x.y * x.y + x.z * x.z - x.x * x.x),
                           {-x.x, x.y, x.z},
                           Mat3::diagonal({-1.0, 1.0, 1.0}),
                           Mat3::diagonal({0.01, 1.0, 1.0})};
  };
  const Vec3 start{5e-10, 0, 0};
  Analytic objective(hill, start);
  const SolveReport report = Solver(tight()).minimize(objective);
  CHECK(report.status == SolveStatus::Converged);
  CHECK(report.residual == doctest::Approx(5e-10));
  CHECK(objective.taken_back == 1);
  CHECK(objective.x == start);
  // Where it leaves less, it stands, and the report is about its end.
  Analytic harmless(hill, {1e-14, 0, 0});
  const double left = Solver(tight()).minimize(harmless).residual;
  CHECK(left > 1e-12);  // a hundred times the start, and more: such steps are lengthened
  CHECK(left < 1e-9);
  CHECK(harmless.taken_back == 0);
}

TEST_CASE("lagged quantities are refreshed on the way to the first solution, and not near it") {
  Analytic objective(rosenbrock, {-1.2, 1.0, 0.5});
  const SolveReport report = Solver(tight()).minimize(objective);
  CHECK(report.status == SolveStatus::Converged);
  CHECK(objective.refreshed_early > 3);
  CHECK(objective.refreshed_early < report.iterations);
  CHECK(objective.refreshed_late == 0);
  CHECK(objective.refreshed == 1);
  Analytic near(rosenbrock, {1.0 + 5e-12, 1.0, 0.0});
  Solver(tight()).minimize(near);
  CHECK(near.refreshed_early + near.refreshed_late == 0);
}

TEST_CASE("full steps that leave the residual as it is have all lagged quantities refreshed") {
  const Analytic* of = nullptr;
  const auto slipping = [&](const Vec3& p) {
    return quadratic(p - Vec3{0.1, 0, 0} * (of->refreshed_late == 0 ? of->accepted : 3));
  };
  Analytic objective(slipping, {5, -7, 11});
  of = &objective;
  const SolveReport report = Solver(tight()).minimize(objective);
  CHECK(report.status == SolveStatus::Converged);
  CHECK(objective.refreshed_late >= 1);
  CHECK(objective.refreshed_late <= 2);
  CHECK(report.iterations > 16);
  CHECK(report.iterations < 24);
}

TEST_CASE("refreshes that move the minimum to and fro end soon") {
  const Analytic* of = nullptr;
  const auto flipping = [&](const Vec3& p) {
    return quadratic(p - (of->refreshed_early % 2 == 0 ? Vec3{} : Vec3{0.1, 0, 0}));
  };
  Analytic objective(flipping, {5, -7, 11});
  of = &objective;
  const SolveReport report = Solver(tight()).minimize(objective);
  CHECK(report.status == SolveStatus::Converged);
  CHECK(objective.refreshed_early >= 2);
  CHECK(objective.refreshed_early <= 3);
  CHECK(report.iterations <= 5);
}

TEST_CASE("where the way is not clear, nothing is refreshed any more") {
  Analytic objective(quadratic, {5, -7, 11});
  objective.lag_change = 2.0;
  objective.lag_rounds = 3;
  Solver solver(tight());
  int asked = 0;
  bool is_clear = false;
  solver.newton.set_way_check([&] { return ++asked, is_clear; });
  CHECK(solver.minimize(objective).status == SolveStatus::Detour);
  CHECK(objective.refreshed == 0);
  is_clear = true;
  CHECK(solver.minimize(objective).status == SolveStatus::Converged);
  CHECK(asked == 2);  // once for each minimisation, however many refreshes there are
}

TEST_CASE("iterates that go around something end before they converge") {
  // It takes more than 20 iterations; the way is looked at after 8, 12, 16, ...
  Analytic objective(soft, {5, -7, 11});
  Solver solver(tight());
  std::vector<bool> is_clear;
  size_t asked = 0;
  solver.newton.set_way_check([&] { return is_clear[std::min(asked++, is_clear.size() - 1)]; });
  const auto end = [&](std::vector<bool> looks) {
    is_clear = std::move(looks);
    asked = 0;
    objective.x = {5, -7, 11};
    return solver.minimize(objective);
  };
  const SolveReport blocked = end({false});
  CHECK(blocked.status == SolveStatus::Detour);
  CHECK(blocked.iterations == 12);
  CHECK(end({true, false, false}).iterations == 16);
  CHECK(end({false, true, false, true}).status == SolveStatus::Converged);  // clear again: no detour
  CHECK(asked > 4);
}

TEST_CASE("every way to end has a name") {
  CHECK(to_string(SolveStatus::Converged) == "converged");
  CHECK(to_string(SolveStatus::Detour) == "detour");
  CHECK(to_string(SolveStatus::ConstraintViolated) == "constraint_violated");
  CHECK(to_string(SolveStatus::RunAway) == "run_away");
}

TEST_CASE("the iteration limit is kept") {
  NewtonSettings settings = tight();
  settings.max_iterations = 4;
  Analytic objective(rosenbrock, {-1.2, 1.0, 0.5});
  Solver solver(settings);
  const SolveReport report = solver.minimize(objective);
  CHECK(report.status == SolveStatus::MaxIterations);
  CHECK(report.iterations == 4);
  CHECK(objective.accepted == 4);
  CHECK_FALSE(is_success(report.status));
}

TEST_CASE(
    "a minimisation whose residual falls gets more iterations than the limit, up to five times as many") {
  const auto run = [](double bound, double tolerance, int limit) {
    NewtonSettings settings = tight();
    settings.residual_tolerance = tolerance;
    settings.step_tolerance = 0.0;
    settings.max_iterations = limit;
    Analytic objective(quadratic, {1.0, 1.0, 1.0});
    objective.bound = bound;  // each iteration leaves 1 - bound of the residual
    Solver solver(settings);
    return solver.minimize(objective);
  };
  const SolveReport fast = run(0.02, 1e-2, 200);  // a hundred iterations leave 13 %
  CHECK(fast.status == SolveStatus::Converged);
  CHECK(fast.iterations > 200);
  CHECK(run(0.02, 1e-2, 100).iterations == 100);   // before anything could be compared
  const SolveReport slow = run(0.005, 1e-2, 200);  // 61 %
  CHECK(slow.status == SolveStatus::MaxIterations);
  CHECK(slow.iterations == 200);
  const SolveReport endless = run(0.01, 1e-20, 200);  // 37 %
  CHECK(endless.status == SolveStatus::MaxIterations);
  CHECK(endless.iterations == 1000);
}

TEST_CASE("tolerances: all active ones must hold, or any of them") {
  NewtonSettings settings{.acceleration_tolerance = 0.0, .residual_tolerance = 1e9, .step_tolerance = 1e-6};
  Analytic all(cosh_sum, {2.0, -1.5, 1.0});
  Solver first(settings);
  const SolveReport both = first.minimize(all);
  CHECK(both.status == SolveStatus::Converged);
  CHECK(both.last_motion < 1e-6);
  CHECK(both.iterations > 2);
  settings.termination = Termination::Any;
  Analytic any(cosh_sum, {2.0, -1.5, 1.0});
  Solver second(settings);
  CHECK(second.minimize(any).iterations == 0);  // the residual is below 1e9 at the start
  settings = {.acceleration_tolerance = 1e-3, .residual_tolerance = 0.0, .step_tolerance = 0.0};
  Analytic acceleration(cosh_sum, {2.0, -1.5, 1.0});
  Solver third(settings);
  CHECK(third.minimize(acceleration).acceleration < 1e-3);
}

TEST_CASE("pending motion: not converged before it is done, however small the residual") {
  Analytic objective(quadratic, {5, -7, 11});
  objective.x = {0, 0, 0};
  objective.pending = true;
  NewtonSettings settings = tight();
  settings.residual_tolerance = 1e9;
  Solver solver(settings);
  const SolveReport report = solver.minimize(objective);
  CHECK(report.status == SolveStatus::Converged);
  CHECK_FALSE(objective.pending);
  CHECK(report.iterations == 1);
}

TEST_CASE("pending motion that cannot go on is reported as blocked") {
  Analytic objective(quadratic, {5, -7, 11});
  objective.pending = true;
  objective.bound = 1e-9;
  Solver solver(tight());
  const SolveReport report = solver.minimize(objective);
  CHECK(report.status == SolveStatus::Blocked);
  CHECK(report.iterations < 50);
}

TEST_CASE("pending motion that goes on for too long is reported as blocked, too") {
  Analytic objective(quadratic, {5, -7, 11});
  objective.pending = true;
  objective.bound = 1e-3;
  NewtonSettings settings = tight();
  settings.max_iterations = 20;
  Solver solver(settings);
  CHECK(solver.minimize(objective).status == SolveStatus::Blocked);
}

TEST_CASE("lagged quantities are refreshed until nothing changes, and never without end") {
  Analytic changing(quadratic, {5, -7, 11});
  changing.lag_change = 2.0;
  changing.lag_rounds = 3;
  Solver solver(tight());
  const SolveReport report = solver.minimize(changing);
  CHECK(report.status == SolveStatus::Converged);
  CHECK(report.lag_updates == 3);
  CHECK(changing.refreshed == 4);
  Analytic settled(quadratic, {5, -7, 11});
  CHECK(solver.minimize(settled).lag_updates == 0);
  CHECK(settled.refreshed == 1);
  Analytic endless(quadratic, {5, -7, 11});
  endless.lag_change = 2.0;
  endless.lag_rounds = 1000000;
  CHECK(solver.minimize(endless).status == SolveStatus::ConstraintViolated);
}

TEST_CASE("a singular matrix is shifted: directions without stiffness and load stay as they are") {
  const auto trough = [](const Vec3& p) {
    Analytic::Value v;
    v.energy = 2.0 * (p.x - 1.0) * (p.x - 1.0);
    v.gradient = {4.0 * (p.x - 1.0), 0, 0};
    v.hessian = v.projected = Mat3::diagonal({4.0, 0.0, 0.0});
    return v;
  };
  Analytic objective(trough, {7, 2, 3});
  const SolveReport report = Solver(tight()).minimize(objective);
  CHECK(report.status == SolveStatus::Converged);
  CHECK(objective.x.x == doctest::Approx(1.0).epsilon(1e-9));
  CHECK(objective.x.y == 2.0);
  CHECK(objective.x.z == 3.0);
}

TEST_CASE("where a refreshed problem cannot be solved, the last settled solution stands") {
  // The second refresh breaks the objective; until then it is a plain parabola.
  struct Breaking final : Objective {
    int32_t block_count() const override { return 1; }
    void linearize(bool, std::span<double> g, BlockMatrix& H) override {
      H.pattern = BlockPattern::from_pairs(1, {});
      H.set_zero();
      for (int c = 0; c < 3; ++c) {
        g[c] = broken ? std::numeric_limits<double>::quiet_NaN() : x[c];
        H.values[4 * c] = 1.0;
      }
    }
    void evaluate_gradient(std::span<double> g) override {
      BlockMatrix unused;
      linearize(false, g, unused);
    }
    bool has_pending_motion() const override { return false; }
    Residual residual(std::span<const double> g) const override {
      return {norm(Vec3{g[0], g[1], g[2]}), 0.0};
    }
    double motion(std::span<const double>) const override { return 0.0; }
    double bound_step(std::span<const double>, double, double) override { return 1.0; }
    TrialEnergy try_step(std::span<const double> d, double alpha) override {
      trial = x + Vec3{d[0], d[1], d[2]} * alpha;
      return {true, 0.5 * (dot(trial, trial) - dot(x, x)), 1.0};
    }
    void accept_trial() override { x = trial; }
    double refresh_lagged(int round) override {
      if (round == 1) settled = x, has_settled = true, broken = true;
      return 1.0;
    }
    bool restore_settled() override {
      if (has_settled) x = settled;
      return has_settled;
    }
    Vec3 x{1, 2, 3}, trial, settled;
    bool broken = false, has_settled = false;
  } objective;
  const SolveReport report = Solver(tight()).minimize(objective);
  CHECK(report.status == SolveStatus::Converged);
  CHECK(report.is_settled);
  CHECK(report.lag_residual == 1.0);
  CHECK(norm(objective.x) < 1e-9);
  // What is reported is of that solution, not of the attempt that failed.
  CHECK(report.residual < 1e-9);
}
