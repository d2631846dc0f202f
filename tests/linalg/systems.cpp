// Block systems for the tests of linalg.
#include "linalg/systems.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace stark::test {

Pairs cloth_pairs(int n) {
  Pairs pairs;
  const auto id = [n](int i, int j) { return i * n + j; };
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      if (i + 1 < n) pairs.emplace_back(id(i, j), id(i + 1, j));
      if (j + 1 < n) pairs.emplace_back(id(i, j + 1), id(i, j));
      if (i + 1 < n && j + 1 < n) {
        pairs.emplace_back(id(i, j), id(i + 1, j + 1));
        pairs.emplace_back(id(i + 1, j), id(i, j + 1));
      }
      if (i + 2 < n && j + 1 < n) pairs.emplace_back(id(i, j), id(i + 2, j + 1));
      if (i + 1 < n && j + 2 < n) pairs.emplace_back(id(i + 1, j + 2), id(i, j));
    }
  return pairs;
}

Pairs solid_pairs(int n, int32_t& out_block_count) {
  Pairs pairs;
  const int m = n + 1;
  const auto corner = [m](int i, int j, int k) { return (i * m + j) * m + k; };
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j)
      for (int k = 0; k < n; ++k) {
        int32_t corners[8];
        for (int c = 0; c < 8; ++c) corners[c] = corner(i + (c & 1), j + (c >> 1 & 1), k + (c >> 2));
        const int32_t center = m * m * m + (i * n + j) * n + k;
        for (int a = 0; a < 8; ++a) {
          pairs.emplace_back(corners[a], center);
          for (int b = a + 1; b < 8; ++b)
            if ((a ^ b) != 7) pairs.emplace_back(corners[a], corners[b]);  // no diagonal through the centre
        }
      }
  out_block_count = m * m * m + n * n * n;
  return pairs;
}

Pairs random_pairs(int32_t block_count, int count, uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_int_distribution<int32_t> node(0, block_count - 1);
  Pairs pairs(count);
  for (auto& [i, j] : pairs) i = node(random), j = node(random);
  return pairs;
}

std::vector<GraphCase> ordering_cases() {
  std::vector<GraphCase> list;
  list.push_back({"one", 1, {}});
  list.push_back({"isolated", 300, {}});
  list.push_back({"cloth", 400, cloth_pairs(20)});
  int32_t count = 0;
  const Pairs solid = solid_pairs(5, count);
  list.push_back({"solid", count, solid});
  list.push_back({"random", 500, random_pairs(500, 700, 1)});
  list.push_back({"dense random", 200, random_pairs(200, 5000, 2)});
  Pairs star, hub = cloth_pairs(25);
  for (int i = 1; i < 2000; ++i) star.emplace_back(0, i);
  for (int i = 0; i < 625; ++i) hub.emplace_back(i, 625);
  list.push_back({"star", 2000, star});
  list.push_back({"hub", 626, hub});
  return list;
}

bool is_permutation_of_all(std::vector<int32_t> order, int32_t n) {
  std::sort(order.begin(), order.end());
  std::vector<int32_t> all(n);
  std::iota(all.begin(), all.end(), 0);
  return order == all;
}

BlockMatrix spd_matrix(BlockPattern pattern, uint32_t seed, double contrast) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  BlockMatrix matrix;
  matrix.pattern = std::move(pattern);
  matrix.set_zero();
  const BlockPattern& p = matrix.pattern;
  for (int32_t i = 0; i < p.block_count; ++i) {
    double* diagonal = matrix.values.data() + 9 * p.row_start[i];
    for (int c = 0; c < 3; ++c) diagonal[4 * c] += 1.0 + 0.5 * uniform(random);
    for (int64_t k = p.row_start[i] + 1; k < p.row_start[i + 1]; ++k) {
      const double stiffness = std::pow(contrast, 0.5 + 0.5 * uniform(random));
      const double u[3] = {uniform(random), uniform(random), uniform(random)};
      const double sign = uniform(random) < 0.5 ? -1.0 : 1.0;
      double* other = matrix.values.data() + 9 * p.row_start[p.column[k]];
      // Energy stiffness/2 (u . x_i + sign v . x_j)^2 with v a perturbed u, so that off-diagonal blocks are
      // unsymmetric.
      double v[3];
      for (int c = 0; c < 3; ++c) v[c] = u[c] + 0.2 * uniform(random);
      for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 3; ++c) {
          diagonal[3 * r + c] += stiffness * u[r] * u[c];
          other[3 * r + c] += stiffness * v[r] * v[c];
          matrix.values[9 * k + 3 * r + c] += sign * stiffness * u[r] * v[c];
        }
    }
  }
  return matrix;
}

