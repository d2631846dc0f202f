// Hash-consing, folding, simplification, printing and errors of the expression graph.
#include <doctest/doctest.h>

#include <stark/base/error.h>
#include <stark/symbolic/evaluate.h>
#include <stark/symbolic/tensor.h>

#include <cmath>
#include <limits>

using namespace stark::symbolic;
using stark::InvalidArgument;

TEST_CASE("equal expressions are one node") {
  Graph g;
  const Scalar x = g.input(InputKind::Unknown), y = g.input(InputKind::Element);
  CHECK(is_same(x * y + 1.0, 1.0 + y * x));
  CHECK(is_same(exp(x - y), exp(x - y)));
  CHECK_FALSE(is_same(x - y, y - x));
  const int size = g.size();
  for (int k = 0; k < 100; ++k) static_cast<void>(sqrt(x * y + exp(x)) / (x + 2.0));
  const int once = g.size();
  static_cast<void>(sqrt(x * y + exp(x)) / (x + 2.0));
  CHECK(g.size() == once);
  CHECK(once - size <= 8);
}

TEST_CASE("literals are computed at once and need no graph") {
  const Scalar a = 3.0, b = 4.0;
  CHECK((a * b - 2.0 / b).value() == 11.5);
  CHECK(sqrt(a * a + b * b).value() == 5.0);
  CHECK(select(a < b, a, b).value() == 3.0);
  CHECK(max(a, b).value() == 4.0);
  CHECK(atan2(a, b).value() == std::atan2(3.0, 4.0));
  CHECK(pow(a, -2).value() == 1.0 / 9.0);
  CHECK(fma(a, b, 1.0).value() == 13.0);
}

TEST_CASE("constant factors stay apart where their product leaves the range of normal numbers") {
  Graph g;
  const Scalar x = g.input(InputKind::Unknown);
  const auto value = [](const Scalar& y, double at) { return evaluate(y, {{&at, 1}}); };
  CHECK(value(1e200 * (1e200 * x), 1e-250) == doctest::Approx(1e150));
  CHECK(value(1e-200 * (1e-200 * x), 1e250) == doctest::Approx(1e-150));
  CHECK(value(1e-300 * (1e-20 * x), 1e250) == doctest::Approx(1e-70).epsilon(1e-14));  // not subnormal
  CHECK(value(1e-200 * (x * (1e-200 * x)), 1e150) == doctest::Approx(1e-100));
  CHECK(value(1.5e308 * x + 1e308 * x, 1e-10) == doctest::Approx(2.5e298));
}

TEST_CASE("simplifications") {
  Graph g;
  const Scalar x = g.input(InputKind::Unknown), y = g.input(InputKind::Unknown);
  CHECK(is_same(x + 0.0, x));
  CHECK(is_same(1.0 * x, x));
  CHECK(is_same(x / 1.0, x));
  CHECK(is_same(0.0 * x, Scalar(0.0)));
  CHECK(is_same(x - x, Scalar(0.0)));
  CHECK(is_same(-(-x), x));
  CHECK(is_same(x - (-y), x + y));
  CHECK(is_same(-(x - y), y - x));
  CHECK(is_same((-x) * (-y), x * y));
  CHECK(is_same(2.0 * (3.0 * x), 6.0 * x));
  CHECK(is_same(x + x, 2.0 * x));
  CHECK(is_same(x / 4.0, 0.25 * x));
  CHECK(is_same(cos(-x), cos(x)));
  CHECK(is_same(sin(-x), -sin(x)));
  CHECK(is_same(select(x < y, x, x), x));
  CHECK(is_same(select(!(x < y), x, y), select(x < y, y, x)));
  CHECK(is_same(pow(x, 1), x));
  CHECK(is_same(pow(x, 2.0), x * x));
  CHECK(is_same(pow(x, 0.5), sqrt(x)));
  // A division by a number that is no power of two keeps its rounding.
  CHECK_FALSE(is_same(x / 6.0, (1.0 / 6.0) * x));
}

TEST_CASE("tiny and nearly-one constants are kept exactly") {
  Graph g;
  const Scalar x = g.input(InputKind::Unknown);
  const double u[] = {3.0};
  CHECK(evaluate(x * 1e-300, {u}) == 3.0 * 1e-300);
  CHECK(evaluate(x * (1.0 + 0x1p-52), {u}) == 3.0 * (1.0 + 0x1p-52));
}

