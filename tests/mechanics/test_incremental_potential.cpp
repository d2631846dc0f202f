// The objective of a time step: energies and derivatives of batches plus active set, measures of residual and
// motion, step bounds, and prescribed parts that arrive exactly.
#include <doctest/doctest.h>

#include <algorithm>
#include <map>

#include <stark/mechanics/incremental_potential.h>
#include <support/finite_differences.h>
#include <support/mixed_scene.h>

using namespace stark;
using namespace stark::test;

namespace {

/// Active set with one batch that never changes and step fractions of choice.
class FakeActiveSet final : public ActiveSet {
 public:
  FakeActiveSet(const MixedScene& scene, const PotentialBatch* batch) : scene_(scene), batch_(batch) {}

  void update(const SitePositions& x) override { at_update_.assign(x.all.begin(), x.all.end()); }
  std::vector<const PotentialBatch*> batches(Curvature) override { return {batch_}; }
  double max_step(std::span<const Vec3> x0, std::span<const Vec3> x1) override {
    ++queries;
    double longest = 0.0;
    for (size_t i = 0; i < x0.size(); ++i) longest = std::fmax(longest, norm(x1[i] - x0[i]));
    return longest <= allowed ? 1.0 : allowed / longest;
  }
  EnergyDifference energy_difference(const SitePositions& x) override {
    last_trial = x;
    return {energy(x.all) - energy(at_update_), energy(at_update_)};
  }
  double refresh_lagged(const SitePositions&) override { return 4.0; }
  void keep_lagged() override { ++kept; }
  void restore_lagged() override { ++restored; }
  int kept = 0, restored = 0;

  SitePositions last_trial{std::span<const Vec3>{}};
  double allowed = 1e9;  ///< [m] largest motion of a site
  int queries = 0;

 private:
  double energy(std::span<const Vec3> x) const {
    AlignedVector<double> out(batch_->block_count() * symbolic::kLanes);
    batch_->evaluate(symbolic::Order::Energy, x, 0, batch_->block_count(), out.data());
    double sum = 0.0;
    for (int64_t e = 0; e < batch_->size(); ++e) sum += out[e];
    return sum;
  }
  const MixedScene& scene_;
  const PotentialBatch* batch_;
  std::vector<Vec3> at_update_;
};

struct Bench {
  explicit Bench(const MixedScene& s, bool with_active_set = true)
      : scene(s),
        pool(1),
        assembler(s.map, pool),
        active(s, &s.batches[3]),
        potential(make(with_active_set)) {}

  IncrementalPotential make(bool with_active_set) {
    std::vector<PotentialBatch*> fixed = scene.fixed(0, 3);
    fixed.push_back(&scene.batches[4]);
    if (!with_active_set) fixed.push_back(&scene.batches[3]);
    assembler.set_static_batches(fixed);
    // Points of 2 kg; bodies of 3 kg, smallest moment 0.5 kg m^2, reach 0.25 m.
    std::vector<BlockScale> scales(scene.map.layout().block_count);
    for (size_t b = 0; b < scales.size(); ++b) {
      if (b < MixedScene::kFreePoints)
        scales[b].inverse_inertia = 1.0 / 2.0;
      else if ((b - MixedScene::kFreePoints) % 2 == 0)
        scales[b].inverse_inertia = 1.0 / 3.0;
      else
        scales[b] = {.inverse_inertia = 0.25 / 0.5, .inverse_length = 1.0 / 0.25, .reach = 0.25};
    }
    return IncrementalPotential(scene.map, assembler, with_active_set ? &active : nullptr, nullptr, scales,
                                timer);
  }

  const MixedScene& scene;
  ThreadPool pool;
  PhaseTimer timer;
  Assembler assembler;
  FakeActiveSet active;
  IncrementalPotential potential;
};

/// The configuration with its prescribed parts moved.
Configuration moved_prescribed(const MixedScene& scene) {
  Configuration target = scene.configuration;
  target.point_position[5] += {0.1, 0.0, -0.2};
  target.body_position[2] += {0.0, 0.3, 0.0};
  target.body_rotation[2] = exp_rotation({0.2, 0.1, -0.3}) * target.body_rotation[2];
  return target;
}

}  // namespace

