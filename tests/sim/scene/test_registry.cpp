// Every registered potential against independent oracles: derivatives by finite differences, symmetry,
// invariance, definiteness after projection, and the same bits from the interpreter and from machine code. A
// new potential is tested by its line in sim/scene/registry.inc alone.
#include <doctest/doctest.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <set>

#include <stark/base/psd.h>
#include <stark/sim/scene/registry.h>
#include <support/finite_differences.h>
#include <support/potential_sample.h>
#include <support/symmetric_eigen.h>

using namespace stark;
using namespace stark::test;
using symbolic::Backend;
using symbolic::Order;

namespace {

constexpr int kSamples = 12;

double largest(const std::vector<double>& values) {
  double result = 0.0;
  for (const double v : values) result = std::fmax(result, std::fabs(v));
  return result;
}

double largest_difference(const std::vector<double>& a, const std::vector<double>& b) {
  double result = 0.0;
  for (size_t i = 0; i < a.size(); ++i) result = std::fmax(result, std::fabs(a[i] - b[i]));
  return result;
}

bool same_bits(const std::vector<double>& a, const std::vector<double>& b) {
  for (size_t i = 0; i < a.size(); ++i)
    if (std::bit_cast<uint64_t>(a[i]) != std::bit_cast<uint64_t>(b[i])) return false;
  return a.size() == b.size();
}

std::vector<Vec3> moved(const std::vector<Vec3>& x, const Mat3& R, const Vec3& shift) {
  std::vector<Vec3> y;
  for (const Vec3& p : x) y.push_back(R * p + shift);
  return y;
}

std::vector<Vec3> perturbed(std::vector<Vec3> x, int i, double step) {
  x[i / 3][i % 3] += step;
  return x;
}

/// Smallest distance of two points of the stencil [m]: the length on which the energy bends.
double smallest_extent(const std::vector<Vec3>& x) {
  double extent = 1.0;
  for (size_t i = 0; i < x.size(); ++i)
    for (size_t j = 0; j < i; ++j) extent = std::fmin(extent, norm(x[i] - x[j]));
  return extent;
}

/// Calls check(definition, compiled, sample) for every registered potential and several samples of each.
template <typename Check>
void sweep(Check&& check) {
  for (const PotentialDefinition& definition : registered_potentials()) {
    CAPTURE(definition.name);
    const Potential potential(definition, Backend::Automatic);
    std::mt19937_64 random(7);
    for (int k = 0; k < kSamples; ++k) {
      CAPTURE(k);
      check(definition, potential, fill_sample(definition, potential, random));
    }
  }
}

}  // namespace

TEST_CASE("names of registered potentials are unique and every one says what it is") {
  std::set<std::string> names;
  for (const PotentialDefinition& definition : registered_potentials()) {
    CHECK_MESSAGE(names.insert(definition.name).second, definition.name);
    CHECK_MESSAGE(!definition.doc.empty(), definition.name);
    const Potential potential(definition, Backend::Interpreter);
    for (const ElementField& field : potential.element_fields())
      CHECK_MESSAGE((!field.unit.empty() && !field.doc.empty()), definition.name << ": " << field.name);
    for (const UniformField& field : potential.uniform_fields())
      CHECK_MESSAGE((!field.unit.empty() && !field.doc.empty()), definition.name << ": " << field.name);
  }
  CHECK(names.size() >= 19);
}

TEST_CASE("samples are finite and not trivial") {
  for (const PotentialDefinition& definition : registered_potentials()) {
    CAPTURE(definition.name);
    const Potential potential(definition, Backend::Automatic);
    std::mt19937_64 random(7);
    double strongest = 0.0;
    for (int k = 0; k < kSamples; ++k) {
      const FilledSample sample = fill_sample(definition, potential, random);
      for (const double v : evaluate(potential, sample, Order::Hessian, sample.x)) CHECK(std::isfinite(v));
      strongest = std::fmax(strongest, largest(gradient(potential, sample, sample.x)));
    }
    CHECK(strongest > 1e-3);  // a sweep over zero forces would prove nothing
  }
}

TEST_CASE("gradients agree with differences of the energy") {
  sweep([](const PotentialDefinition&, const Potential& potential, const FilledSample& sample) {
    const std::vector<double> exact = gradient(potential, sample, sample.x);
    const double step = 0.05 * smallest_extent(sample.x);
    std::vector<double> approximate;
    for (size_t i = 0; i < exact.size(); ++i)
      approximate.push_back(differentiate_scalar(
          [&](double t) { return energy(potential, sample, perturbed(sample.x, static_cast<int>(i), t)); },
          step));
    // The best extrapolated difference is good for about ten digits of energy over length.
    const double scale = largest(exact) + std::fabs(energy(potential, sample, sample.x));
    CHECK(largest_difference(exact, approximate) <= 1e-6 * scale);
  });
}

