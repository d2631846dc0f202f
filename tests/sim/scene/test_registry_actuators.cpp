// Every registered actuator on every coordinate of every registered joint: derivatives by differences, the
// effort as what drives the coordinate, the same bits from the interpreter. A new actuator or joint is tested
// by its line in sim/scene/registry.inc alone.
#include <doctest/doctest.h>

#include <cmath>
#include <random>
#include <set>

#include <stark/mechanics/constraint_set.h>
#include <stark/sim/scene/registry.h>
#include <support/finite_differences.h>

using namespace stark;
using namespace stark::test;
using symbolic::Backend;
using symbolic::Order;

namespace {

constexpr double kStep = 0.1;  // of time [s]

/// One actuator with random points and values, the start of the step a little away from them.
struct Sample {
  Sample(const ActuatorDefinition& definition, std::vector<JointCoordinate> on, Backend backend,
         unsigned seed)
      : coordinates(std::move(on)),
        law(definition, coordinates, backend),
        batch(law.potential()),
        random(seed) {
    std::vector<int32_t> stencil;
    for (size_t k = 0; k < law.points().size(); ++k) {
      stencil.push_back(static_cast<int32_t>(k));
      x.push_back({number(-1, 1), number(-1, 1), number(-1, 1)});
    }
    batch.resize(stencil);
    batch.set_previous(x);
    batch.set_initial(x);
    batch.set_time(kStep, 1.0);
    for (const ElementField& field : law.potential()->element_fields()) {
      if (field.source != ElementField::Source::Data) continue;
      std::vector<double> values;
      for (int c = 0; c < field.width; ++c) values.push_back(number(0.5, 1.5));
      batch.set(field.name, 0, values);
    }
    set("active", 1.0);
    const std::vector<double> q = raw(x);
    for (int k = 0; k < law.coordinate_count(); ++k) {
      const double start = q[k] + number(-0.2, 0.2);
      set(actuator_raw_start_field(k), start);
      set(actuator_start_field(k), start);
    }
  }

  double number(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random); }

  void set(const std::string& name, double value) {
    for (const ElementField& field : law.potential()->element_fields())
      if (field.name == name) batch.set(name, 0, {&value, 1});
  }

  /// Coordinates as the formulas of the joints give them.
  std::vector<double> raw(const std::vector<Vec3>& at) const {
    std::vector<double> result;
    size_t first = 0;
    for (size_t k = 0; k < coordinates.size(); first += law.point_counts()[k], ++k) {
      const JointCoordinate& c = coordinates[k];
      const Joint joint(*c.joint, c.a, c.b, Backend::Interpreter);
      PotentialBatch measured(joint.potential());
      std::vector<int32_t> stencil;
      std::vector<Vec3> points;
      for (size_t p = 0; p < joint.points().size(); ++p) {
        stencil.push_back(static_cast<int32_t>(p));
        // Points that the coordinate does not use may be anywhere.
        const auto used = law.points().begin() + static_cast<std::ptrdiff_t>(first);
        const auto found = std::find(used, used + law.point_counts()[k], joint.points()[p]);
        const bool is_used = found != used + law.point_counts()[k];
        points.push_back(is_used ? at[found - law.points().begin()] : Vec3{0.3, 0.1, 0.2});
      }
      measured.resize(stencil);
      measured.set_previous(points);
      measured.set_initial(points);
      for (const ElementField& field : joint.potential()->element_fields()) {
        if (field.source != ElementField::Source::Data || !field.name.starts_with("placement")) continue;
        const int index = batch.field_index(actuator_joint_prefix(static_cast<int>(k)) + field.name);
        std::vector<double> values;
        for (int c2 = 0; c2 < field.width; ++c2) values.push_back(index >= 0 ? batch.get(index, 0, c2) : 1.0);
        measured.set(field.name, 0, values);
      }
      result.push_back(measured.evaluate(joint.values(), points)[joint.units().size() + c.index]);
    }
    return result;
  }

  std::vector<Vec3> moved(int i, double t) const {
    std::vector<Vec3> y = x;
    y[i / 3][i % 3] += t;
    return y;
  }

  std::vector<JointCoordinate> coordinates;
  Actuator law;
  PotentialBatch batch;
  std::mt19937_64 random;
  std::vector<Vec3> x;
};

/// Calls check(definition, on, seed) for every actuator on every coordinate, between the kinds of frames.
template <typename Check>
void sweep(Check&& check) {
  unsigned seed = 0;
  for (const auto& joint : registered_joints()) {
    const auto known = joint_coordinates(*joint);
    for (int c = 0; c < static_cast<int>(known.size()); ++c)
      for (const auto& actuator : registered_actuators())
        for (const FrameKind a : {FrameKind::Axes, FrameKind::Patch}) {
          CAPTURE(joint->name);
          CAPTURE(known[c].name);
          CAPTURE(actuator->name);
          // Frames of the two joints of a gear are of both kinds.
          std::vector<JointCoordinate> on{{joint.get(), c, a, FrameKind::Axes}};
          if (actuator->coordinate_count == 2)
            on.push_back({joint.get(), c, FrameKind::Axes, FrameKind::Axes});
          check(*actuator, on, ++seed);
        }
  }
}

double largest_of(std::span<const double> values) {
  double result = 0.0;
  for (const double v : values) result = std::max(result, std::fabs(v));
  return result;
}

}  // namespace

