// See nonnegative_fit.h.
#include <stark/geometry/nonnegative_fit.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

namespace stark {

namespace {

constexpr double kSmallestGain = 1e-12;  ///< slope of the squared error over |a_k| |b|
constexpr double kDependent = 1e-10;     ///< squared distance from the others, over the squared length

class Fit {
 public:
  Fit(std::span<const double> columns, std::span<const double> b, std::vector<double> start)
      : columns_(columns), b_(b), rows_(b.size()), coefficients_(std::move(start)) {
    coefficients_.resize(columns.size() / rows_, 0.0);
    for (size_t k = 0; k < coefficients_.size(); ++k) {
      lengths_.push_back(std::sqrt(dot(column(k), column(k))));
      if (coefficients_[k] > 0.0) in_.push_back(k);
    }
  }

  std::vector<double> run() {
    const size_t most_steps = 3 * coefficients_.size();
    if (solve()) settle();
    for (size_t step = 0; step < most_steps && add_steepest(); ++step) settle();
    return std::move(coefficients_);
  }

 private:
  std::span<const double> column(size_t k) const { return columns_.subspan(k * rows_, rows_); }

  static double dot(std::span<const double> a, std::span<const double> b) {
    double sum = 0.0;
    for (size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
    return sum;
  }

  /// Takes in the column that lessens the error most, if one does and is independent of those that are in.
  bool add_steepest() {
    if (in_.size() == rows_) return false;
    std::vector<double> error(b_.begin(), b_.end());
    for (const size_t k : in_)
      for (size_t i = 0; i < rows_; ++i) error[i] -= coefficients_[k] * column(k)[i];
    const double least = kSmallestGain * std::sqrt(dot(b_, b_));
    std::vector<size_t> order;
    std::vector<double> slope(coefficients_.size(), 0.0);
    for (size_t k = 0; k < coefficients_.size(); ++k) {
      slope[k] = dot(column(k), error);
      if (slope[k] > least * lengths_[k] && std::ranges::find(in_, k) == in_.end()) order.push_back(k);
    }
    std::ranges::stable_sort(order, std::greater(), [&](size_t k) { return slope[k]; });
    for (const size_t k : order) {
      in_.push_back(k);
      if (solve() && wanted_.back() > 0.0) return true;
      in_.pop_back();
    }
    return false;
  }

  /// Goes to the best coefficients of the columns that are in, which solve() has found; without those that
  /// would be negative.
  void settle() {
    while (!move() && solve()) {
    }
  }

  /// As far as none is negative; those that reach zero are out. True: all of the way.
  bool move() {
    double way = 1.0;
    size_t first = in_.size();  // the one that reaches zero first
    for (size_t i = 0; i < in_.size(); ++i) {
      const double c = coefficients_[in_[i]];
      if (wanted_[i] > 0.0 || c / (c - wanted_[i]) >= way) continue;
      way = c / (c - wanted_[i]);
      first = i;
    }
    for (size_t i = 0; i < in_.size(); ++i) {
      double& c = coefficients_[in_[i]];
      c = i == first ? 0.0 : std::max(0.0, c + way * (wanted_[i] - c));
    }
    std::erase_if(in_, [&](size_t k) { return coefficients_[k] == 0.0; });
    return first == wanted_.size();
  }

  /// Best coefficients, whatever their sign, by Cholesky's method; false where columns are dependent.
  bool solve() {
    const size_t n = in_.size();
    std::vector<double> L(n * n);
    wanted_.assign(n, 0.0);
    for (size_t i = 0; i < n; ++i) {
      for (size_t j = 0; j <= i; ++j) {
        double sum = dot(column(in_[i]), column(in_[j]));
        const double whole = sum;
        for (size_t k = 0; k < j; ++k) sum -= L[i * n + k] * L[j * n + k];
        if (i == j && !(sum > kDependent * whole)) return false;
        L[i * n + j] = i == j ? std::sqrt(sum) : sum / L[j * n + j];
      }
      wanted_[i] = dot(column(in_[i]), b_);
      for (size_t k = 0; k < i; ++k) wanted_[i] -= L[i * n + k] * wanted_[k];
      wanted_[i] /= L[i * n + i];
    }
    for (size_t i = n; i-- > 0;) {
      for (size_t k = i + 1; k < n; ++k) wanted_[i] -= L[k * n + i] * wanted_[k];
      wanted_[i] /= L[i * n + i];
    }
    return true;
  }

  std::span<const double> columns_, b_;
  size_t rows_;
  std::vector<double> coefficients_, lengths_;
  std::vector<size_t> in_;      ///< columns whose coefficients are free
  std::vector<double> wanted_;  ///< by place in in_
};

}  // namespace

std::vector<double> nonnegative_fit(std::span<const double> columns, std::span<const double> b,
                                    std::vector<double> start) {
  return Fit(columns, b, std::move(start)).run();
}

}  // namespace stark
