// Elementary functions in units in the last place, against the standard library in extended precision, over
// wide ranges and at special values.
#include <doctest/doctest.h>

#include "symbolic/support.h"

#include <functional>
#include <limits>

using namespace stark::symbolic;
using namespace stark::symbolic::test;

namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

double ulp_error(double value, long double exact) {
  const auto rounded = static_cast<double>(exact);
  if (std::isnan(rounded)) return std::isnan(value) ? 0.0 : kInf;
  if (std::isinf(rounded) || std::isinf(value)) return value == rounded ? 0.0 : kInf;
  int exponent;
  std::frexp(std::fabs(rounded), &exponent);
  const double ulp = std::ldexp(1.0, std::max(exponent - 53, -1074));
  return static_cast<double>(std::fabs(static_cast<long double>(value) - exact)) / ulp;
}

std::vector<double> apply(const std::function<Scalar(Scalar, Scalar)>& f, const std::vector<double>& x,
                          const std::vector<double>& y) {
  Graph graph;
  const Scalar a = graph.input(InputKind::Unknown), b = graph.input(InputKind::Unknown);
  const Scalar outputs[] = {f(a, b)};
  const Function function = compile_function(outputs);
  std::vector<std::vector<double>> in;
  for (size_t k = 0; k < x.size(); ++k) in.push_back({x[k], y.empty() ? 0.0 : y[k]});
  const Lanes u = pack(2, in);
  const size_t blocks = (x.size() + kLanes - 1) / kLanes;
  Lanes out(blocks * kLanes);
  function.evaluate(u.data(), nullptr, nullptr, out.data(), static_cast<int64_t>(blocks));
  std::vector<double> result(x.size());
  for (size_t k = 0; k < x.size(); ++k) result[k] = out[k];
  return result;
}

double worst(const std::function<Scalar(Scalar)>& f, const std::function<long double(long double)>& exact,
             const std::vector<double>& x) {
  const auto values = apply([&](Scalar a, Scalar) { return f(a); }, x, {});
  double error = 0.0;
  for (size_t k = 0; k < x.size(); ++k) {
    const double e = ulp_error(values[k], exact(x[k]));
    if (e > error) {
      error = e;
      INFO("x = ", x[k], " value ", values[k], " ulp ", e);
      CHECK(e < 1e9);
    }
  }
  return error;
}

std::vector<double> spread(double a, double b, int n) {
  Random random(11);
  std::vector<double> x{a, b};
  for (int k = 0; k < n; ++k) x.push_back(uniform(random, a, b));
  return x;
}

// Both signs if asked, magnitudes spread over orders.
std::vector<double> magnitudes(double low, double high, int n, bool both_signs) {
  Random random(12);
  std::vector<double> x;
  for (int k = 0; k < n; ++k) {
    const double m = std::exp2(uniform(random, std::log2(low), std::log2(high)));
    x.push_back(both_signs && k % 2 ? -m : m);
  }
  return x;
}

constexpr int kCount = 20000;

}  // namespace

TEST_CASE("exp") {
  const auto e = [](Scalar x) { return exp(x); };
  const auto exact = [](long double x) { return std::exp(x); };
  CHECK(worst(e, exact, spread(-1.0, 1.0, kCount)) < 1.0);
  CHECK(worst(e, exact, spread(-708.0, 709.7, kCount)) < 1.0);
  // Subnormal results are rounded a second time.
  CHECK(worst(e, exact, spread(-745.1, -708.0, 2000)) < 1.01);
  CHECK(worst(e, exact, magnitudes(1e-300, 1.0, kCount, true)) < 1.0);
  const auto v = apply([](Scalar x, Scalar) { return exp(x); },
                       {0.0, -0.0, kInf, -kInf, kNan, 710.0, -746.0, 1e300, -1e300}, {});
  CHECK(v[0] == 1.0);
  CHECK(v[1] == 1.0);
  CHECK(v[2] == kInf);
  CHECK(v[3] == 0.0);
  CHECK(std::isnan(v[4]));
  CHECK(v[5] == kInf);
  CHECK(v[6] == 0.0);
  CHECK(v[7] == kInf);
  CHECK(v[8] == 0.0);
}

