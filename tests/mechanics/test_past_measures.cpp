// Measures of the past in formulas: found, corrected as PotentialBuilder::reference does, or left as they
// are.
#include <doctest/doctest.h>

#include <cmath>

#include <stark/mechanics/past_measures.h>
#include <stark/mechanics/potential_batch.h>

using namespace stark;
using doctest::Approx;
using symbolic::Scalar;

namespace {

using Written = std::function<Scalar(PotentialBuilder&)>;

/// Energy of a point at x with references, for a place at the start and one beyond it.
double energy_of(const Written& formula, const Vec3& x, const Vec3& previous, const Vec3& beyond) {
  PotentialBuilder builder(1);
  const Scalar energy = with_references(builder, formula(builder));
  PotentialBatch batch(
      std::make_shared<const Potential>("energy", builder, energy, symbolic::Backend::Interpreter));
  const int32_t stencil[] = {0};
  batch.resize(stencil);
  batch.set_previous({&previous, 1});
  batch.set_beyond({&beyond, 1});
  return batch.energies({&x, 1})[0];
}

double reference(double here, double beyond, double behind) { return 2.0 * here - 0.5 * (beyond + behind); }

}  // namespace

TEST_CASE("a measure of the start alone gets its reference, also inside of others") {
  const Vec3 x{1.2, 0.4, 0.1}, previous{1.0, 0.2, 0.0}, beyond{1.1, 0.35, 0.05};
  const Vec3 behind = 2.0 * previous - beyond;
  const auto length = [](const Vec3& p) { return std::log(norm(p)); };
  const Written formula = [](PotentialBuilder& b) {
    return pow(log(norm(b.x(0))) - log(norm(b.x_prev(0))), 2) * b.x(0)[1] + b.x_prev(0)[0] * b.x(0)[0];
  };
  const double rate = length(x) - reference(length(previous), length(beyond), length(behind));
  CHECK(energy_of(formula, x, previous, beyond) ==
        Approx(rate * rate * x.y + previous.x * x.x).epsilon(1e-14));
  // Without a history, nothing changes.
  const double plain = length(x) - length(previous);
  CHECK(energy_of(formula, x, previous, previous) ==
        Approx(plain * plain * x.y + previous.x * x.x).epsilon(1e-14));
}

TEST_CASE("linear measures, references and conditions stay as they are") {
  const std::vector<Written> formulas{
      [](PotentialBuilder& b) { return squared_norm(b.velocity(0)); },
      [](PotentialBuilder& b) { return b.x(0)[0] * (3.0 * b.x_prev(0)[1] - b.x_prev(0)[2] / 7.0); },
      [](PotentialBuilder& b) {
        return b.x(0)[0] - b.reference([&](PotentialBuilder::Position p) { return norm((b.*p)(0)); });
      },
      [](PotentialBuilder& b) { return select(norm(b.x_prev(0)) < 1.0, b.x(0)[0], b.x(0)[1]); },
      [](PotentialBuilder&) { return Scalar(2.0); }};
  for (const Written& formula : formulas) {
    PotentialBuilder builder(1);
    const Scalar energy = formula(builder);
    CHECK(is_same(with_references(builder, energy), energy));
  }
}

TEST_CASE("what jumps, or is no number beyond, is not corrected") {
  const Vec3 x{-1.0, 0.1, 0.0}, previous{-1.0, 0.01, 0.0}, beyond{-1.0, -0.02, 0.0};
  const Written angle = [](PotentialBuilder& b) { return b.x(0)[0] + atan2(b.x_prev(0)[1], b.x_prev(0)[0]); };
  CHECK(energy_of(angle, x, previous, beyond) == Approx(-1.0 + std::atan2(0.01, -1.0)).epsilon(1e-14));
  const Written root = [](PotentialBuilder& b) { return b.x(0)[0] + sqrt(b.x_prev(0)[1]); };
  CHECK(energy_of(root, x, previous, beyond) == Approx(-1.0 + 0.1).epsilon(1e-14));
}

TEST_CASE("numbers of a vector are corrected in any axes, also where one of them is at its extreme") {
  const Vec3 previous{0.6, 0.8, 0.0}, beyond{0.6, 0.8, 0.2}, x{0.1, 0.2, 0.3};
  const Written direction = [](PotentialBuilder& b) { return dot(b.x(0), b.x_prev(0) / norm(b.x_prev(0))); };
  const double seen = energy_of(direction, x, previous, beyond);
  const Vec3 side = normalized(beyond), other = normalized(2.0 * previous - beyond);
  const Vec3 expected = 2.0 * previous - (side + other) * 0.5;
  CHECK(seen == Approx(dot(x, expected)).epsilon(1e-14));
}
