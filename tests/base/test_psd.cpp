// Lane-batched projection to positive semidefinite matrices, against a scalar Jacobi eigensolver in long
// double.
#include <stark/base/psd.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <random>
#include <vector>

#include <doctest/doctest.h>

namespace {

using stark::kPsdLanes;
using Real = long double;

int upper_size(int n) { return n * (n + 1) / 2; }

// Classical Jacobi: the largest off-diagonal entry first, so it shares no code or order with the library.
void eigen_oracle(int n, std::vector<Real> a, std::vector<Real>& lambda, std::vector<Real>& vectors) {
  vectors.assign(n * n, 0);
  for (int i = 0; i < n; ++i) vectors[i * n + i] = 1;
  Real scale = 0;
  for (Real value : a) scale = std::max(scale, std::fabs(value));
  for (int iteration = 0; iteration < 100 * n * n; ++iteration) {
    int p = 0, q = 1;
    Real largest = -1;
    for (int i = 0; i < n; ++i)
      for (int j = i + 1; j < n; ++j)
        if (std::fabs(a[i * n + j]) > largest) largest = std::fabs(a[i * n + j]), p = i, q = j;
    if (n == 1 || largest <= scale * 1e-19L) break;
    const Real angle = 0.5L * std::atan2(2 * a[p * n + q], a[p * n + p] - a[q * n + q]);
    const Real c = std::cos(angle), s = std::sin(angle);
    for (int k = 0; k < n; ++k) {
      const Real x = a[k * n + p], y = a[k * n + q];
      a[k * n + p] = c * x + s * y;
      a[k * n + q] = -s * x + c * y;
    }
    for (int k = 0; k < n; ++k) {
      const Real x = a[p * n + k], y = a[q * n + k];
      a[p * n + k] = c * x + s * y;
      a[q * n + k] = -s * x + c * y;
    }
    for (int k = 0; k < n; ++k) {
      const Real x = vectors[k * n + p], y = vectors[k * n + q];
      vectors[k * n + p] = c * x + s * y;
      vectors[k * n + q] = -s * x + c * y;
    }
  }
  lambda.resize(n);
  for (int i = 0; i < n; ++i) lambda[i] = a[i * n + i];
}

std::vector<Real> full_of_lane(const std::vector<double>& upper, int n, int lane) {
  std::vector<Real> a(n * n);
  int k = 0;
  for (int i = 0; i < n; ++i)
    for (int j = i; j < n; ++j, ++k) a[i * n + j] = a[j * n + i] = upper[kPsdLanes * k + lane];
  return a;
}

std::vector<Real> projected_oracle(int n, const std::vector<Real>& a) {
  std::vector<Real> lambda, v, result(n * n, 0);
  eigen_oracle(n, a, lambda, v);
  for (int k = 0; k < n; ++k)
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j)
        result[i * n + j] += std::max<Real>(lambda[k], 0) * v[i * n + k] * v[j * n + k];
  return result;
}

Real smallest_eigenvalue(int n, const std::vector<Real>& a) {
  std::vector<Real> lambda, v;
  eigen_oracle(n, a, lambda, v);
  Real smallest = lambda[0];
  for (Real value : lambda) smallest = std::min(smallest, value);
  return smallest;
}

Real max_abs(const std::vector<Real>& a) {
  Real largest = 0;
  for (Real value : a) largest = std::max(largest, std::fabs(value));
  return largest;
}

// Eight random symmetric matrices, lane l scaled by 10^(3 l - 9): stiffness of very different materials side
// by side.
std::vector<double> random_lanes(int n, std::mt19937& random) {
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  std::vector<double> upper(kPsdLanes * upper_size(n));
  for (int k = 0; k < upper_size(n); ++k)
    for (int l = 0; l < kPsdLanes; ++l)
      upper[kPsdLanes * k + l] = uniform(random) * std::pow(10.0, 3 * l - 9);
  return upper;
}

// Makes every row of 3x3 blocks sum to zero, P A P with P the projector to vectors without mean over the
// points.
void remove_translations(std::vector<double>& upper, int n) {
  const int points = n / 3;
  for (int lane = 0; lane < kPsdLanes; ++lane) {
    std::vector<Real> a = full_of_lane(upper, n, lane);
    for (int pass = 0; pass < 2; ++pass) {
      for (int i = 0; i < n; ++i)
        for (int c = 0; c < 3; ++c) {
          Real mean = 0;
          for (int p = 0; p < points; ++p) mean += a[i * n + 3 * p + c] / points;
          for (int p = 0; p < points; ++p) a[i * n + 3 * p + c] -= mean;
        }
      for (int i = 0; i < n; ++i)
        for (int j = 0; j < i; ++j) std::swap(a[i * n + j], a[j * n + i]);
    }
    int k = 0;
    for (int i = 0; i < n; ++i)
      for (int j = i; j < n; ++j, ++k) upper[kPsdLanes * k + lane] = static_cast<double>(a[i * n + j]);
  }
}

