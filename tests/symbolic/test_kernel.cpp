#include <doctest/doctest.h>

#include <cmath>
#include <stark/symbolic/evaluate.h>
#include <stark/symbolic/tensor.h>
using namespace stark::symbolic;
TEST_CASE("first kernel") {
  Graph g; Scalar x = g.input(InputKind::Unknown), y = g.input(InputKind::Unknown);
  Kernel k = compile(x * x * y + log(x));
  alignas(64) double in[16], out[6 * 8];
  for (int l = 0; l < 8; ++l) { in[l] = 1.0 + l; in[8 + l] = 2.0; }
  k.evaluate(Order::Hessian, in, nullptr, nullptr, out, 1);
  for (int l = 0; l < 8; ++l) {
    const double X = 1.0 + l, Y = 2.0;
    CHECK(out[l] == doctest::Approx(X * X * Y + std::log(X)).epsilon(1e-14));
    CHECK(out[8 + l] == doctest::Approx(2 * X * Y + 1 / X).epsilon(1e-14));
    CHECK(out[16 + l] == doctest::Approx(X * X).epsilon(1e-14));
    CHECK(out[24 + l] == doctest::Approx(2 * Y - 1 / X / X).epsilon(1e-14));
    CHECK(out[32 + l] == doctest::Approx(2 * X).epsilon(1e-14));
    CHECK(out[40 + l] == 0.0);
  }
}
