// Dense kernels of the fronts: with 512-bit vectors they give the same bits as with 256-bit ones.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <random>
#include <vector>

#include <doctest/doctest.h>
#include <stark/base/cpu.h>
#include <stark/linalg/front_kernels.h>

using namespace stark;
using namespace stark::front;

namespace {

template <typename Real>
std::vector<Real> random_numbers(size_t count, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<Real> value(Real(-1), Real(1));
  std::vector<Real> numbers(count);
  for (Real& number : numbers) number = value(random);
  return numbers;
}

template <typename Real>
bool same_bits(const std::vector<Real>& a, const std::vector<Real>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(Real)) == 0;
}

// Pivot block of `columns`, a multiple of kTile, with a small random lower triangle and a unit diagonal.
template <typename Real>
std::vector<Real> pivot_block(int columns) {
  std::vector<Real> pivot =
      random_numbers<Real>(static_cast<size_t>(triangle_offset<Real>(strips_of<Real>(columns))), 1);
  for (Real& number : pivot) number /= static_cast<Real>(columns);
  for (int c = 0; c < columns; ++c) {
    const int s = c / kStrip<Real>;
    pivot[triangle_offset<Real>(s) + c * kStrip<Real> + c % kStrip<Real>] = Real(1);
  }
  return pivot;
}

template <typename Real>
void check_solve(int columns, int strips) {
  const std::vector<Real> pivot = pivot_block<Real>(columns);
  const size_t size = static_cast<size_t>(kStrip<Real>) * columns;
  std::vector<Real> narrow = random_numbers<Real>(size * strips, 2), wide = narrow;
  const auto solve = [&](std::vector<Real>& border, bool in_pairs) {
    for (int block = 0; block < columns; block += kColumnBlock)
      solve_strips(pivot.data(), block, std::min(block + kColumnBlock, columns), 0, strips, in_pairs,
                   [&](int s) { return border.data() + s * size; });
  };
  solve(narrow, false);
  solve(wide, true);
  CHECK(same_bits(narrow, wide));
}

template <typename Real>
void check_update(int columns, int strips, int first) {
  const auto border = random_numbers<Real>(static_cast<size_t>(kStrip<Real>) * columns * strips, 3);
  std::vector<Real> narrow(static_cast<size_t>(triangle_offset<Real>(strips)), Real(0)), wide = narrow;
  form_update(narrow.data(), border.data(), columns, first, strips, false);
  form_update(wide.data(), border.data(), columns, first, strips, true);
  CHECK(same_bits(narrow, wide));
}

}  // namespace

TEST_CASE_TEMPLATE("fronts: pairs of strips have the bits of single ones", Real, float, double) {
  if (!cpu_features().avx512) {
    MESSAGE("skipped: this processor has no AVX-512");
    return;
  }
  for (int columns : {4, 24, 100, 260})
    for (int strips : {1, 2, 3, 8, 11}) {
      CAPTURE(columns);
      CAPTURE(strips);
      check_solve<Real>(columns, strips);
      for (int first : {0, 1, strips - 1}) check_update<Real>(columns, strips, first);
    }
}

TEST_CASE_TEMPLATE("fronts: the update matrix is minus the border times its transpose", Real, float, double) {
  const int columns = 28, strips = 5, rows = strips * kStrip<Real>;
  const auto border = random_numbers<Real>(static_cast<size_t>(columns) * rows, 4);
  const auto entry = [&](int row, int column) {
    return border[(static_cast<size_t>(row / kStrip<Real>) * columns + column) * kStrip<Real> +
                  row % kStrip<Real>];
  };
  const double tolerance = 50.0 * std::numeric_limits<Real>::epsilon();
  for (bool wide : {false, cpu_features().avx512}) {
    std::vector<Real> update(static_cast<size_t>(triangle_offset<Real>(strips)));
    form_update(update.data(), border.data(), columns, 0, strips, wide);
    double worst = 0.0;
    for (int row = 0; row < rows; ++row)
      for (int column = 0; column <= row; ++column) {
        double expected = 0.0;
        for (int k = 0; k < columns; ++k)
          expected -= static_cast<double>(entry(row, k)) * static_cast<double>(entry(column, k));
        const double found =
            update[triangle_offset<Real>(row / kStrip<Real>) + column * kStrip<Real> + row % kStrip<Real>];
        worst = std::max(worst, std::abs(found - expected));
      }
    CHECK(worst < tolerance);
  }
}