std::vector<double> random_vector(int64_t size, uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  std::vector<double> x(size);
  for (double& value : x) value = uniform(random);
  return x;
}

std::vector<long double> dense_of(const BlockMatrix& matrix) {
  const BlockPattern& p = matrix.pattern;
  const int n = 3 * p.block_count;
  std::vector<long double> a(static_cast<size_t>(n) * n, 0);
  for (int32_t i = 0; i < p.block_count; ++i)
    for (int64_t k = p.row_start[i]; k < p.row_start[i + 1]; ++k)
      for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 3; ++c) {
          const int row = 3 * i + r, column = 3 * p.column[k] + c;
          a[static_cast<size_t>(row) * n + column] = matrix.values[9 * k + 3 * r + c];
          a[static_cast<size_t>(column) * n + row] = matrix.values[9 * k + 3 * r + c];
        }
  return a;
}

std::vector<double> dense_solve(const BlockMatrix& matrix, const std::vector<double>& b) {
  std::vector<long double> a = dense_of(matrix), x(b.begin(), b.end());
  const int n = static_cast<int>(b.size());
  for (int k = 0; k < n; ++k) {
    int pivot = k;
    for (int i = k + 1; i < n; ++i)
      if (std::fabs(a[static_cast<size_t>(i) * n + k]) > std::fabs(a[static_cast<size_t>(pivot) * n + k]))
        pivot = i;
    for (int j = 0; j < n; ++j)
      std::swap(a[static_cast<size_t>(k) * n + j], a[static_cast<size_t>(pivot) * n + j]);
    std::swap(x[k], x[pivot]);
    for (int i = k + 1; i < n; ++i) {
      const long double factor = a[static_cast<size_t>(i) * n + k] / a[static_cast<size_t>(k) * n + k];
      if (factor == 0) continue;
      for (int j = k; j < n; ++j)
        a[static_cast<size_t>(i) * n + j] -= factor * a[static_cast<size_t>(k) * n + j];
      x[i] -= factor * x[k];
    }
  }
  for (int k = n - 1; k >= 0; --k) {
    for (int j = k + 1; j < n; ++j) x[k] -= a[static_cast<size_t>(k) * n + j] * x[j];
    x[k] /= a[static_cast<size_t>(k) * n + k];
  }
  return {x.begin(), x.end()};
}

double relative_residual(const BlockMatrix& matrix, const std::vector<double>& b,
                         const std::vector<double>& x) {
  const BlockPattern& p = matrix.pattern;
  std::vector<long double> r(b.begin(), b.end());
  for (int32_t i = 0; i < p.block_count; ++i)
    for (int64_t k = p.row_start[i]; k < p.row_start[i + 1]; ++k) {
      const int32_t j = p.column[k];
      for (int a = 0; a < 3; ++a)
        for (int c = 0; c < 3; ++c) {
          const long double value = matrix.values[9 * k + 3 * a + c];
          r[3 * i + a] -= value * x[3 * j + c];
          if (j != i) r[3 * j + c] -= value * x[3 * i + a];
        }
    }
  long double residual = 0, scale = 0;
  for (size_t k = 0; k < b.size(); ++k)
    residual += r[k] * r[k], scale += static_cast<long double>(b[k]) * b[k];
  return static_cast<double>(std::sqrt(residual / scale));
}

}  // namespace stark::test
