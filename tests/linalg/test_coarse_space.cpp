// The coarse space of rigid modes: exact on rigid motions, gains in iterations, what has no modes,
// indefiniteness, independence of threads and history.
#include <stark/linalg/coarse_space.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include <doctest/doctest.h>

#include <stark/linalg/jacobi_matrix.h>
#include <stark/linalg/pcg.h>

#include "linalg/systems.h"

using namespace stark;

namespace {

// A bar of n x m x m nodes of springs between neighbours, along edges and diagonals, with its positions [m].
struct Bar {
  BlockMatrix matrix;
  std::vector<Vec3> positions;
};

Bar bar(int n, int m, double mass) {
  Bar result;
  const auto id = [&](int i, int j, int k) { return (i * m + j) * m + k; };
  test::Pairs pairs;
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < m; ++j) {
      for (int k = 0; k < m; ++k) {
        result.positions.push_back({0.1 * i, 0.1 * j + 0.01 * i, 0.1 * k});
        for (int a = 0; a < 27; ++a) {
          const int x = i + a / 9 - 1, y = j + a / 3 % 3 - 1, z = k + a % 3 - 1;
          if (x < 0 || y < 0 || z < 0 || x >= n || y >= m || z >= m || id(x, y, z) <= id(i, j, k)) continue;
          pairs.emplace_back(id(i, j, k), id(x, y, z));
        }
      }
    }
  }
  const auto count = static_cast<int32_t>(result.positions.size());
  result.matrix.pattern = BlockPattern::from_pairs(count, pairs);
  result.matrix.set_zero();
  const auto add = [&](int32_t i, int32_t j, const Vec3& d, double stiffness) {
    double* block = result.matrix.values.data() + 9 * result.matrix.pattern.slot(i, j);
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c) block[3 * r + c] += stiffness * d[r] * d[c];
  };
  for (const auto& [i, j] : pairs) {
    const Vec3 d = normalized(result.positions[j] - result.positions[i]);
    add(i, i, d, 1.0);
    add(j, j, d, 1.0);
    add(i, j, d, -1.0);
  }
  for (int32_t i = 0; i < count; ++i)
    for (int a = 0; a < 3; ++a) result.matrix.values[9 * result.matrix.pattern.row_start[i] + 4 * a] += mass;
  return result;
}

// z += P (P^T A P)^-1 P^T r in the order of the matrix.
double correct(CoarseSpace& coarse, const std::vector<double>& r, std::vector<double>& z, ThreadPool& pool) {
  std::vector<double> forces, motion(r.size());
  for (const int32_t i : coarse.order())
    for (int a = 0; a < 3; ++a) forces.push_back(r[3 * i + a]);
  for (int32_t c = 0; c < coarse.cluster_count(); ++c) coarse.take_forces(c, forces.data());
  const double added = coarse.solve(pool);
  for (int32_t c = 0; c < coarse.cluster_count(); ++c) coarse.add_motion(c, motion.data());
  for (size_t k = 0; k < coarse.order().size(); ++k)
    for (int a = 0; a < 3; ++a) z[3 * coarse.order()[k] + a] += motion[3 * k + a];
  return added;
}

}  // namespace

TEST_CASE("coarse space: a rigid motion of a part is found exactly") {
  const Bar body = bar(60, 4, 0.1);
  for (int threads : {1, 3}) {
    ThreadPool pool(threads);
    CoarseSpace coarse;
    coarse.prepare(body.matrix.pattern);
    REQUIRE(coarse.is_useful());
    coarse.set_positions(body.positions);
    CHECK(coarse.cluster_count() >= 4);
    REQUIRE(coarse.factor(body.matrix, pool));
    const Vec3 shift{0.3, -1.0, 2.0}, turn{0.7, 0.2, -0.4};
    std::vector<double> u, r(3 * body.positions.size()), z(r.size(), 0.0);
    for (const Vec3& x : body.positions) {
      const Vec3 moved = shift + cross(turn, x);
      u.insert(u.end(), {moved.x, moved.y, moved.z});
    }
    body.matrix.multiply(u.data(), r.data(), pool);
    const double added = correct(coarse, r, z, pool);
    CHECK(added == doctest::Approx(std::inner_product(r.begin(), r.end(), z.begin(), 0.0)).epsilon(1e-12));
    // Regularised by 1e-9 of the diagonal; the softest modes are those of inertia, 5e-4 of it.
    for (size_t k = 0; k < u.size(); ++k) CHECK(std::fabs(z[k] - u[k]) < 1e-5);
  }
}

