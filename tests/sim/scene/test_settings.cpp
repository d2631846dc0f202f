// Defaults, ranges and the rules between the settings of a simulation.
#include <doctest/doctest.h>

#include <limits>

#include <stark/base/error.h>
#include <stark/geometry/shapes.h>
#include <stark/linalg/direct_solver.h>
#include <stark/sim/scene/settings.h>
#include <stark/sim/simulation.h>

using namespace stark;

TEST_CASE("rules between settings") {
  Settings settings;
  CHECK_NOTHROW(validate(settings));
  settings.time.min_step = 1.0;
  CHECK_THROWS_AS(validate(settings), InvalidSetting);
  settings = {};
  settings.newton.acceleration_tolerance = settings.newton.step_tolerance =
      settings.newton.residual_tolerance = 0.0;
  CHECK_THROWS_AS(validate(settings), InvalidSetting);
  settings.newton.residual_tolerance = 1e-6;
  CHECK_NOTHROW(validate(settings));
  set(settings, "time_step", 0.5);
  set_from_text(settings, "threads", "0");
  CHECK(settings.time.step == 0.5);
  CHECK(settings.execution.threads == 0);
  CHECK(changed_from_default(Settings{}) == "all defaults");
}

TEST_CASE("no number setting accepts a value that is not a number") {
  for (const Field& field : Settings::fields().fields()) {
    if (field.type != FieldType::Real) continue;
    CAPTURE(field.name);
    Settings settings;
    const double nan = std::numeric_limits<double>::quiet_NaN();
    CHECK_THROWS_AS(set(settings, field.name, nan), InvalidSetting);
    CHECK(changed_from_default(settings) == "all defaults");
    field.set(&settings, nan);  // written past the checks, as C++ programs can
    CHECK_THROWS_AS(validate(settings), InvalidSetting);
  }
}

TEST_CASE("quasistatic steps need a tolerance that means something without inertia") {
  Settings settings;
  settings.time.integrator = Integrator::Quasistatic;
  CHECK_NOTHROW(validate(settings));
  settings.newton.step_tolerance = 0.0;
  CHECK_THROWS_AS(validate(settings), InvalidSetting);
}

TEST_CASE("a simulation solves with the linear solver of a program, by its name") {
  static int solves = 0;
  class Counting final : public LinearSolver {
   public:
    Counting(const LinearSettings& settings, ThreadPool& pool) : inner_(settings, pool) {}
    void begin_step() override { inner_.begin_step(); }

   protected:
    LinearSolveReport solve_system(const LinearSystem& system, std::span<double> x) override {
      ++solves;
      return inner_.solve(system, x);
    }

   private:
    CholeskySolver inner_;
  };
  Settings settings;
  CHECK_THROWS_AS(set_from_text(settings, "linear.solver", "counting"), InvalidSetting);
  register_linear_solver("counting", [](const LinearSettings& linear, ThreadPool& pool) {
    return std::make_unique<Counting>(linear, pool);
  });
  set_from_text(settings, "linear.solver", "counting");
  Scene scene;
  scene.add_cloth({.mesh = make_grid(0.1, 0.1, 2, 2)});
  Simulation sim(scene, settings);
  const StepReport& report = sim.step();
  CHECK_FALSE(report.failed());
  CHECK(solves > 0);
  CHECK(report.solve.factorizations == solves);
}
