// Formulas that are repeated elsewhere: same fields, same kernel, other expressions for their points.
#include <doctest/doctest.h>

#include <stark/mechanics/define.h>
#include <stark/mechanics/formula.h>
#include <support/potential_sample.h>

using namespace stark;
using namespace stark::test;
using symbolic::Backend;
using symbolic::Order;

namespace {

symbolic::Scalar spring(PotentialBuilder& b) {
  const auto k = b.parameter("stiffness", "N/m", "");
  const auto damping = b.data("damping", "N s/m", "");
  const auto strain = symbolic::norm(b.x(1) - b.x(0)) - symbolic::norm(b.X(1) - b.X(0));
  return 0.5 * k * strain * strain * symbolic::exp(-b.time()) +
         0.5 * damping * b.time_step() * symbolic::squared_norm(b.velocity(0)) +
         symbolic::dot(b.x(1), b.x_initial(1));
}

Formula trace_spring() {
  auto builder = std::make_shared<PotentialBuilder>(2);
  const auto energy = spring(*builder);
  return Formula(builder, {energy});
}

}  // namespace

TEST_CASE("a repeated formula is the same potential as the original") {
  const Potential original(define_potential("spring", 2, "", spring), Backend::Automatic);
  const Potential repeated(define_potential("spring", "", trace_spring()), Backend::Automatic);
  REQUIRE(repeated.element_fields().size() == original.element_fields().size());
  for (size_t k = 0; k < original.element_fields().size(); ++k) {
    CHECK(repeated.element_fields()[k].name == original.element_fields()[k].name);
    CHECK(repeated.element_fields()[k].offset == original.element_fields()[k].offset);
    CHECK(repeated.element_fields()[k].source == original.element_fields()[k].source);
  }
  std::mt19937_64 random(3);
  const FilledSample sample = fill_sample(define_potential("spring", 2, "", spring), original, random);
  CHECK(evaluate(original, sample, Order::Hessian, sample.x) ==
        evaluate(repeated, sample, Order::Hessian, sample.x));
}

TEST_CASE("parameters become element data where the batch has a value for each element") {
  const Potential potential(define_potential("spring", "", trace_spring()), Backend::Interpreter,
                            {"stiffness"});
  bool found = false;
  for (const ElementField& field : potential.element_fields())
    found = found || (field.name == "stiffness" && field.source == ElementField::Source::Data);
  CHECK(found);
  for (const UniformField& field : potential.uniform_fields()) CHECK(field.name != "stiffness");
}

TEST_CASE("points may be other expressions, and fields get a prefix") {
  const Formula formula = trace_spring();
  const auto definition = define_potential("middle", 3, "", [&](PotentialBuilder& b) {
    const auto middle = [&](auto at) { return 0.5 * ((b.*at)(0) + (b.*at)(1)); };
    return formula.repeat(b,
                          {.x = {middle(&PotentialBuilder::x), b.x(2)},
                           .x_prev = {middle(&PotentialBuilder::x_prev), b.x_prev(2)},
                           .X = {middle(&PotentialBuilder::X), b.X(2)},
                           .x_initial = {b.x_initial(0), b.x_initial(2)}},
                          "first.")[0];
  });
  const Potential potential(definition, Backend::Interpreter);
  std::mt19937_64 random(5);
  FilledSample sample = fill_sample(definition, potential, random);
  sample.x[1] = sample.x[0];
  sample.x_prev[1] = sample.x_prev[0];
  sample.X[1] = sample.X[0];
  CHECK(sample.values.contains("first.stiffness"));
  const Potential plain(define_potential("spring", 2, "", spring), Backend::Interpreter);
  FilledSample two = sample;
  for (auto* points : {&two.x, &two.X, &two.x_prev}) points->erase(points->begin());
  for (const char* name : {"stiffness", "damping"})
    two.values[name] = sample.values.at(std::string("first.") + name);
  CHECK(energy(potential, sample, sample.x) == doctest::Approx(energy(plain, two, two.x)).epsilon(1e-12));
}