// Round-off of Jacobi grows like a few n eps of the norm; 1e-13 leaves a factor of about ten at n = 24.
constexpr double kTolerance = 1e-13;

}  // namespace

TEST_CASE("psd: the projection is the clamped eigendecomposition, for every size") {
  std::mt19937 random(1);
  std::vector<int> sizes(25);
  std::iota(sizes.begin(), sizes.end(), 1);
  sizes.insert(sizes.end(), {36, stark::kPsdMaxSize});
  for (const int n : sizes) {
    CAPTURE(n);
    const std::vector<double> before = random_lanes(n, random);
    std::vector<double> after = before;
    stark::psd_project(after.data(), n, 0xffu);
    for (int lane = 0; lane < kPsdLanes; lane += n > 24 ? kPsdLanes - 1 : 1) {  // the oracle is slow
      CAPTURE(lane);
      const std::vector<Real> a = full_of_lane(before, n, lane), expected = projected_oracle(n, a);
      const std::vector<Real> got = full_of_lane(after, n, lane);
      const Real scale = n * max_abs(a);
      for (int k = 0; k < n * n; ++k) REQUIRE(std::fabs(got[k] - expected[k]) <= kTolerance * scale);
      REQUIRE(smallest_eigenvalue(n, got) >= -kTolerance * scale);
    }
    CHECK(stark::psd_test(after.data(), n) == 0u);
  }
}

TEST_CASE("psd: no positive semidefinite matrix nearby is closer than the projection") {
  std::mt19937 random(2);
  std::normal_distribution<double> normal;
  const int n = 9;
  const std::vector<double> before = random_lanes(n, random);
  std::vector<double> after = before;
  stark::psd_project(after.data(), n, 0xffu);
  const int lane = 3;  // scale 1
  const std::vector<Real> a = full_of_lane(before, n, lane), x = full_of_lane(after, n, lane);
  const auto distance = [&](const std::vector<Real>& y) {
    Real sum = 0;
    for (int k = 0; k < n * n; ++k) sum += (y[k] - a[k]) * (y[k] - a[k]);
    return std::sqrt(sum);
  };
  for (int trial = 0; trial < 50; ++trial) {
    // x + e w w^T is PSD; so is (1 - e) x + e B with B PSD.
    std::vector<Real> w(n), y(n * n);
    for (Real& value : w) value = normal(random);
    for (Real e : {1e-3L, 1e-1L}) {
      for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) y[i * n + j] = (trial % 2 ? 1 : 1 - e) * x[i * n + j] + e * w[i] * w[j];
      CHECK(distance(y) > distance(x));
    }
  }
}

TEST_CASE("psd: unselected lanes keep their bits, and a lane does not depend on its neighbours") {
  std::mt19937 random(3);
  for (int n : {3, 5, 6, 9, 12}) {
    const std::vector<double> before = random_lanes(n, random);
    std::vector<double> all = before;
    stark::psd_project(all.data(), n, 0xffu);
    for (uint32_t mask : {0x00u, 0x01u, 0x28u, 0x80u, 0x7eu}) {
      std::vector<double> some = before;
      stark::psd_project(some.data(), n, mask);
      for (int k = 0; k < upper_size(n); ++k)
        for (int l = 0; l < kPsdLanes; ++l)
          REQUIRE(some[kPsdLanes * k + l] == ((mask >> l & 1u) ? all : before)[kPsdLanes * k + l]);
    }
  }
}

TEST_CASE("psd: translation-invariant matrices project to the same matrix in fewer dimensions") {
  std::mt19937 random(4);
  for (int n : {6, 9, 12, 15, 18}) {
    CAPTURE(n);
    std::vector<double> before = random_lanes(n, random);
    remove_translations(before, n);
    std::vector<double> after = before;
    stark::psd_project(after.data(), n, 0xffu, true);
    for (int lane = 0; lane < kPsdLanes; ++lane) {
      const std::vector<Real> a = full_of_lane(before, n, lane), expected = projected_oracle(n, a);
      const std::vector<Real> got = full_of_lane(after, n, lane);
      const Real scale = n * max_abs(a);
      for (int k = 0; k < n * n; ++k) REQUIRE(std::fabs(got[k] - expected[k]) <= kTolerance * scale);
      for (int i = 0; i < n; ++i)
        for (int c = 0; c < 3; ++c) {
          Real sum = 0;
          for (int p = 0; p < n / 3; ++p) sum += got[i * n + 3 * p + c];
          REQUIRE(std::fabs(sum) <= kTolerance * scale);
        }
    }
  }
}