TEST_CASE("residual and motion are measured per node and body") {
  const MixedScene scene(1);
  Bench bench(scene);
  std::vector<double> v(scene.dof_count(), 0.0);
  v[3 * 2] = 3.0;
  v[3 * 2 + 1] = 4.0;  // |f| = 5 N on point 2
  CHECK(bench.potential.residual(v).force == doctest::Approx(5.0));
  CHECK(bench.potential.residual(v).acceleration == doctest::Approx(2.5));
  CHECK(bench.potential.motion(v) == doctest::Approx(5.0));
  const int rotation = 3 * (MixedScene::kFreePoints + 1);
  v[rotation + 2] = 6.0;  // 6 N m on body 0: 24 N at its reach; 6 / 0.5 * 0.25 = 3 m/s^2 there
  CHECK(bench.potential.residual(v).force == doctest::Approx(24.0));
  CHECK(bench.potential.residual(v).acceleration == doctest::Approx(3.0));
  v[3 * 2] = v[3 * 2 + 1] = 0.0;
  CHECK(bench.potential.motion(v) == doctest::Approx(1.5));  // 6 rad at 0.25 m
}

TEST_CASE("gradient is the slope of the trial energies, static and active parts together") {
  const MixedScene scene(2);
  for (const bool with_active_set : {false, true}) {
    Bench bench(scene, with_active_set);
    bench.potential.begin(scene.configuration, scene.configuration);
    CHECK_FALSE(bench.potential.has_pending_motion());
    std::vector<double> gradient(scene.dof_count());
    BlockMatrix hessian;
    bench.potential.linearize(false, gradient, hessian);
    std::vector<double> alone(scene.dof_count());
    bench.potential.evaluate_gradient(alone);
    for (size_t i = 0; i < gradient.size(); ++i)
      CHECK(alone[i] == doctest::Approx(gradient[i]).epsilon(1e-12));
    RandomPoints random(3);
    std::vector<double> direction(scene.dof_count());
    for (double& d : direction) d = random.uniform();
    double expected = 0.0;
    for (size_t i = 0; i < gradient.size(); ++i) expected += gradient[i] * direction[i];
    const double slope = differentiate_scalar(
        [&](double t) { return bench.potential.try_step(direction, t).difference; }, 0.05);
    CHECK(slope == doctest::Approx(expected).epsilon(1e-9));
    const TrialEnergy trial = bench.potential.try_step(direction, 0.1);
    CHECK(trial.feasible);
    CHECK(trial.difference ==
          doctest::Approx(scene.energy(scene.along(direction, 0.1)) - scene.energy(scene.configuration))
              .epsilon(1e-11));
    CHECK(trial.magnitude == doctest::Approx(scene.energy(scene.configuration)).epsilon(1e-11));
  }
}

TEST_CASE("steps are bounded by the largest rotation") {
  const MixedScene scene(3);
  Bench bench(scene, false);
  bench.potential.begin(scene.configuration, scene.configuration);
  std::vector<double> direction(scene.dof_count(), 0.0);
  CHECK(bench.potential.bound_step(direction, 1.0) == 1.0);
  direction[0] = 50.0;  // points may go anywhere
  CHECK(bench.potential.bound_step(direction, 1.0) == 1.0);
  const int rotation = 3 * (MixedScene::kFreePoints + 3);  // of body 1
  direction[rotation] = 3.0;
  direction[rotation + 1] = 4.0;
  CHECK(bench.potential.bound_step(direction, 1.0) == doctest::Approx(0.2));
  CHECK(bench.potential.bound_step(direction, 6.0) == 1.0);
}

TEST_CASE("steps are certified as a whole by the active set, also where bodies rotate") {
  const MixedScene scene(4);
  Bench bench(scene);
  bench.active.allowed = 0.05;
  bench.potential.begin(scene.configuration, scene.configuration);
  RandomPoints random(5);
  std::vector<double> direction(scene.dof_count());
  for (double& d : direction) d = random.uniform();
  std::vector<double> gradient(scene.dof_count());
  BlockMatrix hessian;
  bench.potential.linearize(false, gradient, hessian);
  const double alpha = bench.potential.bound_step(direction, 1.0);
  CHECK(alpha > 0.0);
  CHECK(alpha < 1.0);
  const std::vector<Vec3> x0 = scene.positions(scene.configuration),
                          x1 = scene.positions(scene.along(direction, alpha));
  CHECK(bench.active.max_step(x0, x1) == 1.0);
  // Not needlessly small: a tenth more would not have been allowed.
  CHECK(bench.active.max_step(x0, scene.positions(scene.along(direction, 1.15 * alpha))) < 1.0);
  // The certified step needs no second certificate, a shorter one does: rotating sites leave the straight
  // path.
  bench.active.queries = 0;
  CHECK(bench.potential.try_step(direction, alpha).feasible);
  CHECK(bench.active.queries == 0);
  CHECK(bench.potential.try_step(direction, 0.5 * alpha).feasible);
  CHECK(bench.active.queries == 1);
  bench.active.allowed = 1e-6;
  CHECK_FALSE(bench.potential.try_step(direction, 0.5 * alpha).feasible);
}

