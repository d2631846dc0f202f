// Assembly of a mixed scene against differences of the total energy; the same bits for any number of threads;
// motion announced by prescribed sites.
#include <doctest/doctest.h>

#include <cstring>

#include <stark/mechanics/assembler.h>
#include <support/finite_differences.h>
#include <support/mixed_scene.h>
#include <support/symmetric_eigen.h>

using namespace stark;
using namespace stark::test;

namespace {

constexpr size_t kStaticBatches =
    3;  ///< of MixedScene: the others are dynamic, so that the patterns must be merged

struct Workbench {
  explicit Workbench(const MixedScene& s, int threads = 1, size_t static_batches = kStaticBatches)
      : scene(s), pool(threads), assembler(s.map, pool) {
    // The plain batch, the last one, is static.
    std::vector<PotentialBatch*> fixed = s.fixed(0, static_batches);
    fixed.push_back(&s.batches.back());
    assembler.set_static_batches(fixed);
    assembler.set_dynamic_batches(s.pointers(static_batches, s.batches.size() - 1));
  }

  Assembled assemble(const Configuration& c, std::span<const Vec3> x, const AssemblyOptions& options = {}) {
    Assembled result;
    result.gradient.assign(scene.dof_count(), 1e30);  // whatever was there must be overwritten
    assembler.assemble(c, x, options, result.gradient, result.matrix);
    result.hessian = to_dense(result.matrix);
    return result;
  }
  Assembled assemble(const Configuration& c, const AssemblyOptions& options = {}) {
    return assemble(c, scene.positions(c), options);
  }

  const MixedScene& scene;
  ThreadPool pool;
  Assembler assembler;
};

double largest(const std::vector<double>& values) {
  double result = 0.0;
  for (const double v : values) result = std::fmax(result, std::fabs(v));
  return result;
}

std::vector<double> unit(int n, int i, int j = -1) {
  std::vector<double> direction(n, 0.0);
  direction[i] += 1.0;
  if (j >= 0) direction[j] += 1.0;
  return direction;
}

double dot(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0.0;
  for (size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
  return sum;
}

bool same_bits(const std::vector<double>& a, const std::vector<double>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(double)) == 0;
}

}  // namespace

TEST_CASE("gradient of a mixed scene agrees with differences of its energy") {
  const MixedScene scene(1);
  Workbench bench(scene);
  const Assembled exact = bench.assemble(scene.configuration);
  const int n = scene.dof_count();
  for (int i = 0; i < n; ++i) {
    const std::vector<double> direction = unit(n, i);
    const double slope =
        differentiate_scalar([&](double t) { return scene.energy(scene.along(direction, t)); }, 0.05);
    CHECK(std::fabs(slope - exact.gradient[i]) < 1e-9 * largest(exact.gradient));
  }
}

TEST_CASE(
    "Hessian of a mixed scene agrees with differences of its gradient, curvature of rotations included") {
  const MixedScene scene(1);
  Workbench bench(scene);
  const std::vector<double> H = bench.assemble(scene.configuration).hessian;
  const int n = scene.dof_count();
  // Along a fixed direction the retraction is a one-parameter group, so the slope there is the gradient times
  // the direction, and its derivative is d^T H d; mixed entries follow by polarisation.
  const auto second = [&](const std::vector<double>& direction) {
    return differentiate_scalar(
        [&](double t) { return dot(bench.assemble(scene.along(direction, t)).gradient, direction); }, 0.05);
  };
  std::vector<double> diagonal;
  for (int i = 0; i < n; ++i) diagonal.push_back(second(unit(n, i)));
  double worst = 0.0;
  for (int i = 0; i < n; ++i) {
    worst = std::fmax(worst, std::fabs(diagonal[i] - H[i * n + i]));
    for (int j = i + 1; j < n; ++j)
      worst = std::fmax(worst,
                        std::fabs(0.5 * (second(unit(n, i, j)) - diagonal[i] - diagonal[j]) - H[i * n + j]));
  }
  CHECK(worst < 1e-8 * largest(H));
}

TEST_CASE("the gradient alone is that of the full assembly, and energies are compared with its iterate") {
  const MixedScene scene(1);
  Workbench bench(scene);
  const Assembled full = bench.assemble(scene.configuration);
  const std::vector<Vec3> x = scene.positions(scene.configuration);
  const std::vector<double> direction(scene.dof_count(), 0.1);
  const Configuration moved = scene.along(direction, 1.0);
  std::vector<double> gradient(scene.dof_count(), 1e30);
  bench.assembler.assemble_gradient(moved, scene.positions(moved), gradient);
  const double back = bench.assembler.static_energy_difference(x).difference;
  bench.assembler.assemble_gradient(scene.configuration, x, gradient);
  for (size_t i = 0; i < gradient.size(); ++i)
    CHECK(std::fabs(gradient[i] - full.gradient[i]) <= 1e-13 * largest(full.gradient));
  CHECK(bench.assembler.static_energy_difference(x).difference == 0.0);
  CHECK(bench.assembler.static_energy_difference(scene.positions(moved)).difference ==
        doctest::Approx(-back).epsilon(1e-12));
  CHECK(std::fabs(back) > 1e-3);
}

