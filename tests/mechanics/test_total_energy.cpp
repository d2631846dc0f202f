// Energies of totals against differences, alone and assembled: gradients, Hessians with their part of low
// rank, pending motion, small changes, and what has no meaning.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include <stark/base/error.h>
#include <stark/mechanics/site_gradient.h>
#include <stark/mechanics/total_energy.h>
#include <support/finite_differences.h>
#include <support/mixed_scene.h>

using namespace stark;
using namespace stark::test;
using symbolic::Scalar;
using symbolic::total;

namespace {

/// Two totals of pairs of points, and a function of them that is convex nowhere near.
PotentialDefinition pairs() {
  return define_potential("pairs", 2, "of two totals", [](PotentialBuilder& b) {
    const Scalar weight = b.data("weight", "1", "of an element");
    const Scalar scale = b.parameter("scale", "J", "of the energy");
    const Scalar spread = total(weight * symbolic::squared_norm(b.x(1) - b.x(0)));
    const Scalar mixed = total(symbolic::dot(b.x(0), b.x(1)));
    return scale * (symbolic::log(1.0 + spread * spread) + 0.1 * spread * mixed - 0.02 * mixed * mixed);
  });
}

PotentialBatch batch_of_pairs(const MixedScene& scene, unsigned seed) {
  RandomPoints random(seed);
  std::vector<int32_t> stencils;
  for (int e = 0; e < 21; ++e) {
    const int32_t a = random.integer(0, scene.map.site_count() - 1);
    const int32_t b = random.integer(0, scene.map.site_count() - 1);
    stencils.insert(stencils.end(), {a, b});
  }
  PotentialBatch batch = make_batch(pairs(), stencils);
  batch.set_uniform("scale", 1.3);
  for (int64_t e = 0; e < batch.size(); ++e) batch.set("weight", e, random.uniform(0.1, 0.3));
  return batch;
}

struct Bench {
  explicit Bench(unsigned seed)
      : scene(seed), batch(batch_of_pairs(scene, seed)), pool(2), assembler(scene.map, pool) {
    assembler.set_static_batches({&batch});
  }
  Assembled assemble(const Configuration& c, const AssemblyOptions& options = {}) {
    Assembled result;
    result.gradient.assign(scene.dof_count(), 1e30);
    assembler.assemble(c, scene.positions(c), options, result.gradient, result.matrix);
    result.hessian = to_dense(result.matrix);
    const size_t n = result.gradient.size();
    const LowRank& beside = assembler.low_rank();
    for (size_t k = 0; k < beside.factors.size(); ++k)
      for (size_t i = 0; i < n; ++i)
        for (size_t j = 0; j < n; ++j)
          result.hessian[i * n + j] += beside.factors[k] * beside.columns[k][i] * beside.columns[k][j];
    return result;
  }

  MixedScene scene;
  PotentialBatch batch;
  ThreadPool pool;
  Assembler assembler;
};

double largest(const std::vector<double>& values) {
  double result = 0.0;
  for (const double v : values) result = std::fmax(result, std::fabs(v));
  return result;
}

std::vector<double> unit(int n, int i, int j) {
  std::vector<double> direction(n, 0.0);
  direction[i] += 1.0;
  if (j != i) direction[j] += 1.0;
  return direction;
}

}  // namespace

TEST_CASE("gradient of an energy of totals agrees with differences, through every kind of site") {
  Bench bench(3);
  const Assembled exact = bench.assemble(bench.scene.configuration);
  const int n = bench.scene.dof_count();
  for (int i = 0; i < n; ++i) {
    const std::vector<double> direction = unit(n, i, i);
    const double slope = differentiate_scalar(
        [&](double t) {
          return total_energy(bench.batch, bench.scene.positions(bench.scene.along(direction, t)));
        },
        0.02);
    CHECK(std::fabs(slope - exact.gradient[i]) < 1e-8 * largest(exact.gradient));
  }
}

TEST_CASE("its Hessian is that of the blocks and the terms of low rank") {
  Bench bench(3);
  const std::vector<double> H = bench.assemble(bench.scene.configuration).hessian;
  CHECK(bench.assembler.low_rank().factors.size() == 2);
  const int n = bench.scene.dof_count();
  const auto second = [&](const std::vector<double>& direction) {
    return differentiate_scalar(
        [&](double t) {
          const std::vector<double> g = bench.assemble(bench.scene.along(direction, t)).gradient;
          double sum = 0.0;
          for (int i = 0; i < n; ++i) sum += g[i] * direction[i];
          return sum;
        },
        0.02);
  };
  std::vector<double> diagonal;
  for (int i = 0; i < n; ++i) diagonal.push_back(second(unit(n, i, i)));
  double worst = 0.0;
  for (int i = 0; i < n; ++i) {
    worst = std::fmax(worst, std::fabs(diagonal[i] - H[i * n + i]));
    for (int j = i + 1; j < n; ++j)
      worst = std::fmax(worst,
                        std::fabs(0.5 * (second(unit(n, i, j)) - diagonal[i] - diagonal[j]) - H[i * n + j]));
  }
  CHECK(worst < 1e-7 * largest(H));
}