TEST_CASE("prescribed parts travel with the step length on straight paths and arrive exactly") {
  const MixedScene scene(6);
  Bench bench(scene);
  const Configuration target = moved_prescribed(scene);
  bench.potential.begin(scene.configuration, target);
  REQUIRE(bench.potential.has_pending_motion());
  const std::vector<Vec3> start = scene.positions(scene.configuration), end = scene.positions(target);
  const std::vector<double> still(scene.dof_count(), 0.0);
  std::vector<double> gradient(scene.dof_count());
  BlockMatrix hessian;
  bench.potential.linearize(false, gradient, hessian);
  bench.potential.try_step(still, 0.5);
  bench.potential.accept_trial();
  CHECK(bench.potential.has_pending_motion());
  for (int32_t i = 0; i < scene.map.site_count(); ++i) {
    // Free sites have end = start; embedded ones follow the prescribed part of their points.
    const Vec3 expected = (start[i] + end[i]) * 0.5;
    CHECK(max_abs(bench.potential.site_positions()[i] - expected) < 1e-15);
  }
  bench.potential.linearize(false, gradient, hessian);
  bench.potential.try_step(still, 0.5);  // half of what is left
  bench.potential.accept_trial();
  const int32_t rigid_site = MixedScene::kPoints + 6;  // first point of body 2
  CHECK(max_abs(bench.potential.site_positions()[rigid_site] -
                (start[rigid_site] * 0.25 + end[rigid_site] * 0.75)) < 1e-15);
  bench.potential.linearize(false, gradient, hessian);
  bench.potential.try_step(still, 1.0);
  bench.potential.accept_trial();
  CHECK_FALSE(bench.potential.has_pending_motion());
  for (int32_t i = 0; i < scene.map.site_count(); ++i)
    CHECK(max_abs(bench.potential.site_positions()[i] - end[i]) <
          (scene.map.is_prescribed(i) ? 0.0 : 1e-15) + 1e-300);
  CHECK(bench.potential.configuration().body_rotation[2] == target.body_rotation[2]);
  CHECK(bench.potential.configuration().body_position[2] == target.body_position[2]);
  CHECK(bench.potential.configuration().point_position[5] == target.point_position[5]);
  CHECK(bench.potential.configuration().body_rotation[0] == scene.configuration.body_rotation[0]);
}

TEST_CASE("free parts of the target are ignored and a rejected trial changes nothing") {
  const MixedScene scene(7);
  Bench bench(scene);
  Configuration target = scene.configuration;
  target.point_position[0] = {9, 9, 9};
  target.body_position[0] = {9, 9, 9};
  bench.potential.begin(scene.configuration, target);
  CHECK_FALSE(bench.potential.has_pending_motion());
  std::vector<double> gradient(scene.dof_count()), again(scene.dof_count());
  BlockMatrix hessian;
  bench.potential.linearize(false, gradient, hessian);
  bench.potential.try_step(std::vector<double>(scene.dof_count(), 0.1), 1.0);
  bench.potential.linearize(false, again, hessian);
  CHECK(gradient == again);
  CHECK(bench.potential.site_positions()[0] == scene.configuration.point_position[0]);
  CHECK(bench.potential.refresh_lagged(0) == 4.0);
  CHECK(bench.potential.refresh_lagged(1) == 0.0);
  Bench without(scene, false);
  CHECK(without.potential.refresh_lagged(0) == 0.0);
}

TEST_CASE("a settled solution comes back with its lagged quantities") {
  const MixedScene scene(7);
  Bench bench(scene);
  bench.potential.set_active_set_updates(8);
  bench.potential.begin(scene.configuration, scene.configuration);
  CHECK_FALSE(bench.potential.restore_settled());
  bench.potential.refresh_lagged(0);
  CHECK_FALSE(bench.potential.restore_settled());
  bench.potential.refresh_lagged(1);
  CHECK(bench.active.kept == 1);
  const Vec3 settled = bench.potential.site_positions()[0];
  std::vector<double> gradient(scene.dof_count());
  BlockMatrix hessian;
  bench.potential.linearize(false, gradient, hessian);
  bench.potential.try_step(std::vector<double>(scene.dof_count(), 0.1), 1.0);
  bench.potential.accept_trial();
  CHECK(bench.potential.restore_settled());
  CHECK(bench.active.restored == 1);
  CHECK(bench.potential.site_positions()[0] == settled);
}

