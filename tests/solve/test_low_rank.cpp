// Systems with terms of low rank beside a matrix, against dense ones.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include <stark/solve/low_rank.h>

using namespace stark;

namespace {

using Vector = std::vector<double>;

/// Gaussian elimination with pivots.
Vector solve_dense(Vector A, Vector b) {
  const size_t n = b.size();
  for (size_t k = 0; k < n; ++k) {
    size_t p = k;
    for (size_t i = k + 1; i < n; ++i)
      if (std::fabs(A[i * n + k]) > std::fabs(A[p * n + k])) p = i;
    for (size_t j = 0; j < n; ++j) std::swap(A[k * n + j], A[p * n + j]);
    std::swap(b[k], b[p]);
    for (size_t i = k + 1; i < n; ++i) {
      const double factor = A[i * n + k] / A[k * n + k];
      for (size_t j = k; j < n; ++j) A[i * n + j] -= factor * A[k * n + j];
      b[i] -= factor * b[k];
    }
  }
  for (size_t k = n; k-- > 0;) {
    for (size_t j = k + 1; j < n; ++j) b[k] -= A[k * n + j] * b[j];
    b[k] /= A[k * n + k];
  }
  return b;
}

struct Random {
  std::mt19937_64 engine{11};
  Vector vector(size_t n) {
    std::normal_distribution<double> normal;
    Vector v(n);
    for (double& x : v) x = normal(engine);
    return v;
  }
};

/// G^T G + 1.
Vector definite(Random& random, size_t n) {
  const Vector G = random.vector(n * n);
  Vector A(n * n, 0.0);
  for (size_t i = 0; i < n; ++i)
    for (size_t j = 0; j < n; ++j) {
      for (size_t k = 0; k < n; ++k) A[i * n + j] += G[k * n + i] * G[k * n + j];
      A[i * n + j] += i == j;
    }
  return A;
}

LowRankCorrection::Solve solver_of(const Vector& A) {
  return [&A](std::span<const double> b, std::span<double> x) {
    const Vector found = solve_dense(A, {b.begin(), b.end()});
    std::ranges::copy(found, x.begin());
    return true;
  };
}

}  // namespace

TEST_CASE("solutions with terms of low rank are those of the full matrix, however stiff they are") {
  Random random;
  const size_t n = 9, m = 3;
  const Vector A = definite(random, n), r = random.vector(n);
  const std::vector<Vector> B = {random.vector(n), random.vector(n), random.vector(n)};
  for (const double scale : {1e-3, 1.0, 1e8}) {
    Vector C = definite(random, m);
    for (double& c : C) c *= scale;
    LowRank terms;
    terms.add(B, C, false);
    REQUIRE(terms.factors.size() == m);
    Vector full = A;
    for (size_t k = 0; k < m; ++k)
      for (size_t l = 0; l < m; ++l)
        for (size_t i = 0; i < n; ++i)
          for (size_t j = 0; j < n; ++j) full[i * n + j] += B[k][i] * C[k * m + l] * B[l][j];
    LowRankCorrection correction;
    REQUIRE(correction.begin(terms, solver_of(A)));
    Vector rest = r;
    const Vector taken = correction.take_out(rest);
    CHECK(std::fabs(rest[0] - r[0]) > 1e-3);
    Vector x = solve_dense(A, rest);
    correction.put_back(taken, x);
    correction.apply(x);
    const Vector expected = solve_dense(full, r);
    for (size_t i = 0; i < n; ++i) CHECK(x[i] == doctest::Approx(expected[i]).epsilon(1e-7));
  }
}

TEST_CASE("negative terms are used where the sum stays positive definite, and left out on demand") {
  Random random;
  const size_t n = 6;
  Vector A(n * n, 0.0), b(n, 0.0), other(n, 0.0);
  for (size_t i = 0; i < n; ++i) A[i * n + i] = 2.0;
  b[0] = 1.0;
  other[1] = 1.0;
  for (const double c : {-1.9, -2.1}) {
    LowRank terms;
    terms.add({b, other}, {c, 0.0, 0.0, 5.0}, false);
    LowRankCorrection correction;
    const bool is_definite = correction.begin(terms, solver_of(A));
    CHECK(is_definite == (c > -2.0));
    if (!is_definite) continue;
    Vector x = solve_dense(A, Vector(n, 1.0));
    correction.apply(x);
    CHECK(x[0] == doctest::Approx(1.0 / (2.0 + c)).epsilon(1e-12));
    CHECK(x[1] == doctest::Approx(1.0 / 7.0).epsilon(1e-12));
  }
  LowRank projected;
  projected.add({b, other}, {-1.0, 0.0, 0.0, 5.0}, true);
  CHECK(projected.factors == Vector{5.0});
}

TEST_CASE("columns that say the same count once, and a solve that fails ends it") {
  LowRank terms;
  terms.add({{1.0, 0.0}, {1.0, 0.0}}, {1.0, 1.0, 1.0, 1.0}, false);
  CHECK(terms.factors.size() == 1);
  LowRankCorrection correction;
  CHECK_FALSE(correction.begin(terms, [](std::span<const double>, std::span<double>) { return false; }));
}