TEST_CASE("blocks on the diagonal are the same where they alone are asked for") {
  const MixedScene scene(1);
  Workbench bench(scene);
  const Assembled all = bench.assemble(scene.configuration);
  const Assembled diagonal =
      bench.assemble(scene.configuration, {.project = false, .pending = {}, .pairs = ScatterPairs::Diagonal});
  for (int32_t b = 0; b < all.matrix.pattern.block_count; ++b)
    for (int64_t k = 9 * all.matrix.pattern.row_start[b]; k < 9 * all.matrix.pattern.row_start[b] + 9; ++k)
      CHECK(diagonal.matrix.values[k] == all.matrix.values[k]);
}

TEST_CASE("static and dynamic batches give the same sums") {
  const MixedScene scene(2);
  Workbench mixed(scene, 1, 1), all_static(scene, 1, 4);
  const Assembled a = mixed.assemble(scene.configuration), b = all_static.assemble(scene.configuration);
  for (size_t i = 0; i < a.gradient.size(); ++i)
    CHECK(std::fabs(a.gradient[i] - b.gradient[i]) <= 1e-13 * largest(b.gradient));
  for (size_t i = 0; i < a.hessian.size(); ++i)
    CHECK(std::fabs(a.hessian[i] - b.hessian[i]) <= 1e-13 * largest(b.hessian));
}

TEST_CASE("projected assembly is positive semidefinite and keeps the gradient") {
  const MixedScene scene(3);
  Workbench bench(scene);
  const int n = scene.dof_count();
  const Assembled raw = bench.assemble(scene.configuration);
  CHECK(bench.assembler.projected_element_count() == 0);
  const Assembled projected = bench.assemble(scene.configuration, {.project = true, .pending = {}});
  CHECK(bench.assembler.projected_element_count() > 0);
  CHECK(same_bits(raw.gradient, projected.gradient));
  CHECK(symmetric_eigenvalues(raw.hessian, n).front() < -1e-3);  // there is something to project
  CHECK(symmetric_eigenvalues(projected.hessian, n).front() > -1e-11 * largest(projected.hessian));
}

TEST_CASE("assembly has the same bits for 1, 2 and 5 threads, also with many coloured chunks") {
  // A strip of tetrahedral stencils on 2,000 points: about 30 chunks of 256 elements that share points with
  // neighbours, and springs from everywhere to one hub: more chunks in conflict than there are colours.
  constexpr int kPointCount = 2000;
  RandomPoints random(7);
  Configuration configuration;
  std::vector<Site> sites;
  for (int p = 0; p < kPointCount; ++p) {
    configuration.point_position.push_back(random.point());
    sites.push_back({.kind = SiteKind::Point, .index = p, .local = {}, .points = {}, .weights = {}});
  }
  std::vector<bool> prescribed(kPointCount, false);
  prescribed[17] = prescribed[1234] = true;
  configuration.body_position = {random.point()};
  configuration.body_rotation = {exp_rotation(random.point())};
  for (int k = 0; k < 50; ++k)
    sites.push_back(
        {.kind = SiteKind::RigidPoint, .index = 0, .local = random.point(), .points = {}, .weights = {}});
  const KinematicMap map(DofLayout::build(prescribed, {false}), sites);
  std::vector<int32_t> strip, star, mapped;
  for (int e = 0; e + 40 < 7 * kPointCount; ++e) {
    const int32_t p = e % (kPointCount - 40);
    for (const int32_t q : {p, p + 1 + e % 7, p + 9 + e % 11, p + 21 + e % 13}) strip.push_back(q);
  }
  for (int e = 0; e < 20000; ++e)
    for (const int32_t q : {1000, e % 999 + (e % 2 ? 1001 : 0)}) star.push_back(q);
  for (int e = 0; e < 3000; ++e)
    for (const int32_t q : {e % kPointCount, kPointCount + e % 50, (e * 7 + 1) % kPointCount})
      mapped.push_back(q);
  std::vector<PotentialBatch> batches;
  batches.push_back(make_batch(volume(), strip));
  batches.push_back(make_batch(spring(), star));
  batches.push_back(make_batch(area(), mapped));
  batches[1].set_uniform("stiffness", 1.0);
  std::vector<Vec3> x(map.site_count());
  map.positions(configuration, x);

  std::vector<double> gradient_1, energy_1;
  AlignedVector<double> values_1;
  for (const int threads : {1, 2, 5}) {
    ThreadPool pool(threads);
    Assembler assembler(map, pool);
    assembler.set_static_batches({&batches[0], &batches[1]});
    assembler.set_dynamic_batches({&batches[2]});
    std::vector<double> gradient(3 * map.layout().block_count);
    BlockMatrix hessian;
    assembler.assemble(configuration, x, {.project = true, .pending = {}}, gradient, hessian);
    std::vector<Vec3> shifted = x;
    for (Vec3& p : shifted) p += {0.01 * p.y, 0.0, 0.02 * p.x};
    const EnergyDifference difference = assembler.static_energy_difference(shifted);
    const std::vector<double> energy{difference.difference, difference.magnitude, assembler.static_energy(0)};
    if (threads == 1) {
      gradient_1 = gradient;
      values_1 = hessian.values;
      energy_1 = energy;
      // Independent sum over the elements, one at a time.
      std::vector<double> sum(gradient.size(), 0.0);
      for (size_t k = 0; k < batches.size(); ++k) {
        const PotentialBatch& batch = batches[k];
        const int points = batch.point_count(), outputs = 1 + 3 * points;
        AlignedVector<double> out(batch.block_count() * outputs * symbolic::kLanes);
        batch.evaluate(symbolic::Order::Gradient, x, 0, batch.block_count(), out.data());
        for (int64_t e = 0; e < batch.size(); ++e)
          for (int p = 0; p < points; ++p) {
            const int32_t site = batch.stencil(e)[p];
            if (site >= kPointCount || map.point_block(site) == kNoBlock) continue;
            for (int c = 0; c < 3; ++c)
              sum[3 * map.point_block(site) + c] +=
                  out[((e / symbolic::kLanes) * outputs + 1 + 3 * p + c) * symbolic::kLanes +
                      e % symbolic::kLanes];
          }
      }
      for (int i = 0; i < 3 * (kPointCount - 2); ++i)
        REQUIRE(std::fabs(sum[i] - gradient[i]) < 1e-11 * largest(gradient));
    } else {
      CAPTURE(threads);
      CHECK(same_bits(gradient, gradient_1));
      CHECK(same_bits(energy, energy_1));
      REQUIRE(hessian.values.size() == values_1.size());
      CHECK(std::memcmp(hessian.values.data(), values_1.data(), values_1.size() * sizeof(double)) == 0);
    }
  }
}

