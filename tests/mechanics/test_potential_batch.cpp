// Batches: what is set is read back and reaches the right element; padding lanes repeat the last element; bad
// names throw.
#include <doctest/doctest.h>

#include <cmath>
#include <limits>

#include <stark/base/error.h>
#include <support/mixed_scene.h>

using namespace stark;
using namespace stark::test;
using symbolic::kLanes;
using symbolic::Order;

namespace {

/// log(size) |x - X|^2 / h + weight . (x - x_prev): NaN for zero size, every source of input.
PotentialDefinition probe() {
  PotentialDefinition definition = define_potential("probe", 1, "", [](PotentialBuilder& b) {
    return symbolic::log(b.data("size", "1", "")) * symbolic::squared_norm(b.x(0) - b.X(0)) / b.time_step() +
           b.parameter("scale", "1", "") * symbolic::dot(b.data3("weight", "1", ""), b.x(0) - b.x_prev(0));
  });
  definition.translation_invariant = definition.rotation_invariant = false;
  return definition;
}

}  // namespace

TEST_CASE("values set are read back, for every element and component") {
  PotentialBatch batch = make_batch(probe(), {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10});
  REQUIRE(batch.size() == 11);
  REQUIRE(batch.block_count() == 2);
  const int weight = batch.field_index("weight"), size = batch.field_index("size");
  CHECK(batch.get(weight, 10, 2) == 0.0);
  for (int64_t e = 0; e < batch.size(); ++e) {
    const double v = static_cast<double>(e);
    batch.set(weight, e, std::vector<double>{v, 10.0 * v, 100.0 * v});
    batch.set("size", e, v + 1.0);
  }
  for (int64_t e = 0; e < batch.size(); ++e) {
    for (int c = 0; c < 3; ++c) CHECK(batch.get(weight, e, c) == static_cast<double>(e) * std::pow(10.0, c));
    CHECK(batch.get(size, e) == static_cast<double>(e) + 1.0);
    CHECK(batch.stencil(e)[0] == e);
  }
}

TEST_CASE("names and widths that do not exist throw") {
  PotentialBatch batch = make_batch(probe(), {0});
  CHECK_THROWS_AS(batch.set_uniform("scales", 1.0), InternalError);
  CHECK_THROWS_AS(batch.set_uniform("size", 1.0), InternalError);  // element data, not a parameter
  CHECK_THROWS_AS(batch.field_index("scale"), InternalError);
  CHECK_THROWS(batch.set("weight", 0, 1.0));
  const std::vector<double> two{1.0, 2.0};
  CHECK_THROWS(batch.set_uniform("scale", two));
}

TEST_CASE("energies follow the inputs of their element; padding lanes repeat the last one") {
  RandomPoints random(1);
  for (const int count : {1, 7, 8, 9, 16, 70}) {
    CAPTURE(count);
    std::vector<int32_t> stencils;
    std::vector<Vec3> x, X, x_prev;
    for (int e = 0; e < count + 5; ++e) {
      x.push_back(random.point());
      X.push_back(random.point());
      x_prev.push_back(random.point());
    }
    for (int e = 0; e < count; ++e) stencils.push_back((e * 3 + 2) % (count + 5));
    PotentialBatch batch = make_batch(probe(), stencils);
    batch.set_rest(X);
    batch.set_previous(x_prev);
    batch.set_time(0.25, 1.0);
    batch.set_uniform("scale", 3.0);
    std::vector<Vec3> weight;
    for (int e = 0; e < count; ++e) {
      weight.push_back(random.point());
      batch.set("size", e, 1.5 + e);
      batch.set(batch.field_index("weight"), e, {&weight[e].x, 3});
    }
    AlignedVector<double> out(batch.block_count() * kLanes, 1e30);
    batch.evaluate(Order::Energy, x, 0, batch.block_count(), out.data());
    for (int e = 0; e < count; ++e) {
      const int s = stencils[e];
      const double expected =
          std::log(1.5 + e) * squared_norm(x[s] - X[s]) / 0.25 + 3.0 * dot(weight[e], x[s] - x_prev[s]);
      CHECK(out[e] == doctest::Approx(expected).epsilon(1e-12));
    }
    for (size_t l = count; l < out.size(); ++l) CHECK(out[l] == out[count - 1]);
    // A part of the blocks gives the same numbers as all of them.
    AlignedVector<double> last(kLanes);
    batch.evaluate(Order::Energy, x, batch.block_count() - 1, batch.block_count(), last.data());
    for (int l = 0; l < kLanes; ++l) CHECK(last[l] == out[(batch.block_count() - 1) * kLanes + l]);
  }
}

TEST_CASE("new elements start from zero and empty batches do nothing") {
  PotentialBatch batch = make_batch(probe(), {0, 1});
  batch.set("size", 1, 5.0);
  batch.resize(std::vector<int32_t>{1, 0, 1});
  CHECK(batch.get(batch.field_index("size"), 1) == 0.0);
  CHECK(batch.size() == 3);
  batch.resize({});
  CHECK(batch.size() == 0);
  CHECK(batch.block_count() == 0);
  batch.set_rest({});
  batch.set_previous({});
  batch.evaluate(Order::Hessian, {}, 0, 0, nullptr);
}

