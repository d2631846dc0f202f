#include <stark/solve/low_rank.h>

#include <algorithm>
#include <cmath>

namespace stark {

namespace {

constexpr int kSweeps = 50;                ///< of rotations; few are needed
constexpr double kNegligible = 1e-30;      ///< squared, beside the diagonal
constexpr double kSmallestFactor = 1e-15;  ///< of the largest, below which an eigenvalue is rounding

double dot(std::span<const double> a, std::span<const double> b) {
  double sum = 0.0;
  for (size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
  return sum;
}

/// Eigenvalues of a small symmetric matrix A [n][n], on its diagonal, and eigenvectors in the columns of the
/// result, by cyclic rotations [Jacobi 1846].
std::vector<double> diagonalize(std::vector<double>& A, size_t n) {
  std::vector<double> V(n * n, 0.0);
  for (size_t i = 0; i < n; ++i) V[i * n + i] = 1.0;
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    double beside = 0.0, all = 0.0;
    for (size_t i = 0; i < n; ++i)
      for (size_t j = 0; j < n; ++j) (i == j ? all : beside) += A[i * n + j] * A[i * n + j];
    if (!(beside > kNegligible * all)) break;
    for (size_t p = 0; p < n; ++p)
      for (size_t q = p + 1; q < n; ++q) {
        if (A[p * n + q] == 0.0) continue;
        const double theta = (A[q * n + q] - A[p * n + p]) / (2.0 * A[p * n + q]);
        const double t = std::copysign(1.0, theta) / (std::fabs(theta) + std::sqrt(theta * theta + 1.0));
        const double c = 1.0 / std::sqrt(t * t + 1.0), s = t * c;
        const auto rotate = [&](double& x, double& y) {
          const double old = x;
          x = c * old - s * y;
          y = s * old + c * y;
        };
        for (size_t k = 0; k < n; ++k) rotate(A[k * n + p], A[k * n + q]);
        for (size_t k = 0; k < n; ++k) rotate(A[p * n + k], A[q * n + k]);
        for (size_t k = 0; k < n; ++k) rotate(V[k * n + p], V[k * n + q]);
      }
  }
  return V;
}

}  // namespace

void LowRank::add(const std::vector<std::vector<double>>& B, std::vector<double> C, bool project) {
  const size_t m = B.size();
  const std::vector<double> V = diagonalize(C, m);
  double largest = 0.0;
  for (size_t k = 0; k < m; ++k) largest = std::max(largest, std::fabs(C[k * m + k]));
  for (size_t k = 0; k < m; ++k) {
    const double factor = C[k * m + k];
    if (factor == 0.0 || std::fabs(factor) <= kSmallestFactor * largest || (project && factor < 0.0))
      continue;
    std::vector<double>& column = columns.emplace_back(B[0].size(), 0.0);
    for (size_t l = 0; l < m; ++l)
      for (size_t i = 0; i < column.size(); ++i) column[i] += V[l * m + k] * B[l][i];
    factors.push_back(factor);
  }
}

// A is positive definite. By the two ways to eliminate from [A B; B^T -C^-1], A + B C B^T has as many
// negative eigenvalues as C has beyond those of C^-1 + B^T Z.
bool LowRankCorrection::begin(const LowRank& terms, const Solve& solve) {
  terms_ = &terms;
  const size_t rank = terms.factors.size();
  solved_.assign(rank, {});
  for (size_t k = 0; k < rank; ++k) {
    solved_[k].assign(terms.columns[k].size(), 0.0);
    if (!solve(terms.columns[k], solved_[k])) return false;
  }
  std::vector<double> inner(rank * rank);
  for (size_t k = 0; k < rank; ++k) {
    for (size_t l = k; l < rank; ++l)
      inner[k * rank + l] = inner[l * rank + k] = dot(terms.columns[k], solved_[l]);
    inner[k * rank + k] += 1.0 / terms.factors[k];
  }
  const std::vector<double> V = diagonalize(inner, rank);
  size_t negative = 0;
  inverse_.assign(rank * rank, 0.0);
  for (size_t e = 0; e < rank; ++e) {
    const double value = inner[e * rank + e];
    if (value == 0.0 || !std::isfinite(value)) return false;
    negative += value < 0.0;
    for (size_t k = 0; k < rank; ++k)
      for (size_t l = 0; l < rank; ++l) inverse_[k * rank + l] += V[k * rank + e] * V[l * rank + e] / value;
  }
  return negative ==
         static_cast<size_t>(std::ranges::count_if(terms.factors, [](double c) { return c < 0.0; }));
}

std::vector<double> LowRankCorrection::take_out(std::span<double> r) const {
  std::vector<double> taken;
  for (const std::vector<double>& column : terms_->columns) {
    const double part = dot(column, r) / dot(column, column);
    for (size_t i = 0; i < r.size(); ++i) r[i] -= part * column[i];
    taken.push_back(part);
  }
  return taken;
}

void LowRankCorrection::put_back(std::span<const double> taken, std::span<double> y) const {
  for (size_t k = 0; k < taken.size(); ++k)
    for (size_t i = 0; i < y.size(); ++i) y[i] += taken[k] * solved_[k][i];
}

void LowRankCorrection::apply(std::span<double> y) const {
  const size_t rank = solved_.size();
  std::vector<double> projections;
  for (const std::vector<double>& column : terms_->columns) projections.push_back(dot(column, y));
  for (size_t k = 0; k < rank; ++k) {
    double factor = 0.0;
    for (size_t l = 0; l < rank; ++l) factor += inverse_[k * rank + l] * projections[l];
    for (size_t i = 0; i < y.size(); ++i) y[i] -= factor * solved_[k][i];
  }
}

}  // namespace stark