TEST_CASE(
    "differences of static energies are those of the total, with the magnitude of what was subtracted") {
  const MixedScene scene(5);
  ThreadPool pool(1);
  Assembler assembler(scene.map, pool);
  assembler.set_static_batches(scene.fixed(0, scene.batches.size()));
  std::vector<double> gradient(scene.dof_count());
  BlockMatrix hessian;
  const std::vector<Vec3> x = scene.positions(scene.configuration);
  assembler.assemble(scene.configuration, x, {}, gradient, hessian);
  std::vector<double> direction(scene.dof_count(), 0.3);
  const std::vector<Vec3> moved = scene.positions(scene.along(direction, 0.1));
  const EnergyDifference difference = assembler.static_energy_difference(moved);
  CHECK(difference.difference == doctest::Approx(scene.energy(moved) - scene.energy(x)).epsilon(1e-12));
  CHECK(difference.magnitude ==
        doctest::Approx(scene.energy(x)).epsilon(1e-12));  // all energies here are positive
  double sum = 0.0;
  for (size_t k = 0; k < scene.batches.size(); ++k) sum += assembler.static_energy(k);
  CHECK(sum == doctest::Approx(scene.energy(x)).epsilon(1e-12));
  CHECK(assembler.static_energy_difference(x).difference == 0.0);
}

TEST_CASE("with pending motion the gradient is the one at its end to first order") {
  const MixedScene scene(6);
  Workbench bench(scene);
  RandomPoints random(8);
  const std::vector<Vec3> x = scene.positions(scene.configuration);
  std::vector<Vec3> motion(scene.map.site_count());
  for (int32_t i = 0; i < scene.map.site_count(); ++i)
    if (scene.map.is_prescribed(i)) motion[i] = random.point();
  const auto error = [&](double size) {
    std::vector<Vec3> pending = motion, x_end = x;
    for (size_t i = 0; i < x.size(); ++i) {
      pending[i] *= size;
      x_end[i] += pending[i];
    }
    const std::vector<double> predicted =
        bench.assemble(scene.configuration, x, {.project = false, .pending = pending}).gradient;
    const std::vector<double> there = bench.assemble(scene.configuration, x_end).gradient;
    double worst = 0.0;
    for (size_t i = 0; i < predicted.size(); ++i)
      worst = std::fmax(worst, std::fabs(predicted[i] - there[i]));
    return worst;
  };
  // Second order: a tenth of the motion leaves a hundredth of the error.
  CHECK(error(1e-2) > 1e-6);
  CHECK(error(1e-3) / error(1e-2) == doctest::Approx(0.01).epsilon(0.2));
  CHECK(error(1e-4) / error(1e-3) == doctest::Approx(0.01).epsilon(0.2));
}
