// Envelope Cholesky in reverse Cuthill-McKee order (George and Liu 1981).
#include <stark/linalg/cholesky.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include <stark/base/error.h>

namespace stark {

template <typename Real>
struct Cholesky<Real>::Implementation {
  BlockPattern pattern;
  std::vector<int32_t> order, position;
  std::vector<int64_t> start;   // of scalar row i: entries of columns first[i]..i
  std::vector<int32_t> first;
  AlignedVector<Real> values;
  std::vector<Real> y;
  double flops = 0.0;
  int64_t orderings = 0, analyses = 0;
};

template <typename Real>
Cholesky<Real>::Cholesky() : implementation_(std::make_unique<Implementation>()) {}
template <typename Real>
Cholesky<Real>::~Cholesky() = default;
template <typename Real>
Cholesky<Real>::Cholesky(Cholesky&&) noexcept = default;
template <typename Real>
Cholesky<Real>& Cholesky<Real>::operator=(Cholesky&&) noexcept = default;

template <typename Real>
void Cholesky<Real>::analyze(const BlockPattern& pattern, std::span<const Vec3>) {
  Implementation& s = *implementation_;
  s.pattern = pattern;
  ++s.analyses;
  const int32_t n = pattern.block_count;
  if (static_cast<int32_t>(s.order.size()) != n || n == 0) {
    ++s.orderings;
    std::vector<std::vector<int32_t>> neighbors(n);
    for (int32_t i = 0; i < n; ++i)
      for (int64_t k = pattern.row_start[i] + 1; k < pattern.row_start[i + 1]; ++k) {
        neighbors[i].push_back(pattern.column[k]);
        neighbors[pattern.column[k]].push_back(i);
      }
    s.order.clear();
    std::vector<char> seen(n, 0);
    for (int32_t root = 0; root < n; ++root) {
      if (seen[root]) continue;
      size_t head = s.order.size();
      s.order.push_back(root);
      seen[root] = 1;
      for (; head < s.order.size(); ++head)
        for (int32_t j : neighbors[s.order[head]])
          if (!seen[j]) seen[j] = 1, s.order.push_back(j);
    }
    std::reverse(s.order.begin(), s.order.end());
  }
  s.position.resize(n);
  for (int32_t p = 0; p < n; ++p) s.position[s.order[p]] = p;
  std::vector<int32_t> first(n);
  for (int32_t p = 0; p < n; ++p) first[p] = p;
  for (int32_t i = 0; i < n; ++i)
    for (int64_t k = pattern.row_start[i]; k < pattern.row_start[i + 1]; ++k) {
      const int32_t a = s.position[i], b = s.position[pattern.column[k]];
      first[std::max(a, b)] = std::min(first[std::max(a, b)], std::min(a, b));
    }
  s.first.resize(3 * n);
  s.start.assign(3 * n + 1, 0);
  s.flops = 0.0;
  for (int32_t i = 0; i < 3 * n; ++i) {
    s.first[i] = 3 * first[i / 3];
    const int64_t width = i - s.first[i] + 1;
    s.start[i + 1] = s.start[i] + width;
    s.flops += static_cast<double>(width) * static_cast<double>(width);
  }
}

template <typename Real>
FactorStatus Cholesky<Real>::factor(const BlockMatrix& matrix, ThreadPool&) {
  Implementation& s = *implementation_;
  STARK_CHECK(matrix.pattern.block_count == s.pattern.block_count &&
              matrix.pattern.slot_count() == s.pattern.slot_count());
  const int32_t n = s.pattern.block_count;
  s.values.assign(s.start[3 * n], Real(0));
  for (int32_t i = 0; i < n; ++i)
    for (int64_t k = s.pattern.row_start[i]; k < s.pattern.row_start[i + 1]; ++k)
      for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 3; ++c) {
          const int32_t a = 3 * s.position[i] + r, b = 3 * s.position[s.pattern.column[k]] + c;
          const int32_t row = std::max(a, b), col = std::min(a, b);
          s.values[s.start[row] + col - s.first[row]] = static_cast<Real>(matrix.values[9 * k + 3 * r + c]);
        }
  for (int32_t i = 0; i < 3 * n; ++i) {
    Real* row = s.values.data() + s.start[i] - s.first[i];
    for (int32_t j = s.first[i]; j <= i; ++j) {
      const Real* other = s.values.data() + s.start[j] - s.first[j];
      Real sum = row[j];
      for (int32_t k = std::max(s.first[i], s.first[j]); k < j; ++k) sum -= row[k] * other[k];
      if (j < i) {
        row[j] = sum / other[j];
      } else {
        if (!(sum > Real(0))) return {false, s.order[i / 3]};
        row[i] = std::sqrt(sum);
      }
    }
  }
  return {};
}

template <typename Real>
void Cholesky<Real>::solve(const double* b, double* x) {
  Implementation& s = *implementation_;
  const int32_t n = 3 * s.pattern.block_count;
  s.y.resize(n);
  for (int32_t i = 0; i < n; ++i) s.y[i] = static_cast<Real>(b[3 * s.order[i / 3] + i % 3]);
  for (int32_t i = 0; i < n; ++i) {
    const Real* row = s.values.data() + s.start[i] - s.first[i];
    Real sum = s.y[i];
    for (int32_t k = s.first[i]; k < i; ++k) sum -= row[k] * s.y[k];
    s.y[i] = sum / row[i];
  }
  for (int32_t i = n - 1; i >= 0; --i) {
    const Real* row = s.values.data() + s.start[i] - s.first[i];
    s.y[i] /= row[i];
    for (int32_t k = s.first[i]; k < i; ++k) s.y[k] -= row[k] * s.y[i];
  }
  for (int32_t i = 0; i < n; ++i) x[3 * s.order[i / 3] + i % 3] = static_cast<double>(s.y[i]);
}

template <typename Real>
double Cholesky<Real>::flops() const { return implementation_->flops; }
template <typename Real>
int64_t Cholesky<Real>::factor_nonzeros() const { return implementation_->start.empty() ? 0 : implementation_->start.back(); }
template <typename Real>
int64_t Cholesky<Real>::ordering_count() const { return implementation_->orderings; }
template <typename Real>
int64_t Cholesky<Real>::analysis_count() const { return implementation_->analyses; }

template class Cholesky<double>;
template class Cholesky<float>;

}  // namespace stark