TEST_CASE("evaluation and printing") {
  Graph g;
  const Scalar x = g.input(InputKind::Unknown), e = g.input(InputKind::Element),
               p = g.input(InputKind::Uniform);
  const Scalar f = select(x < e, sqrt(x) + 0.1, -p);
  CHECK(to_string(f) == "select((u0 < e0), (sqrt(u0) + 0.1), -p0)");
  const double u[] = {4.0}, el[] = {5.0}, un[] = {7.0};
  CHECK(evaluate(f, {u, el, un}) == 2.1);
  CHECK(evaluate_condition(x < e, {u, el, un}));
  CHECK_THROWS_AS(evaluate(f, {u, {}, un}), InvalidArgument);
  CHECK_THROWS_AS(evaluate(x < e, {u, el, un}), InvalidArgument);
}

TEST_CASE("inputs can have names, and long text is cut") {
  Graph graph;
  const Scalar x = graph.input(InputKind::Unknown), y = graph.input(InputKind::Element);
  graph.set_name(x, "x");
  CHECK(graph.name(x.id()) == "x");
  CHECK(graph.name(y.id()).empty());
  CHECK(to_string(x * y) == "(x * e0)");
  Scalar tower = x;
  for (int k = 0; k < 100; ++k) tower = tower * tower + y;  // written out, 2^100 terms
  const std::string text = to_string(tower, 40);
  CHECK(text.size() == 43);
  CHECK(text.substr(40) == "...");
  CHECK_THROWS_AS(graph.set_name(2.0, "two"), stark::InvalidArgument);
}

TEST_CASE("tensors follow the rules of linear algebra") {
  Graph g;
  std::vector<double> values;
  const Mat3 A = input_matrix<3, 3>(g, InputKind::Unknown);
  const Vec3 v = input_vector<3>(g, InputKind::Unknown);
  for (int k = 0; k < 12; ++k) values.push_back(std::sin(1.7 * k * k + 0.3));
  const auto value = [&](const Scalar& s) { return evaluate(s, {values}); };
  const Mat3 I = A * inverse(A);
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) CHECK(std::fabs(value(I(i, j)) - (i == j)) < 1e-13);  // condition about 10
  CHECK(value(determinant(A)) == doctest::Approx(value(determinant(transpose(A)))).epsilon(1e-13));
  CHECK(value(trace(outer(v, v))) == doctest::Approx(value(squared_norm(v))).epsilon(1e-15));
  const Vec3 w = cross(v, A * v), s = skew(v) * (A * v);
  for (int i = 0; i < 3; ++i) CHECK(value(w[i]) == doctest::Approx(value(s[i])).epsilon(1e-14));
  CHECK(std::fabs(value(dot(w, v))) < 1e-15);
  CHECK(value(norm(normalized(v))) == doctest::Approx(1.0).epsilon(1e-15));
  const Mat2 B(A(0, 0), A(0, 1), A(1, 0), A(1, 1));
  CHECK(value((B * inverse(B))(0, 1)) == doctest::Approx(0.0).epsilon(1e-14));
  const Mat32 C = Mat32::from_columns(A.column(0), v);
  CHECK(value((transpose(C) * C)(0, 1)) == doctest::Approx(value(dot(A.column(0), v))).epsilon(1e-15));
  CHECK(value(determinant(Mat3::from_rows(A.row(0), A.row(1), A.row(2)))) == value(determinant(A)));
}

TEST_CASE("misuse is an exception") {
  Graph g, other;
  const Scalar x = g.input(InputKind::Unknown), y = other.input(InputKind::Unknown);
  CHECK_THROWS_AS(x + y, InvalidArgument);
  CHECK_THROWS_AS((x < 1.0) + x, InvalidArgument);
  CHECK_THROWS_AS(select(x, x, x), InvalidArgument);
  CHECK_THROWS_AS(select(x < 1.0, x, y), InvalidArgument);
  CHECK_THROWS_AS(x && (x < 1.0), InvalidArgument);
  CHECK_THROWS_AS(sqrt(x < 1.0), InvalidArgument);
  CHECK_THROWS_AS(fma(x, x, y), InvalidArgument);
  CHECK_THROWS_AS(g.mark_stage(y + 1.0), InvalidArgument);
  CHECK_THROWS_AS(compile(x < 1.0), InvalidArgument);
}