TEST_CASE("Hessians agree with differences of the gradient, which also shows their symmetry") {
  sweep([](const PotentialDefinition&, const Potential& potential, const FilledSample& sample) {
    const std::vector<double> exact = hessian(potential, sample, sample.x);
    const int n = 3 * potential.point_count();
    double error = std::numeric_limits<double>::infinity();
    // The second, smaller step serves samples close to a jump of the third derivative, as at the end of
    // sticking.
    for (const double relative_step : {0.05, 5e-4}) {
      std::vector<double> rows;
      for (int i = 0; i < n; ++i) {
        const std::vector<double> row =
            differentiate([&](double t) { return gradient(potential, sample, perturbed(sample.x, i, t)); },
                          relative_step * smallest_extent(sample.x));
        rows.insert(rows.end(), row.begin(), row.end());
      }
      // hessian() mirrors the stored triangle; the full matrix of differences does not know about that.
      error = std::fmin(error, largest_difference(exact, rows));
    }
    CHECK(error <= 1e-6 * (largest(exact) + largest(gradient(potential, sample, sample.x))));
  });
}

TEST_CASE("declared invariance under translation holds for energy, gradient and the rows of the Hessian") {
  sweep([](const PotentialDefinition& definition, const Potential& potential, const FilledSample& sample) {
    if (!definition.translation_invariant) return;
    const double E = energy(potential, sample, sample.x);
    const std::vector<double> g = gradient(potential, sample, sample.x),
                              H = hessian(potential, sample, sample.x);
    // A shift of the unknown positions alone: what the projection of element Hessians relies on.
    const double E_moved = energy(potential, sample, moved(sample.x, Mat3::identity(), {0.3, -0.7, 0.2}));
    CHECK(E_moved == doctest::Approx(E).epsilon(1e-10));
    const int n = static_cast<int>(g.size());
    for (int c = 0; c < 3; ++c) {
      double force = 0.0;
      for (int p = 0; p < n / 3; ++p) force += g[3 * p + c];
      CHECK(std::fabs(force) <= 1e-11 * (largest(g) + std::fabs(E)));
      for (int i = 0; i < n; ++i) {
        double row = 0.0;
        for (int p = 0; p < n / 3; ++p) row += H[i * n + 3 * p + c];
        CHECK(std::fabs(row) <= 1e-10 * largest(H));
      }
    }
  });
}

TEST_CASE("declared invariance under rotation of the motion holds: rest shape and data stay") {
  std::mt19937_64 random(11);
  sweep([&](const PotentialDefinition& definition, const Potential& potential, const FilledSample& sample) {
    if (!definition.rotation_invariant) return;
    const Mat3 R = exp_rotation(random_vector(random, 2.0));
    FilledSample turned = sample;
    turned.x = moved(sample.x, R, {});
    turned.x_prev = moved(sample.x_prev, R, {});
    const double E = energy(potential, sample, sample.x);
    CHECK(energy(potential, turned, turned.x) == doctest::Approx(E).epsilon(1e-10));
    const std::vector<double> g = gradient(potential, sample, sample.x),
                              g_turned = gradient(potential, turned, turned.x);
    Vec3 torque;
    double size = 0.0;
    for (int p = 0; p < potential.point_count(); ++p) {
      const Vec3 f{g[3 * p], g[3 * p + 1], g[3 * p + 2]};
      const Vec3 f_turned{g_turned[3 * p], g_turned[3 * p + 1], g_turned[3 * p + 2]};
      CHECK(max_abs(R * f - f_turned) <= 1e-9 * (largest(g) + std::fabs(E)));
      torque += cross(sample.x[p], f);
      size += norm(sample.x[p]) * norm(f);
    }
    // Without memory of the previous position no torque is left.
    bool remembers = false;
    for (const ElementField& field : potential.element_fields())
      remembers = remembers || field.source == ElementField::Source::Previous;
    if (!remembers) CHECK(norm(torque) <= 1e-11 * (size + std::fabs(E)));
  });
}

TEST_CASE("no energy prefers a direction of space: all vectors turned together leave it unchanged") {
  std::mt19937_64 random(13);
  sweep([&](const PotentialDefinition&, const Potential& potential, const FilledSample& sample) {
    const Mat3 R = exp_rotation(random_vector(random, 2.0));
    FilledSample turned = sample;
    turned.X = moved(sample.X, R, {});
    turned.x_prev = moved(sample.x_prev, R, {});
    turned.x = moved(sample.x, R, {});
    for (auto& [name, value] : turned.values)
      if (value.size() == 3) {
        const Vec3 v = R * Vec3{value[0], value[1], value[2]};
        value = {v.x, v.y, v.z};
      }
    CHECK(energy(potential, turned, turned.x) ==
          doctest::Approx(energy(potential, sample, sample.x)).epsilon(1e-10));
  });
}

