// Writing and composing potentials: fields by name, declarations that contradict each other, shared
// subexpressions.
#include <doctest/doctest.h>

#include <stark/base/error.h>
#include <stark/mechanics/define.h>
#include <support/potential_sample.h>

using namespace stark;
using namespace stark::test;
using symbolic::Backend;

namespace {

PotentialDefinition stretch(const std::string& name, const std::string& stiffness, double power_of_two) {
  return define_potential(name, 2, "stretch", [=](PotentialBuilder& b) {
    const auto strain = symbolic::norm(b.x(1) - b.x(0)) / symbolic::norm(b.X(1) - b.X(0)) - 1.0;
    return power_of_two * b.parameter(stiffness, "J", "stiffness") * b.data("volume", "1", "size") *
           symbolic::square(strain);
  });
}

}  // namespace

TEST_CASE("fields are laid out without gaps, each name once, in the order of first use") {
  const PotentialDefinition definition = define_potential("mixed", 2, "", [](PotentialBuilder& b) {
    const auto a = b.data3("direction", "1", "");
    const auto m = b.data("mass", "kg", "");
    const auto again = b.data3("direction", "1", "");
    return m * symbolic::dot(a + again, b.x(0) - b.x_prev(0) + b.X(1)) * b.parameter("k", "1", "") /
               b.time_step() +
           symbolic::dot(b.parameter3("g", "1", ""), b.x(1));
  });
  const Potential potential(definition, Backend::Interpreter);
  const auto& fields = potential.element_fields();
  REQUIRE(fields.size() == 4);
  int offset = 0;
  for (const ElementField& field : fields) {
    CHECK(field.offset == offset);
    offset += field.width;
  }
  CHECK(potential.element_width() == offset);
  CHECK(potential.element_width() == 3 + 1 + 3 + 3);
  CHECK(potential.uniform_width() == 1 + 1 + 3);
  for (const ElementField& field : fields) {
    if (field.name == "X1") CHECK((field.source == ElementField::Source::Rest && field.point == 1));
    if (field.name == "x_prev0") CHECK((field.source == ElementField::Source::Previous && field.point == 0));
    if (field.name == "mass")
      CHECK((field.source == ElementField::Source::Data && field.width == 1 && field.unit == "kg"));
  }
}

TEST_CASE("one name with two widths or two units is refused, in element data and in parameters") {
  const auto compile = [](std::function<symbolic::Scalar(PotentialBuilder&)> energy) {
    Potential(define_potential("bad", 1, "", std::move(energy)), Backend::Interpreter);
  };
  CHECK_THROWS_AS(compile([](PotentialBuilder& b) {
                    return b.data("a", "1", "") * symbolic::dot(b.data3("a", "1", ""), b.x(0));
                  }),
                  InvalidArgument);
  CHECK_THROWS_AS(compile([](PotentialBuilder& b) {
                    return b.parameter("a", "1", "") * symbolic::dot(b.parameter3("a", "1", ""), b.x(0));
                  }),
                  InvalidArgument);
  CHECK_THROWS_AS(compile([](PotentialBuilder& b) {
                    return b.data("a", "kg", "") * b.data("a", "m", "") * symbolic::squared_norm(b.x(0));
                  }),
                  InvalidArgument);
}

TEST_CASE("points outside the stencil are refused") {
  CHECK_THROWS(Potential(
      define_potential("far", 2, "", [](PotentialBuilder& b) { return symbolic::squared_norm(b.x(2)); }),
      Backend::Interpreter));
}

TEST_CASE("composed potentials are the sum of their terms and share fields and subexpressions") {
  const PotentialDefinition a = stretch("a", "k_a", 0.5), b = stretch("b", "k_b", 2.0);
  const Potential first(a, Backend::Automatic), second(b, Backend::Automatic),
      sum(compose("sum", {a, b}), Backend::Automatic);
  CHECK(sum.name() == "sum");
  CHECK(sum.element_width() == first.element_width());  // X and volume stored once
  CHECK(sum.uniform_width() == 2);
  std::mt19937_64 random(3);
  const PotentialDefinition composed = compose("sum", {a, b});
  for (int k = 0; k < 5; ++k) {
    const FilledSample sample = fill_sample(composed, sum, random);
    const std::vector<double> H = hessian(sum, sample, sample.x), g = gradient(sum, sample, sample.x);
    const std::vector<double> H_a = hessian(first, sample, sample.x), H_b = hessian(second, sample, sample.x);
    const std::vector<double> g_a = gradient(first, sample, sample.x),
                              g_b = gradient(second, sample, sample.x);
    CHECK(energy(sum, sample, sample.x) ==
          doctest::Approx(energy(first, sample, sample.x) + energy(second, sample, sample.x)).epsilon(1e-13));
    for (size_t i = 0; i < g.size(); ++i) CHECK(std::fabs(g[i] - g_a[i] - g_b[i]) < 1e-13);
    for (size_t i = 0; i < H.size(); ++i) CHECK(std::fabs(H[i] - H_a[i] - H_b[i]) < 1e-12);
  }
  // Two norms and a division are shared: clearly fewer operations than both terms have together.
  const int order = static_cast<int>(symbolic::Order::Hessian);
  const int separate =
      first.kernel().statistics().operations[order] + second.kernel().statistics().operations[order];
  CHECK(sum.kernel().statistics().operations[order] < 0.7 * separate);
}

TEST_CASE("composed potentials promise only what all terms promise") {
  PotentialDefinition free = stretch("a", "k", 1.0), bound = stretch("b", "k", 1.0);
  free.zero_at_rest = true;
  bound.translation_invariant = false;
  const PotentialDefinition sum = compose("sum", {free, bound});
  CHECK_FALSE(sum.translation_invariant);
  CHECK(sum.rotation_invariant);
  CHECK_FALSE(sum.zero_at_rest);
  CHECK(compose("sum", {free, free}).zero_at_rest);
}

TEST_CASE("sums of stencils of different sizes are refused") {
  const PotentialDefinition one =
      define_potential("one", 1, "", [](PotentialBuilder& b) { return symbolic::squared_norm(b.x(0)); });
  CHECK_THROWS(compose("sum", {one, stretch("two", "k", 1.0)}));
  CHECK_THROWS(compose("sum", {}));
}