TEST_CASE("projected, the terms of low rank add no negative curvature") {
  Bench bench(3);
  bench.assemble(bench.scene.configuration);
  CHECK(std::ranges::any_of(bench.assembler.low_rank().factors, [](double c) { return c < 0.0; }));
  bench.assemble(bench.scene.configuration, {.project = true, .pending = {}, .pairs = ScatterPairs::All});
  CHECK(std::ranges::all_of(bench.assembler.low_rank().factors, [](double c) { return c > 0.0; }));
}

TEST_CASE("the gradient anticipates prescribed motion through the totals") {
  Bench bench(3);
  const std::vector<Vec3> x = bench.scene.positions(bench.scene.configuration);
  std::vector<Vec3> pending(x.size());
  for (size_t i = 0; i < x.size(); ++i)
    if (bench.scene.map.is_prescribed(static_cast<int32_t>(i))) pending[i] = {0.3, -0.2, 0.1};
  const Assembled with = bench.assemble(bench.scene.configuration,
                                        {.project = false, .pending = pending, .pairs = ScatterPairs::All});
  const std::vector<double> still = bench.assemble(bench.scene.configuration).gradient;
  const auto gradient_after = [&](double t) {
    std::vector<Vec3> moved = x;
    for (size_t i = 0; i < x.size(); ++i) moved[i] += pending[i] * t;
    std::vector<double> gradient(bench.scene.dof_count());
    bench.assembler.assemble_gradient(bench.scene.configuration, moved, gradient);
    return gradient;
  };
  const std::vector<double> change = differentiate(gradient_after, 0.02);
  for (size_t i = 0; i < still.size(); ++i)
    CHECK(std::fabs(still[i] + change[i] - with.gradient[i]) < 1e-8 * largest(with.gradient));
}

TEST_CASE("energies of trials are those of the totals, small changes to their own digits") {
  PotentialBatch batch = make_batch(define_potential("gas", 2, "",
                                                     [](PotentialBuilder& b) {
                                                       const Scalar T =
                                                           total(symbolic::squared_norm(b.x(1) - b.x(0)));
                                                       return 1e5 * (T - 2.0 * symbolic::log(T));
                                                     }),
                                    {0, 1, 1, 2});
  std::vector<Vec3> x = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}};
  batch.touch(x);
  CHECK(batch.plane().totals == std::vector<double>{2.0});
  CHECK(std::fabs(batch.plane().slopes[0]) < 1e-9);
  // f'' = 1e5 2 / T^2; the change of T is exact.
  const double d = 0x1p-28;
  x[2].y += d;
  const double change = 2.0 * d + d * d, expected = 1e5 * (change - 2.0 * std::log1p(change / 2.0));
  CHECK(expected == doctest::Approx(0.5e5 / 2.0 * change * change).epsilon(1e-6));
  CHECK(batch.change_of_totals(x).difference == doctest::Approx(0.5e5 / 2.0 * change * change).epsilon(1e-6));
  x[2].y = 3.0;
  const double far = 10.0;
  CHECK(batch.change_of_totals(x).difference ==
        doctest::Approx(1e5 * (far - 2.0 * std::log(far) - 2.0 + 2.0 * std::log(2.0))).epsilon(1e-12));
}

TEST_CASE("gradients of sites and energies of elements are those at the positions that are asked for") {
  const MixedScene scene(7);
  const PotentialBatch batch = batch_of_pairs(scene, 7);
  std::vector<Vec3> x = scene.positions(scene.configuration), gradient(x.size());
  add_site_gradient(batch, x, 1.0, gradient);
  const double energy = total_energy(batch, x);
  double sum = 0.0;
  for (const double e : batch.energies(x)) sum += e;
  CHECK(sum == doctest::Approx(energy).epsilon(1e-12));
  const auto along = [&](double t) {
    std::vector<Vec3> y = x;
    y[2].x += t;
    return total_energy(batch, y);
  };
  CHECK(differentiate_scalar(along, 0.02) == doctest::Approx(gradient[2].x).epsilon(1e-9));
}

TEST_CASE("energies of totals that mean nothing are refused") {
  const auto refused = [](const std::function<Scalar(PotentialBuilder&)>& energy, const char* part) {
    const PotentialDefinition definition = define_potential("wrong", 2, "", energy);
    std::string message;
    try {
      const Potential potential(definition, symbolic::Backend::Automatic);
    } catch (const InvalidArgument& error) {
      message = error.what();
    }
    CAPTURE(message);
    CHECK(message.find(part) != std::string::npos);
  };
  const auto length = [](PotentialBuilder& b) { return symbolic::norm(b.x(1) - b.x(0)); };
  refused([&](PotentialBuilder& b) { return total(length(b)) * length(b); }, "position of point");
  refused([&](PotentialBuilder& b) { return total(length(b)) * b.data("weight", "1", ""); }, "'weight'");
  refused([&](PotentialBuilder& b) { return total(total(length(b)) * length(b)); }, "within total");
}

TEST_CASE("formulas tell equal energies of totals, and others, by their fingerprints") {
  const auto fingerprint = [](double factor) {
    const Potential potential(define_potential("e", 2, "",
                                               [&](PotentialBuilder& b) {
                                                 const Scalar T = total(symbolic::norm(b.x(1) - b.x(0)));
                                                 return factor * T * T;
                                               }),
                              symbolic::Backend::Automatic);
    return potential.totals()->fingerprint();
  };
  CHECK(fingerprint(1.5) == fingerprint(1.5));
  CHECK(fingerprint(1.5) != fingerprint(2.5));
}