TEST_CASE("potentials declared one-sided have no derivatives where they have no energy") {
  int tested = 0, acting = 0;
  sweep([&](const PotentialDefinition& definition, const Potential& potential, const FilledSample& sample) {
    if (!definition.one_sided) return;
    if (energy(potential, sample, sample.x) > 0.0) ++acting;
    CHECK(potential.is_one_sided());
    std::vector<Vec3> shrunk;
    for (const Vec3& p : sample.X) shrunk.push_back(p * 0.9);
    CHECK(energy(potential, sample, shrunk) == 0.0);
    CHECK(largest(gradient(potential, sample, shrunk)) == 0.0);
    CHECK(largest(hessian(potential, sample, shrunk)) == 0.0);
    ++tested;
  });
  CHECK(tested >= 3 * kSamples);
  CHECK(acting > tested / 2);
}

TEST_CASE("potentials declared zero at rest have neither energy nor force there") {
  int tested = 0;
  sweep([&](const PotentialDefinition& definition, const Potential& potential, const FilledSample& sample) {
    if (!definition.zero_at_rest) return;
    FilledSample rest = sample;
    // Directions among the points only turn.
    const Vec3 shift = definition.translation_invariant ? Vec3{0.1, 0.2, 0.3} : Vec3{};
    rest.x_prev = rest.x = moved(sample.X, exp_rotation({0.3, -0.5, 0.2}), shift);
    // Moduli are of order one; so would be energies of order-one strains.
    CHECK(std::fabs(energy(potential, rest, rest.x)) <= 1e-13);
    CHECK(largest(gradient(potential, rest, rest.x)) <= 1e-12);
    ++tested;
  });
  CHECK(tested >= 5 * kSamples);
}

TEST_CASE("projected Hessians are positive semidefinite and definite ones are left alone") {
  using symbolic::kLanes;
  int changed = 0;
  sweep([&](const PotentialDefinition&, const Potential& potential, const FilledSample& sample) {
    const int n = 3 * potential.point_count();
    const std::vector<double> H = hessian(potential, sample, sample.x);
    AlignedVector<double> upper(n * (n + 1) / 2 * kLanes);
    int slot = 0;
    for (int i = 0; i < n; ++i)
      for (int j = i; j < n; ++j, ++slot)
        for (int l = 0; l < kLanes; ++l) upper[slot * kLanes + l] = H[i * n + j];
    psd_project(upper.data(), n, psd_test(upper.data(), n),
                potential.is_translation_invariant() && n >= 6 && n <= 12);
    std::vector<double> projected(n * n);
    slot = 0;
    for (int i = 0; i < n; ++i)
      for (int j = i; j < n; ++j, ++slot) projected[i * n + j] = projected[j * n + i] = upper[slot * kLanes];
    const std::vector<double> before = symmetric_eigenvalues(H, n),
                              after = symmetric_eigenvalues(projected, n);
    const double scale = largest(H) + 1e-300;
    CHECK(after.front() >= -1e-11 * scale);
    if (before.front() >= -1e-14 * scale) CHECK(same_bits(projected, H));
    changed += before.front() < -1e-9 * scale;
    // Positive curvature survives: the nearest matrix keeps the positive part of the spectrum.
    CHECK(after.back() == doctest::Approx(std::fmax(before.back(), 0.0)).epsilon(1e-9));
  });
  CHECK(changed > 0);  // the samples do reach indefinite states
}

TEST_CASE("interpreter and machine code give the same bits in every order") {
  for (const PotentialDefinition& definition : registered_potentials()) {
    CAPTURE(definition.name);
    const Potential compiled(definition, Backend::Automatic), interpreted(definition, Backend::Interpreter);
    REQUIRE(interpreted.kernel().backend() == Backend::Interpreter);
    std::mt19937_64 random(7);
    for (int k = 0; k < kSamples; ++k) {
      const FilledSample sample = fill_sample(definition, compiled, random);
      for (const Order order : {Order::Energy, Order::Gradient, Order::Hessian})
        CHECK(same_bits(evaluate(compiled, sample, order, sample.x),
                        evaluate(interpreted, sample, order, sample.x)));
    }
  }
}

TEST_CASE("energy and gradient have the same bits in every order") {
  sweep([](const PotentialDefinition&, const Potential& potential, const FilledSample& sample) {
    const std::vector<double> E = evaluate(potential, sample, Order::Energy, sample.x);
    const std::vector<double> g = evaluate(potential, sample, Order::Gradient, sample.x);
    const std::vector<double> H = evaluate(potential, sample, Order::Hessian, sample.x);
    CHECK(same_bits({E[0]}, {g[0]}));
    CHECK(same_bits({E[0]}, {H[0]}));
    // The gradient may be summed in another order next to the Hessian, but not be another number.
    CHECK(largest_difference(g, {H.begin(), H.begin() + static_cast<long>(g.size())}) <=
          1e-12 * (largest(g) + 1e-300));
  });
}