TEST_CASE("psd: the test accepts definite and singular matrices and rejects indefinite ones") {
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  for (int n = 1; n <= 25; ++n) {
    CAPTURE(n);
    for (int rank : {0, 1, n / 2, n}) {
      // G G^T with `rank` columns. Lane l is lowered in a random direction u by 10^-(l+2) of the trace in odd
      // lanes.
      std::vector<double> upper(kPsdLanes * upper_size(n));
      uint32_t expected = 0;
      for (int lane = 0; lane < kPsdLanes; ++lane) {
        std::vector<double> g(n * std::max(rank, 1), 0.0), u(n);
        if (rank > 0)
          for (double& value : g) value = normal(random);
        double trace = 0.0, u_norm = 0.0;
        for (double value : g) trace += value * value;
        for (double& value : u) value = normal(random), u_norm += value * value;
        const double lower = lane % 2 ? (trace + (rank == 0)) * std::pow(10.0, -(lane + 2)) / u_norm : 0.0;
        int k = 0;
        for (int i = 0; i < n; ++i)
          for (int j = i; j < n; ++j, ++k) {
            double sum = 0.0;
            for (int c = 0; c < rank; ++c) sum += g[i * rank + c] * g[j * rank + c];
            upper[kPsdLanes * k + lane] = sum - lower * u[i] * u[j];
          }
        // The oracle decides: a full-rank matrix may survive a small lowering.
        const std::vector<Real> a = full_of_lane(upper, n, lane);
        const Real smallest = smallest_eigenvalue(n, a);
        if (smallest < -1e-10L * (trace + 1e-300L)) expected |= 1u << lane;
        if (smallest < -1e-14L * trace && smallest > -1e-10L * trace)
          expected |= 1u << (lane + 16);  // undecided
      }
      const uint32_t undecided = expected >> 16;
      CHECK((stark::psd_test(upper.data(), n) & ~undecided) == (expected & 0xffu & ~undecided));
    }
  }
}

TEST_CASE("psd: special values") {
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  std::vector<double> upper(kPsdLanes * 6, 0.0);
  // Lanes: 0 zero, 1 NaN on the diagonal, 2 NaN off the diagonal, 3 infinity, 4 minus identity, 5 identity,
  // 6 hyperbolic [0 1; 1 0], 7 tiny negative.
  const int diagonal[3] = {0, 3, 5};
  for (int d : diagonal)
    for (int l : {1, 2, 3, 5}) upper[kPsdLanes * d + l] = 1.0;
  for (int d : diagonal) upper[kPsdLanes * d + 4] = -1.0;
  upper[1] = nan;
  upper[kPsdLanes * 1 + 2] = nan;
  upper[kPsdLanes * 1 + 3] = inf;
  upper[kPsdLanes * 1 + 6] = 1.0;
  upper[7] = -1e-200;
  const uint32_t bad = stark::psd_test(upper.data(), 3);
  CHECK(bad == (0x02u | 0x04u | 0x08u | 0x10u | 0x40u | 0x80u));
  std::vector<double> after = upper;
  stark::psd_project(after.data(), 3, 0xffu);
  for (int k = 0; k < 6; ++k) {
    CHECK(after[kPsdLanes * k] == 0.0);
    CHECK(after[kPsdLanes * k + 4] == 0.0);
    CHECK(after[kPsdLanes * k + 5] == upper[kPsdLanes * k + 5]);
    CHECK(after[kPsdLanes * k + 7] == 0.0);
  }
  CHECK(std::isnan(after[1]));
  CHECK(std::isnan(after[kPsdLanes * 1 + 2]));
  CHECK(std::isinf(after[kPsdLanes * 1 + 3]));
  CHECK(after[6] == doctest::Approx(0.5));
  CHECK(after[kPsdLanes * 1 + 6] == doctest::Approx(0.5));
}

TEST_CASE("psd: 3x3 matrices") {
  const stark::Mat3 a = {{1.0, 2.0, 0.0, 2.0, 1.0, 0.0, 0.0, 0.0, -3.0}};  // eigenvalues 3, -1, -3
  const stark::Mat3 b = stark::psd_project(a);
  const stark::Mat3 expected = {{1.5, 1.5, 0.0, 1.5, 1.5, 0.0, 0.0, 0.0, 0.0}};
  for (int k = 0; k < 9; ++k) CHECK(b.m[k] == doctest::Approx(expected.m[k]).epsilon(1e-14));
}