TEST_CASE("log") {
  const auto f = [](Scalar x) { return log(x); };
  const auto exact = [](long double x) { return std::log(x); };
  CHECK(worst(f, exact, spread(0.5, 2.0, kCount)) < 1.0);
  CHECK(worst(f, exact, spread(1.0 - 1e-6, 1.0 + 1e-6, kCount)) < 1.0);
  CHECK(worst(f, exact, magnitudes(1e-307, 1e308, kCount, false)) < 1.0);
  CHECK(worst(f, exact, magnitudes(5e-324, 1e-307, 2000, false)) < 1.0);
  const auto v =
      apply([](Scalar x, Scalar) { return log(x); }, {1.0, 0.0, -0.0, -1.0, kInf, -kInf, kNan}, {});
  CHECK(v[0] == 0.0);
  CHECK(v[1] == -kInf);
  CHECK(v[2] == -kInf);
  CHECK(std::isnan(v[3]));
  CHECK(v[4] == kInf);
  CHECK(std::isnan(v[5]));
  CHECK(std::isnan(v[6]));
}

TEST_CASE("sin, cos, tan") {
  for (const auto& x : {spread(-0.8, 0.8, kCount), spread(-100.0, 100.0, kCount),
                        magnitudes(1e-300, 1.0, 2000, true), magnitudes(1.0, 1e9, kCount, true)}) {
    // The reference needs its own reduction beyond extended precision only above 1e9.
    CHECK(worst([](Scalar a) { return sin(a); }, [](long double a) { return std::sin(a); }, x) < 1.0);
    CHECK(worst([](Scalar a) { return cos(a); }, [](long double a) { return std::cos(a); }, x) < 1.0);
    CHECK(worst([](Scalar a) { return tan(a); }, [](long double a) { return std::tan(a); }, x) < 2.5);
  }
  // Multiples of pi/2, where almost everything cancels.
  std::vector<double> multiples;
  for (int k = 1; k < 2000; ++k) multiples.push_back(k * 1.5707963267948966);
  CHECK(worst([](Scalar a) { return sin(a); }, [](long double a) { return std::sin(a); }, multiples) < 1.0);
  CHECK(worst([](Scalar a) { return cos(a); }, [](long double a) { return std::cos(a); }, multiples) < 1.0);
  const auto s = apply([](Scalar x, Scalar) { return sin(x); }, {0.0, kInf, -kInf, kNan}, {});
  CHECK(s[0] == 0.0);
  for (size_t k = 1; k < 4; ++k) CHECK(std::isnan(s[k]));
}

TEST_CASE("asin, acos") {
  for (const auto& x : {spread(-1.0, 1.0, kCount), spread(0.999, 1.0, kCount), spread(-1.0, -0.999, kCount),
                        spread(0.49, 0.51, kCount), magnitudes(1e-300, 1.0, kCount, true)}) {
    CHECK(worst([](Scalar a) { return asin(a); }, [](long double a) { return std::asin(a); }, x) < 2.0);
    CHECK(worst([](Scalar a) { return acos(a); }, [](long double a) { return std::acos(a); }, x) < 1.5);
  }
  const auto v = apply([](Scalar x, Scalar) { return acos(x); }, {1.0, -1.0, 0.0, 1.0000001, -2.0, kNan}, {});
  CHECK(v[0] == 0.0);
  CHECK(v[1] == std::acos(-1.0));
  CHECK(v[2] == std::acos(0.0));
  for (size_t k = 3; k < 6; ++k) CHECK(std::isnan(v[k]));
  const auto w = apply([](Scalar x, Scalar) { return asin(x); }, {1.0, -1.0, 0.0, 1.5, kNan}, {});
  CHECK(w[0] == std::asin(1.0));
  CHECK(w[1] == std::asin(-1.0));
  CHECK(w[2] == 0.0);
  CHECK(std::isnan(w[3]));
  CHECK(std::isnan(w[4]));
}

