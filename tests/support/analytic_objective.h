// Analytic objectives of one block, and a solver for them.
#pragma once

#include <cmath>
#include <functional>
#include <vector>

#include <stark/linalg/direct_solver.h>
#include <stark/solve/newton.h>

namespace stark::test {

/// A function of three numbers as an objective of one block of unit mass.
class Analytic final : public Objective {
 public:
  struct Value {
    double energy = 0.0;
    Vec3 gradient;
    Mat3 hessian, projected;  ///< `projected`: elements made positive semidefinite
  };

  Analytic(std::function<Value(const Vec3&)> f, const Vec3& start) : x(start), f_(std::move(f)) {}

  int32_t block_count() const override { return 1; }
  void linearize(bool project, std::span<double> out_gradient, BlockMatrix& out_hessian) override {
    ++linearizations;
    const Value value = f_(x);
    for (int c = 0; c < 3; ++c) out_gradient[c] = value.gradient[c];
    out_hessian.pattern = BlockPattern::from_pairs(1, {});
    out_hessian.set_zero();
    const Mat3& H = project ? value.projected : value.hessian;
    std::copy(H.m.begin(), H.m.end(), out_hessian.values.begin());
  }
  void evaluate_gradient(std::span<double> out_gradient) override {
    ++gradients;
    const Value value = f_(x);
    for (int c = 0; c < 3; ++c) out_gradient[c] = value.gradient[c];
  }
  bool has_pending_motion() const override { return pending; }
  Residual residual(std::span<const double> gradient) const override {
    const double force = norm(Vec3{gradient[0], gradient[1], gradient[2]});
    residuals.push_back(force);
    return {force, force};
  }
  Residual residual_beyond_rounding(std::span<const double> gradient, const BlockMatrix&) const override {
    const double force = norm(Vec3{gradient[0], gradient[1], gradient[2]});
    return force <= rounding ? Residual{} : Residual{force, force};
  }
  double energy_rounding(const BlockMatrix&) const override { return noise; }
  double motion(std::span<const double> d) const override { return norm(Vec3{d[0], d[1], d[2]}); }
  double bound_step(std::span<const double>, double, double longest) override {
    return bound == 1.0 ? longest : std::fmin(bound, longest);
  }
  TrialEnergy try_step(std::span<const double> d, double alpha) override {
    trial = x + Vec3{d[0], d[1], d[2]} * alpha;
    const double before = f_(x).energy, after = f_(trial).energy;
    return {feasible && std::isfinite(after), after - before, extra_magnitude + std::fabs(before), contact};
  }
  void relieve() override {
    ++reliefs;
    if (gives_way) bound = 1.0;
  }
  void accept_trial() override {
    last = x;
    x = trial;
    ++accepted;
    if (bound == 1.0) pending = false;
  }
  bool take_back() override {
    x = last;
    ++taken_back;
    return true;
  }
  void refresh_early(Lagged lagged) override { ++(lagged == Lagged::All ? refreshed_late : refreshed_early); }
  double refresh_lagged(int round) override {
    ++refreshed;
    return round < lag_rounds ? lag_change : 0.0;
  }

  Vec3 x, trial, last;
  bool pending = false, feasible = true, gives_way = false;
  double contact = 0.0;  ///< of trial energies
  double bound = 1.0, extra_magnitude = 0.0, lag_change = 0.0, rounding = 0.0, noise = 0.0;
  int linearizations = 0, gradients = 0, accepted = 0, refreshed = 0, refreshed_early = 0, refreshed_late = 0,
      lag_rounds = 0;
  int taken_back = 0, reliefs = 0;
  mutable std::vector<double> residuals;

 private:
  std::function<Value(const Vec3&)> f_;
};

inline NewtonSettings tight() {
  return {.acceleration_tolerance = 0.0, .residual_tolerance = 1e-9, .step_tolerance = 0.0};
}

struct Solver {
  explicit Solver(const NewtonSettings& settings) : linear({}, pool), newton(settings, linear, timer) {}
  SolveReport minimize(Objective& objective) { return newton.minimize(objective, 1.0); }

  ThreadPool pool{1};
  PhaseTimer timer;
  CholeskySolver linear;
  NewtonSolver newton;
};

/// x^T A x / 2 - b x.
inline Analytic::Value quadratic(const Vec3& x) {
  const Mat3 A{{4, 1, 0, 1, 3, 0.5, 0, 0.5, 2}};
  const Vec3 b{1, -2, 3};
  return {0.5 * dot(x, A * x) - dot(b, x), A * x - b, A, A};
}

inline Analytic::Value rosenbrock(const Vec3& p) {
  const double x = p.x, y = p.y, r = y - x * x;
  Analytic::Value v;
  v.energy = (1 - x) * (1 - x) + 100 * r * r + p.z * p.z;
  v.gradient = {-2 * (1 - x) - 400 * x * r, 200 * r, 2 * p.z};
  v.hessian = {{2 - 400 * r + 800 * x * x, -400 * x, 0, -400 * x, 200, 0, 0, 0, 2}};
  // Gauss-Newton part: positive definite.
  v.projected = {{2 + 800 * x * x, -400 * x, 0, -400 * x, 200, 0, 0, 0, 2}};
  return v;
}

/// A pendulum on weak springs: -cos x + |p|^2 / 20; curvature in x is negative beyond a quarter turn.
inline Analytic::Value pendulum(const Vec3& p) {
  Analytic::Value v;
  v.energy = -std::cos(p.x) + 0.05 * dot(p, p);
  v.gradient = Vec3{std::sin(p.x), 0, 0} + 0.1 * p;
  v.hessian = Mat3::diagonal({std::cos(p.x) + 0.1, 0.1, 0.1});
  v.projected = Mat3::diagonal({std::fmax(std::cos(p.x), 0.0) + 0.1, 0.1, 0.1});
  return v;
}

/// sum cosh(a_i . x - b_i): smooth and strictly convex.
inline Analytic::Value cosh_sum(const Vec3& x) {
  const Vec3 a[4] = {{1, 0.2, 0}, {0, 1, -0.3}, {0.4, 0, 1}, {0.5, -0.5, 0.5}};
  const double b[4] = {0.3, -0.2, 0.5, 0.1};
  Analytic::Value v;
  for (int i = 0; i < 4; ++i) {
    const double s = dot(a[i], x) - b[i];
    v.energy += std::cosh(s);
    v.gradient += a[i] * std::sinh(s);
    v.hessian += outer(a[i], a[i]) * std::cosh(s);
  }
  v.projected = v.hessian;
  return v;
}

}  // namespace stark::test
