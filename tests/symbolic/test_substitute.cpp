// Rewriting expressions in another graph: every operation survives, inputs are replaced, stages are carried
// over.
#include <doctest/doctest.h>

#include <stark/symbolic/evaluate.h>
#include <stark/symbolic/substitute.h>

using namespace stark::symbolic;

TEST_CASE("copies have the values of the originals for all operations") {
  Graph source, target;
  const Scalar u = source.input(InputKind::Unknown), e = source.input(InputKind::Element),
               p = source.input(InputKind::Uniform);
  const std::vector<Scalar> outputs{
      -u + e * p - u / e,
      abs(u) + sqrt(e) + exp(u) + log(p) + sin(u) + cos(e) + tan(u),
      asin(u) + acos(u) + atan(p) + tanh(e) + atan2(u, e) + pow(p, e) + fma(u, e, p),
      min(u, e) + max(u, p) + select((u < e && e <= p) || !(p < u), u * e, p),
      7.0,
  };
  const double values[] = {0.3, 0.7, 1.9};
  const auto images = substitute(outputs, [&](InputKind kind, int index) {
    CHECK(index == 0);
    return target.input_node(kind, 0) >= 0 ? Scalar(&target, target.input_node(kind, 0)) : Scalar();
  });
  REQUIRE(images.size() == outputs.size());
  const InputValues at{.unknowns = {&values[0], 1}, .elements = {&values[1], 1}, .uniforms = {&values[2], 1}};
  for (size_t k = 0; k < outputs.size(); ++k) CHECK(evaluate(images[k], at) == evaluate(outputs[k], at));
}

TEST_CASE("an input may become a literal, and stages follow") {
  Graph source, target;
  const Scalar x = source.input(InputKind::Unknown), y = source.input(InputKind::Unknown);
  const Scalar stage = x * y;
  source.mark_stage(stage);
  const Scalar z = target.input(InputKind::Element);
  const Scalar outputs[] = {exp(stage) + x};
  const auto image = substitute(outputs, [&](InputKind, int index) { return index == 0 ? z : Scalar(2.0); });
  CHECK(is_same(image[0], exp(z * 2.0) + z));
  REQUIRE(target.stages().size() == 1);
  CHECK(is_same(Scalar(&target, target.stages()[0]), z * 2.0));
}