TEST_CASE("names of registered actuators are unique, and their values have units and meanings") {
  std::set<std::string> names;
  for (const auto& actuator : registered_actuators()) {
    CHECK_MESSAGE(names.insert(actuator->name).second, actuator->name);
    CHECK_MESSAGE(!actuator->doc.empty(), actuator->name);
    for (const std::string unit : {"rad", "m"})
      for (const ActuatorParameter& parameter :
           actuator_parameters(*actuator, std::vector<std::string>(actuator->coordinate_count, unit)))
        CHECK_MESSAGE((!parameter.unit.empty() && !parameter.doc.empty()),
                      actuator->name << ": " << parameter.name);
  }
  CHECK(names.size() >= 10);
}

TEST_CASE("derivatives of every actuator on every coordinate agree with differences") {
  double strongest = 0.0;
  sweep([&](const ActuatorDefinition& definition, const std::vector<JointCoordinate>& on, unsigned seed) {
    const Sample sample(definition, on, Backend::Automatic, seed);
    const int n = 3 * sample.batch.point_count();
    const std::vector<double> exact = sample.batch.evaluate(Order::Hessian, sample.x);
    const double force = largest_of(std::span(exact).subspan(1, n)), scale = 1.0 + largest_of(exact);
    strongest = std::max(strongest, force);
    double error = 1e300, error_of_rows = 1e300;
    // One of the steps is short enough for samples next to the end of a cap, where the second derivative
    // jumps.
    for (const double step : {1e-2, 1e-3, 1e-4}) {
      if (error < 1e-7 * scale && error_of_rows < 1e-6 * scale) break;
      double worst = 0.0, worst_of_rows = 0.0;
      int entry = 1 + n;
      for (int i = 0; i < n; ++i) {
        const auto at = [&](double t, Order order) {
          return sample.batch.evaluate(order, sample.moved(i, t));
        };
        const auto slope = differentiate([&](double t) { return at(t, Order::Energy); }, step);
        worst = std::max(worst, std::fabs(slope[0] - exact[1 + i]));
        const auto rows = differentiate([&](double t) { return at(t, Order::Gradient); }, step);
        for (int j = i; j < n; ++j, ++entry)
          worst_of_rows = std::max(worst_of_rows, std::fabs(rows[1 + j] - exact[entry]));
      }
      error = std::min(error, worst);
      error_of_rows = std::min(error_of_rows, worst_of_rows);
    }
    CHECK(error < 1e-7 * scale);
    CHECK(error_of_rows < 1e-6 * scale);
  });
  CHECK(strongest > 1.0);
}

TEST_CASE("the forces of every actuator are its effort times the slope of the coordinate") {
  sweep([](const ActuatorDefinition& definition, const std::vector<JointCoordinate>& on, unsigned seed) {
    const Sample sample(definition, on, Backend::Automatic, seed);
    const int n = 3 * sample.batch.point_count();
    const std::vector<double> exact = sample.batch.evaluate(Order::Gradient, sample.x);
    const std::vector<double> values = sample.batch.evaluate(sample.law.values(), sample.x);
    const double* effort = values.data() + sample.law.units().size();
    for (int i = 0; i < n; ++i) {
      const auto slope = differentiate([&](double t) { return sample.raw(sample.moved(i, t)); }, 1e-3);
      double expected = 0.0;
      for (size_t k = 0; k < on.size(); ++k) expected -= effort[k] * slope[k];
      CHECK(exact[1 + i] == doctest::Approx(expected).epsilon(1e-6));
    }
  });
}

TEST_CASE("the interpreter gives the bits of machine code") {
  sweep([](const ActuatorDefinition& definition, const std::vector<JointCoordinate>& on, unsigned seed) {
    const Sample fast(definition, on, Backend::Automatic, seed),
        slow(definition, on, Backend::Interpreter, seed);
    CHECK(fast.batch.evaluate(Order::Hessian, fast.x) == slow.batch.evaluate(Order::Hessian, slow.x));
  });
}

TEST_CASE("the energy of every actuator is the integral of its effort, across the ends of caps too") {
  const auto slider = find_joint("slider");
  unsigned seed = 0;
  for (const auto& actuator : registered_actuators()) {
    if (actuator->coordinate_count != 1) continue;
    CAPTURE(actuator->name);
    const Sample sample(*actuator, {{slider.get(), 0, FrameKind::Axes, FrameKind::Axes}}, Backend::Automatic,
                        ++seed);
    // Moves b along its line of action, by changes that reach beyond every cap.
    const int b = 3 * (sample.batch.point_count() - 1);
    const int n = 4000;
    double integral = 0.0, largest_step = 0.0;
    std::vector<double> energy, effort, q;
    for (int i = 0; i <= n; ++i) {
      const std::vector<Vec3> x = sample.moved(b, -1.0 + 2.0 * i / n);
      energy.push_back(sample.batch.evaluate(Order::Energy, x)[0]);
      effort.push_back(sample.batch.evaluate(sample.law.values(), x)[sample.law.units().size()]);
      q.push_back(sample.raw(x)[0]);
      if (i == 0) continue;
      integral -= 0.5 * (effort[i] + effort[i - 1]) * (q[i] - q[i - 1]);
      largest_step = std::max(largest_step, std::fabs(energy[i] - energy[0] - integral));
    }
    CHECK(largest_step < 1e-5 * (1.0 + std::fabs(energy.back()) + std::fabs(energy.front())));
  }
}
