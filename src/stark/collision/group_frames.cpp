// See group_frames.h.
#include <stark/collision/group_frames.h>

#include <algorithm>
#include <limits>

namespace stark {

namespace {

constexpr size_t kFewestSites = 64;

/// Least thickness over length of what has a frame: weights of corners grow with its inverse.
constexpr double kThinnest = 1e-3;

/// Rounding of a sum of four products, and of the position of a site, in units of the last place.
constexpr double kSumRounding = 8.0;

using Sites = std::array<Vec3, 4>;

Sites gather(const std::array<int32_t, 4>& sites, std::span<const Vec3> x) {
  return {x[sites[0]], x[sites[1]], x[sites[2]], x[sites[3]]};
}

double largest_of(const Sites& p) {
  return std::max({max_abs(p[0]), max_abs(p[1]), max_abs(p[2]), max_abs(p[3])});
}

Vec3 combine(const std::array<double, 4>& weights, const Sites& p) {
  return p[0] * weights[0] + p[1] * weights[1] + p[2] * weights[2] + p[3] * weights[3];
}

/// The site for which `measure` is largest.
template <typename Measure>
int32_t find_most(std::span<const int32_t> sites, std::span<const Vec3> x, Measure&& measure) {
  return *std::ranges::max_element(sites, {}, [&](int32_t site) { return measure(x[site]); });
}

/// Turns what is given along the world's axes into axes along an edge and in a face of the four points.
Mat3 turn_into(const Sites& p) {
  const Vec3 along = normalized(p[1] - p[0]);
  const Vec3 up = normalized(cross(along, p[2] - p[0]));
  return transpose(Mat3::from_columns(along, cross(up, along), up));
}

/// Displacements of the four sites, and what rounding makes of their positions.
struct Motion {
  Motion(const GroupFrame& frame, std::span<const Vec3> x0, std::span<const Vec3> x1) {
    const Sites from = gather(frame.sites, x0), to = gather(frame.sites, x1);
    for (size_t k = 0; k < sites.size(); ++k) sites[k] = to[k] - from[k];
    rounding = frame.rounding * std::max(largest_of(from), largest_of(to));
  }

  Sites sites;
  double rounding;  ///< [m]
};

}  // namespace

std::array<int32_t, 3> find_spanning_sites(std::span<const int32_t> sites, std::span<const Vec3> x) {
  const int32_t a = find_most(sites, x, [&](const Vec3& p) { return squared_norm(p - x[sites[0]]); });
  const int32_t b = find_most(sites, x, [&](const Vec3& p) { return squared_norm(p - x[a]); });
  const Vec3 line = x[b] - x[a];
  return {a, b, find_most(sites, x, [&](const Vec3& p) { return squared_norm(cross(p - x[a], line)); })};
}

std::optional<GroupFrame> find_frame(std::span<const int32_t> sites, std::span<const Vec3> x) {
  if (sites.size() < kFewestSites) return {};
  GroupFrame frame;
  auto& [a, b, c, d] = frame.sites;
  std::ranges::copy(find_spanning_sites(sites, x), frame.sites.begin());
  const Vec3 line = x[b] - x[a];
  const Vec3 normal = cross(line, x[c] - x[a]);
  const auto height = [&](const Vec3& p) { return std::fabs(dot(p - x[a], normal)); };
  d = find_most(sites, x, height);
  if (!(height(x[d]) > kThinnest * norm(line) * norm(normal))) return {};

  const Sites p = gather(frame.sites, x);
  const Mat3 axes = turn_into(p);
  Bounds box;
  for (const int32_t site : sites) box.add(axes * (x[site] - p[0]));
  const Mat3 edges = Mat3::from_columns(axes * (p[1] - p[0]), axes * (p[2] - p[0]), axes * (p[3] - p[0]));
  const Mat3 to_weights = inverse(edges);
  double most = 0.0;
  for (size_t k = 0; k < frame.corners.size(); ++k) {
    const Vec3 corner{(k & 1) != 0 ? box.high.x : box.low.x, (k & 2) != 0 ? box.high.y : box.low.y,
                      (k & 4) != 0 ? box.high.z : box.low.z};
    const Vec3 w = to_weights * corner;
    frame.corners[k] = {1.0 - w.x - w.y - w.z, w.x, w.y, w.z};
    most = std::max(most, 1.0 + 2.0 * (std::fabs(w.x) + std::fabs(w.y) + std::fabs(w.z)));
  }
  frame.rounding = kSumRounding * std::numeric_limits<double>::epsilon() * most;
  return frame;
}

Bounds GroupFrame::bound(std::span<const Vec3> x) const {
  const Sites p = gather(sites, x);
  Bounds bounds;
  for (const auto& corner : corners) bounds.add(combine(corner, p));
  return enlarged(bounds, rounding * largest_of(p));
}

Bounds GroupFrame::bound_motion(std::span<const Vec3> x0, std::span<const Vec3> x1) const {
  const Motion motion(*this, x0, x1);
  Bounds bounds;
  for (const auto& corner : corners) bounds.add(combine(corner, motion.sites));
  return enlarged(bounds, motion.rounding);
}

double GroupFrame::farthest(std::span<const Vec3> x0, std::span<const Vec3> x1) const {
  const Motion motion(*this, x0, x1);
  double squared = 0.0;
  for (const auto& corner : corners) {
    const double distance = squared_norm(combine(corner, motion.sites));
    if (!(distance <= squared)) squared = distance;  // also NaN
  }
  return std::sqrt(squared) + 2.0 * motion.rounding;
}

}  // namespace stark