TEST_CASE("atan, atan2") {
  for (const auto& x : {spread(-3.0, 3.0, kCount), magnitudes(1e-300, 1e300, kCount, true)}) {
    CHECK(worst([](Scalar a) { return atan(a); }, [](long double a) { return std::atan(a); }, x) < 1.5);
  }
  const auto a = apply([](Scalar x, Scalar) { return atan(x); }, {kInf, -kInf, 0.0, kNan}, {});
  CHECK(a[0] == std::atan(kInf));
  CHECK(a[1] == std::atan(-kInf));
  CHECK(a[2] == 0.0);
  CHECK(std::isnan(a[3]));

  Random random(13);
  std::vector<double> y, x;
  for (int k = 0; k < kCount; ++k) {
    const double scale = std::exp2(uniform(random, -300.0, 300.0));
    y.push_back(uniform(random, -1.0, 1.0) * scale * std::exp2(uniform(random, -20.0, 20.0)));
    x.push_back(uniform(random, -1.0, 1.0) * scale);
  }
  for (const double p : {0.0, -0.0, 1.0, -1.0, 1e-300}) {
    for (const double q : {0.0, -0.0, 1.0, -1.0, 1e-300}) {
      y.push_back(p);
      x.push_back(q);
    }
  }
  const auto v = apply([](Scalar s, Scalar t) { return atan2(s, t); }, y, x);
  double error = 0.0;
  for (size_t k = 0; k < y.size(); ++k) {
    CAPTURE(y[k]);
    CAPTURE(x[k]);
    const double e =
        ulp_error(v[k], std::atan2(static_cast<long double>(y[k]), static_cast<long double>(x[k])));
    error = std::max(error, e);
    CHECK(e < 1.5);
    CHECK(std::signbit(v[k]) == std::signbit(y[k]));
  }
  MESSAGE("atan2 ulp ", error);
}

TEST_CASE("tanh") {
  for (const auto& x :
       {spread(-1.0, 1.0, kCount), spread(-25.0, 25.0, kCount), magnitudes(1e-300, 1.0, kCount, true)}) {
    CHECK(worst([](Scalar a) { return tanh(a); }, [](long double a) { return std::tanh(a); }, x) < 2.5);
  }
  const auto v = apply([](Scalar x, Scalar) { return tanh(x); }, {kInf, -kInf, 0.0, 400.0, kNan}, {});
  CHECK(v[0] == 1.0);
  CHECK(v[1] == -1.0);
  CHECK(v[2] == 0.0);
  CHECK(v[3] == 1.0);
  CHECK(std::isnan(v[4]));
}

TEST_CASE("pow") {
  Random random(14);
  std::vector<double> x, y;
  for (int k = 0; k < kCount; ++k) {
    x.push_back(std::exp2(uniform(random, -1020.0, 1020.0)));
    y.push_back(uniform(random, -700.0, 700.0) / std::fabs(std::log(x.back())));
    x.push_back(uniform(random, 0.5, 2.0));
    y.push_back(uniform(random, -900.0, 900.0));
    x.push_back(uniform(random, 0.0, 10.0));
    y.push_back(uniform(random, -3.0, 3.0));
  }
  const auto v = apply([](Scalar s, Scalar t) { return pow(s, t); }, x, y);
  double error = 0.0;
  for (size_t k = 0; k < x.size(); ++k) {
    error = std::max(
        error, ulp_error(v[k], std::pow(static_cast<long double>(x[k]), static_cast<long double>(y[k]))));
  }
  CHECK(error < 1.0);
  const std::vector<double> a{0.0, 0.0, 0.0, 1.0, 1.0, kInf, kInf, 2.0, 2.0, -1.5, kNan, 2.0, 5e-324, 0.5};
  const std::vector<double> b{1.5,    -1.5,    0.0, 1e300, -3.0, 1.0, -1.0,
                              2000.0, -2000.0, 0.3, 1.0,   kNan, 0.5, kInf};
  const std::vector<double> expected{
      0.0, kInf, 1.0, 1.0, 1.0, kInf, 0.0, kInf, 0.0, kNan, kNan, kNan, std::sqrt(5e-324), 0.0};
  const auto w = apply([](Scalar s, Scalar t) { return pow(s, t); }, a, b);
  for (size_t k = 0; k < a.size(); ++k) {
    CAPTURE(a[k]);
    CAPTURE(b[k]);
    CHECK(same_bits(w[k], expected[k]));
  }
}