TEST_CASE("blocks of lanes in which all elements rest have zero outputs, others what they had") {
  const int count = 21 * static_cast<int>(kLanes);  // more than two groups
  std::vector<int32_t> stencils;
  std::vector<Vec3> x;
  for (int e = 0; e < count; ++e) {
    stencils.push_back(e);
    x.push_back({0.1 * e, 1.0, -0.3 * e});
  }
  PotentialBatch batch = make_batch(probe(), stencils);
  batch.set_rest(std::vector<Vec3>(count));
  batch.set_previous(std::vector<Vec3>(count));
  batch.set_uniform("scale", 1.0);
  batch.set_time(0.1, 0.0);
  for (int e = 0; e < count; ++e) batch.set("size", e, 2.0 + e);
  const std::vector<double> all = batch.evaluate(Order::Hessian, x);
  const size_t outputs = all.size() / count;
  const auto rests = [](int64_t e) { return e / kLanes % 3 != 1 || e % kLanes > 2; };
  batch.set_resting(rests);
  const std::vector<double> some = batch.evaluate(Order::Hessian, x);
  for (int64_t e = 0; e < count; ++e) {
    const bool is_idle = e / kLanes % 3 != 1;  // one element that acts is enough
    CHECK(batch.rests(e / kLanes) == is_idle);
    for (size_t k = 0; k < outputs; ++k)
      CHECK(some[e * outputs + k] == (is_idle ? 0.0 : all[e * outputs + k]));
  }
  batch.set_resting([](int64_t) { return false; });
  CHECK(batch.evaluate(Order::Hessian, x) == all);
}

TEST_CASE("potentials without a time step ignore it") {
  PotentialBatch batch = make_batch(spring(), {0, 1});
  batch.set_uniform("stiffness", 2.0);
  batch.set_time(0.1, 1.0);
  AlignedVector<double> out(kLanes);
  batch.evaluate(Order::Energy, std::vector<Vec3>{{0, 0, 0}, {3, 0, 0}}, 0, 1, out.data());
  CHECK(out[0] == doctest::Approx(9.0).epsilon(1e-15));
}

TEST_CASE("the reference of a measure is its own extrapolation: exact for squares, third order for others") {
  const auto reference_of = [](int power) {
    PotentialDefinition definition = define_potential("reference", 1, "", [power](PotentialBuilder& b) {
      return b.x(0)[0] * b.reference([&](auto point) {
        const symbolic::Scalar x = (b.*point)(0)[0];
        return power == 2 ? x * x : x * x * x * x;
      });
    });
    definition.translation_invariant = definition.rotation_invariant = false;
    return definition;
  };
  const double c = 1.0 / 3.0, before = 0.7;
  const auto error = [&](int power, double way) {
    const double now = before + way, d = std::sqrt(c + c * c) * way;
    const auto g = [&](double x) { return std::pow(x, power); };
    PotentialBatch batch = make_batch(reference_of(power), {0});
    const std::vector<Vec3> unit{{1, 0, 0}}, start{{now, 0, 0}}, bar{{now + c * way, 0, 0}},
        beyond{{now + c * way + d, 0, 0}};
    batch.set_previous(start);
    CHECK(batch.evaluate(Order::Energy, unit)[0] == doctest::Approx(g(now)).epsilon(1e-15));
    batch.set_previous(bar);
    batch.set_beyond(beyond);
    return batch.evaluate(Order::Energy, unit)[0] - (g(now) + c * (g(now) - g(before)));
  };
  CHECK(std::fabs(error(2, 0.3)) < 1e-15);
  CHECK(std::fabs(error(2, 0.1)) < 1e-15);
  CHECK(error(4, 0.1) / error(4, 0.05) == doctest::Approx(8.0).epsilon(0.2));
}

TEST_CASE("of a one-sided potential only blocks with energy are evaluated, with the same bits") {
  PotentialDefinition definition = define_potential("one_sided", 1, "", [](PotentialBuilder& b) {
    const auto excess = symbolic::max(b.x(0)[0] - b.parameter("limit", "1", ""), 0.0);
    return excess * excess * excess;
  });
  definition.translation_invariant = definition.rotation_invariant = false;
  for (const bool one_sided : {false, true}) {
    definition.one_sided = one_sided;
    std::vector<int32_t> stencils;
    std::vector<Vec3> x;
    for (int e = 0; e < 60; ++e) {
      stencils.push_back(e);
      const bool acts =
          e == 3 || (e >= 16 && e < 40) || e == 59;  // blocks 0, 2, 3, 4 and 7, the last one short
      x.push_back({acts ? 1.0 + 0.1 * e : 0.5, 0.0, 0.0});
    }
    PotentialBatch batch = make_batch(definition, stencils);
    batch.set_uniform("limit", 1.0);
    const int outputs = batch.potential().kernel().output_count(Order::Hessian);
    AlignedVector<double> all(static_cast<size_t>(8) * outputs * kLanes), some(all.size());
    batch.evaluate(Order::Hessian, x, 0, 8, all.data());
    const PotentialBatch::ActiveBlocks active = batch.evaluate_active(Order::Hessian, x, 0, 8, some.data());
    const std::vector<int64_t> expected =
        one_sided ? std::vector<int64_t>{0, 2, 3, 4, 7} : std::vector<int64_t>{0, 1, 2, 3, 4, 5, 6, 7};
    REQUIRE(active.count == static_cast<int>(expected.size()));
    for (int k = 0; k < active.count; ++k) {
      CHECK(active.blocks[k] == expected[k]);
      for (int64_t i = 0; i < outputs * kLanes; ++i)
        CHECK(some[k * outputs * kLanes + i] == all[expected[k] * outputs * kLanes + i]);
    }
  }
}