TEST_CASE("coarse space: a slender bar takes less than a third of the iterations, to the same solution") {
  const Bar body = bar(120, 4, 1e-3);
  ThreadPool pool(1);
  const std::vector<double> b = test::random_vector(3 * static_cast<int64_t>(body.positions.size()), 3);
  std::vector<double> x(b.size()), y(b.size());
  Pcg pcg;
  JacobiMatrix jacobi;
  REQUIRE(jacobi.prepare(body.matrix, PcgStorage::Double, pool));
  CoarseSpace coarse;
  coarse.prepare(body.matrix.pattern);
  coarse.set_positions(body.positions);
  REQUIRE(coarse.factor(body.matrix, pool));
  const PcgReport plain = pcg.solve(jacobi, b, x, 1e-8, 10000, pool);
  jacobi.set_coarse_space(&coarse);
  REQUIRE(jacobi.prepare(body.matrix, PcgStorage::Double, pool));
  const PcgReport corrected = pcg.solve(jacobi, b, y, 1e-8, 10000, pool);
  CHECK(plain.converged);
  CHECK(corrected.converged);
  CHECK(3 * corrected.iterations < plain.iterations);
  CHECK(test::relative_residual(body.matrix, b, x) < 1e-6);
  CHECK(test::relative_residual(body.matrix, b, y) < 1e-6);
}

TEST_CASE("coarse space: small parts have no modes and stay as they are") {
  // A bar, a pair of blocks beside it as a rigid body has, and a single block.
  const Bar body = bar(40, 3, 0.1);
  const auto count = static_cast<int32_t>(body.positions.size());
  test::Pairs pairs = {{count, count + 1}};
  for (int32_t i = 0; i < count; ++i)
    for (int64_t k = body.matrix.pattern.row_start[i] + 1; k < body.matrix.pattern.row_start[i + 1]; ++k)
      pairs.emplace_back(i, body.matrix.pattern.column[k]);
  const BlockMatrix matrix = test::spd_matrix(BlockPattern::from_pairs(count + 3, pairs), 5, 10.0);
  std::vector<Vec3> positions = body.positions;
  positions.resize(count + 3);
  ThreadPool pool(1);
  CoarseSpace coarse;
  coarse.prepare(matrix.pattern);
  coarse.set_positions(positions);
  REQUIRE(coarse.factor(matrix, pool));
  const std::vector<double> r = test::random_vector(3 * (count + 3), 4);
  std::vector<double> z(r.size(), 0.0);
  correct(coarse, r, z, pool);
  CHECK(std::all_of(z.end() - 9, z.end(), [](double value) { return value == 0.0; }));
  CHECK(std::none_of(z.begin(), z.end() - 9, [](double value) { return value == 0.0; }));
  CoarseSpace none;
  none.prepare(BlockPattern::from_pairs(100, {{0, 1}, {2, 3}}));
  CHECK_FALSE(none.is_useful());
}

TEST_CASE("coarse space: negative curvature of a rigid mode shows in the factor") {
  Bar body = bar(40, 3, 0.1);
  ThreadPool pool(1);
  CoarseSpace coarse;
  coarse.prepare(body.matrix.pattern);
  coarse.set_positions(body.positions);
  CHECK(coarse.factor(body.matrix, pool));
  for (size_t i = 0; i < body.positions.size(); ++i)
    for (int a = 0; a < 3; ++a) body.matrix.values[9 * body.matrix.pattern.row_start[i] + 4 * a] -= 0.2;
  CHECK_FALSE(coarse.factor(body.matrix, pool));
}

TEST_CASE("coarse space: bits depend on the present positions and matrix only, not on threads") {
  const Bar body = bar(50, 4, 0.1);
  std::vector<Vec3> turned;
  for (const Vec3& x : body.positions) turned.push_back({x.y, x.z, x.x});
  const std::vector<double> r = test::random_vector(3 * static_cast<int64_t>(body.positions.size()), 4);
  std::vector<double> reference;
  for (int threads : {1, 2, 5}) {
    ThreadPool pool(threads);
    CoarseSpace coarse;
    coarse.prepare(body.matrix.pattern);
    if (threads > 1) coarse.set_positions(turned);
    coarse.set_positions(body.positions);
    REQUIRE(coarse.factor(body.matrix, pool));
    std::vector<double> z(r.size(), 0.0);
    correct(coarse, r, z, pool);
    if (reference.empty()) reference = z;
    CHECK(z == reference);
  }
}

TEST_CASE("coarse space: clusters on a line or on a point, whose turns move nothing") {
  ThreadPool pool(1);
  const int32_t count = 200;
  test::Pairs pairs;
  for (int32_t i = 0; i + 1 < count; ++i) pairs.emplace_back(i, i + 1);
  const BlockMatrix matrix = test::spd_matrix(BlockPattern::from_pairs(count, pairs), 5, 10.0);
  std::vector<Vec3> line(count), point(count);
  for (int32_t i = 0; i < count; ++i) line[i] = {0.0, 0.1 * i, 0.0};
  for (const std::vector<Vec3>& positions : {line, point}) {
    CoarseSpace coarse;
    coarse.prepare(matrix.pattern);
    coarse.set_positions(positions);
    CHECK(coarse.factor(matrix, pool));
    const std::vector<double> b = test::random_vector(3 * count, 4);
    std::vector<double> x(b.size());
    Pcg pcg;
    JacobiMatrix jacobi;
    jacobi.set_coarse_space(&coarse);
    REQUIRE(jacobi.prepare(matrix, PcgStorage::Double, pool));
    CHECK(pcg.solve(jacobi, b, x, 1e-8, 1000, pool).converged);
    CHECK(test::relative_residual(matrix, b, x) < 1e-6);
  }
}
