// The expanded matrix of block-Jacobi: its product.
#include <stark/linalg/jacobi_matrix.h>

#include <doctest/doctest.h>

#include "linalg/systems.h"

using namespace stark;

TEST_CASE("the expanded form has the product of the matrix, on any number of threads") {
  const int n = 50;
  const BlockMatrix matrix = test::spd_matrix(BlockPattern::from_pairs(n * n, test::cloth_pairs(n)), 3);
  const std::vector<double> b = test::random_vector(3 * n * n, 4);
  std::vector<double> expected(b.size()), product(b.size());
  for (int threads : {1, 2, 5}) {
    ThreadPool pool(threads);
    JacobiMatrix jacobi;
    REQUIRE(jacobi.prepare(matrix, PcgStorage::Double, pool));
    matrix.multiply(b.data(), expected.data(), pool);
    jacobi.apply(b.data(), product.data(), pool);
    for (size_t k = 0; k < b.size(); ++k)
      REQUIRE(product[k] == doctest::Approx(expected[k]).epsilon(1e-10).scale(1e4));
  }
}
