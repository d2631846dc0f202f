#include <stark/contact/group_margins.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include <stark/collision/group_clearances.h>

namespace stark {

namespace {

/// Largest margin over the distance within which a group acts: at 1 m/s and 1 mm, for 20 steps of 10 ms.
constexpr double kMostMargin = 200.0;

constexpr double kRounding = 1e-9;  ///< relative

double gap_along(const Bounds& a, const Bounds& b, int axis) {
  return std::max({0.0, a.low[axis] - b.high[axis], b.low[axis] - a.high[axis]});
}

double gap_of(const Bounds& a, const Bounds& b) {
  return norm(Vec3{gap_along(a, b, 0), gap_along(a, b, 1), gap_along(a, b, 2)});
}

}  // namespace

double GroupMargins::most(int32_t group) const {
  return std::max(kMostMargin * distance_[group], least_[group]);
}

std::vector<double> GroupMargins::wide(const PairFilter& filter, std::span<const Bounds> bounds) const {
  const auto count = static_cast<int32_t>(least_.size());
  std::vector<double> margin(count);
  for (int32_t g = 0; g < count; ++g) margin[g] = filter.allowed(g, g) ? least_[g] : most(g);
  // How far two groups may move together; each has half of it, if that is enough for the other.
  const auto narrow = [&](int32_t a, int32_t b) {
    const double reach =
        distance_[a] + distance_[b] +
        2.0 * (1.0 + detail::kSpareMotion) * std::max({margin[a], margin[b], least_[a], least_[b]});
    const double apart = std::max(gap_along(bounds[a], bounds[b], 1), gap_along(bounds[a], bounds[b], 2));
    if (apart * (1.0 - kRounding) > reach * (1.0 + kRounding)) return;  // half is enough for both
    if (!filter.allowed(a, b)) return;
    const double spare = gap_of(bounds[a], bounds[b]) * (1.0 - kRounding) - distance_[a] - distance_[b];
    const double both = spare / (1.0 + detail::kSpareMotion);
    margin[a] = std::min(margin[a], both - std::max(0.5 * both, least_[b]));
    margin[b] = std::min(margin[b], both - std::max(0.5 * both, least_[a]));
  };
  std::vector<int32_t> order(count);
  std::iota(order.begin(), order.end(), 0);
  std::ranges::sort(order, {}, [&](int32_t g) { return std::pair(bounds[g].low.x, g); });
  double farthest = 0.0;
  for (int32_t g = 0; g < count; ++g) farthest = std::max(farthest, 2.0 * most(g) + distance_[g]);
  for (int32_t i = 0; i < count; ++i) {
    const int32_t a = order[i];
    const double rim = bounds[a].high.x + 2.0 * most(a) + distance_[a] + farthest;
    for (int32_t j = i + 1; j < count && bounds[order[j]].low.x <= rim; ++j) narrow(a, order[j]);
  }
  for (int32_t g = 0; g < count; ++g) margin[g] = std::max(margin[g], least_[g]);
  return margin;
}

}  // namespace stark
