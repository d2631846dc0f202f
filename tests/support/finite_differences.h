// Derivatives by central differences with extrapolation to zero step [Ridders 1982]: the oracle for exact
// derivatives.
#pragma once

#include <array>
#include <cmath>
#include <limits>
#include <vector>

namespace stark::test {

/// Derivative of a vector function of one number at t = 0, component by component. `first_step` is small
/// against the length on which the function bends; the tableau divides it by two nine times and keeps the
/// entry whose neighbours agree best, so that neither truncation nor cancellation spoils the result.
template <typename Function>
std::vector<double> differentiate(Function&& f, double first_step) {
  constexpr int kRows = 10;
  std::array<std::array<std::vector<double>, kRows>, kRows> table;
  std::vector<double> best, error;
  double step = first_step;
  for (int i = 0; i < kRows; ++i, step *= 0.5) {
    const std::vector<double> plus = f(step), minus = f(-step);
    const size_t n = plus.size();
    table[i][0].resize(n);
    if (i == 0) {
      best.resize(n);
      error.assign(n, std::numeric_limits<double>::infinity());
    }
    for (size_t k = 0; k < n; ++k) table[i][0][k] = (plus[k] - minus[k]) / (2.0 * step);
    double factor = 4.0;
    for (int j = 1; j <= i; ++j, factor *= 4.0) {
      table[i][j].resize(n);
      for (size_t k = 0; k < n; ++k) {
        table[i][j][k] = (factor * table[i][j - 1][k] - table[i - 1][j - 1][k]) / (factor - 1.0);
        const double estimate = std::fmax(std::fabs(table[i][j][k] - table[i][j - 1][k]),
                                          std::fabs(table[i][j][k] - table[i - 1][j - 1][k]));
        if (estimate < error[k]) {
          error[k] = estimate;
          best[k] = table[i][j][k];
        }
      }
    }
  }
  return best;
}

/// As above for a scalar function.
template <typename Function>
double differentiate_scalar(Function&& f, double first_step) {
  return differentiate([&](double t) { return std::vector<double>{f(t)}; }, first_step)[0];
}

}  // namespace stark::test