TEST_CASE("an energy that is not finite makes a trial infeasible") {
  const MixedScene scene(8);
  Bench bench(scene, false);
  bench.potential.begin(scene.configuration, scene.configuration);
  std::vector<double> gradient(scene.dof_count());
  BlockMatrix hessian;
  bench.potential.linearize(false, gradient, hessian);
  std::vector<double> direction(scene.dof_count(), 0.0);
  for (int k = 0; k < 3 * MixedScene::kFreePoints; ++k) direction[k] = 1e200 * (1 + k);
  CHECK_FALSE(bench.potential.try_step(direction, 1.0).feasible);
}

TEST_CASE("positions along a step are those of its trial point, with turns cut to the limit") {
  const MixedScene scene(7);
  Bench bench(scene);
  bench.potential.begin(scene.configuration, scene.configuration);
  std::vector<double> direction(scene.dof_count(), 0.0);
  direction[0] = 0.5;
  const std::vector<Vec3> start(bench.potential.site_positions().begin(),
                                bench.potential.site_positions().end());
  std::vector<Vec3> end = bench.potential.positions_along(direction, 1.0);
  double longest = 0.0;
  for (size_t i = 0; i < end.size(); ++i) longest = std::fmax(longest, norm(end[i] - start[i]));
  CHECK(longest == doctest::Approx(0.5));
  direction[3 * (MixedScene::kFreePoints + 1)] = 4.0;  // [rad]: a quarter of the step is left
  end = bench.potential.positions_along(direction, 1.0);
  CHECK(norm(end[0] - start[0]) == doctest::Approx(0.125));
  // The iterate stays where it is.
  for (size_t i = 0; i < start.size(); ++i) CHECK(bench.potential.site_positions()[i] == start[i]);
}

TEST_CASE("an iterate has run away where a site is beyond the limit of motion") {
  const MixedScene scene(8);
  Bench bench(scene);
  std::vector<double> direction(scene.dof_count(), 0.0);
  direction[1] = 3.0;
  std::vector<double> gradient(scene.dof_count());
  BlockMatrix hessian;
  const auto go = [&] {
    bench.potential.begin(scene.configuration, scene.configuration);
    bench.potential.linearize(false, gradient, hessian);
    bench.potential.try_step(direction, 1.0);
    bench.potential.accept_trial();
    return bench.potential.has_run_away();
  };
  CHECK_FALSE(go());  // no limit
  bench.potential.set_motion_limit(3.1);
  CHECK_FALSE(go());
  bench.potential.set_motion_limit(2.9);
  CHECK(go());
}

TEST_CASE("positions with the same number differ only where something moves") {
  const MixedScene scene(11);
  Bench bench(scene);
  RandomPoints random(12);
  Configuration start = scene.configuration;
  std::map<uint64_t, std::vector<Vec3>> first;
  std::vector<double> gradient(scene.dof_count());
  BlockMatrix hessian;
  int64_t again = 0;
  const auto check = [&](const SitePositions& x) {
    if (x.still == 0) return;
    const auto [before, is_new] = first.try_emplace(x.still, x.all.begin(), x.all.end());
    again += is_new ? 0 : 1;
    for (int32_t i = 0; i < scene.map.site_count(); ++i) {
      const bool moves = std::ranges::any_of(
          x.moving, [&](const SiteRange& range) { return i >= range.begin && i < range.end; });
      const Site& site = scene.map.site(i);
      if (!moves) CHECK((site.kind != SiteKind::Point && site.index == 2));
      if (!moves) CHECK(before->second[i] == x.all[i]);
    }
  };
  for (const int kind : {0, 0, 1, 0, 0, 2, 0, 2, 2, 0, 1, 1, 0, 0}) {
    Configuration target = kind == 1 ? moved_prescribed(scene) : start;
    // Kind 2: somebody has placed the body elsewhere between two minimisations.
    if (kind == 2) start.body_position[2] = target.body_position[2] = random.point();
    bench.potential.begin(start, target);
    check(bench.potential.known_positions());
    bench.potential.linearize(false, gradient, hessian);
    for (int k = 0; k < 3; ++k) {
      std::vector<double> d(scene.dof_count());
      for (double& v : d) v = 0.1 * random.uniform(-1.0, 1.0);
      bench.potential.try_step(d, 1.0);
      check(bench.active.last_trial);
      bench.potential.accept_trial();
      check(bench.potential.known_positions());
    }
    start = bench.potential.configuration();
  }
  CHECK(again > 40);
  CHECK(first.size() > 3);
}
