#include <stark/mechanics/plate_element.h>

#include <algorithm>
#include <cmath>
#include <map>

#include <stark/base/psd.h>

namespace stark {

namespace {

/// Compliance below which a combination of angles counts as impossible, over the largest compliance: six
/// points near a conic section. Without the limit such elements would be rigid.
constexpr double kSmallestCompliance = 1e-3;

/// Largest part that an angle may have in a prediction: beyond, the six points are near a conic section.
constexpr double kLargestShare = 10.0;

using Edge = std::pair<int32_t, int32_t>;

Edge undirected(int32_t a, int32_t b) { return {std::min(a, b), std::max(a, b)}; }

struct Hinge {
  int edge = 0;            ///< of the triangle, from vertex edge to edge + 1
  int32_t neighbour = -1;  ///< triangle beyond
  int32_t opposite = -1;   ///< its vertex off the edge
};

/// Hinges of each triangle, in the order of its edges.
std::vector<std::vector<Hinge>> find_neighbours(std::span<const Index3> triangles) {
  std::map<Edge, std::vector<std::pair<int32_t, int>>> sides;
  for (int32_t t = 0; t < static_cast<int32_t>(triangles.size()); ++t)
    for (int k = 0; k < 3; ++k)
      sides[undirected(triangles[t][k], triangles[t][(k + 1) % 3])].push_back({t, k});
  std::vector<std::vector<Hinge>> hinges(triangles.size());
  for (const auto& [edge, pair] : sides) {
    if (pair.size() != 2) continue;
    for (int s = 0; s < 2; ++s) {
      const auto [other, side] = pair[1 - s];
      hinges[pair[s].first].push_back({pair[s].second, other, triangles[other][(side + 2) % 3]});
    }
  }
  for (auto& list : hinges)
    std::sort(list.begin(), list.end(), [](const Hinge& a, const Hinge& b) { return a.edge < b.edge; });
  return hinges;
}

struct Point2 {
  double x = 0.0, y = 0.0;
};

double cross2(const Point2& a, const Point2& b, const Point2& p) {
  return (b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x);
}

/// Place of a point beyond edge a -> b of a triangle in its plane, with its distances to the ends as in
/// space.
Point2 unfold(const Point2& a, const Point2& b, const Vec3& A, const Vec3& B, const Vec3& P) {
  const Vec3 e = B - A;
  const double length = norm(e), along = dot(P - A, e) / length, beyond = norm(cross(P - A, e)) / length;
  const Point2 u{(b.x - a.x) / length, (b.y - a.y) / length};
  return {a.x + along * u.x + beyond * u.y, a.y + along * u.y - beyond * u.x};
}

/// Height of the surface above the line through a and b at point p, over the distance of p from the line:
/// what p adds to the fold angle there.
double slope(const Point2& a, const Point2& b, const Point2& p, double za, double zb, double zp) {
  // Not std::hypot, whose last bit differs from one processor to another.
  const double dx = b.x - a.x, dy = b.y - a.y, length = std::sqrt(dx * dx + dy * dy);
  const double distance = std::fabs(cross2(a, b, p)) / length;
  const double share = ((p.x - a.x) * dx + (p.y - a.y) * dy) / (length * length);
  return (zp - (1.0 - share) * za - share * zb) / distance;
}

/// Heights of the surfaces of unit curvature k11, k22, 2 k12.
std::array<double, 3> unit_curvatures(const Point2& p) {
  return {0.5 * p.x * p.x, 0.5 * p.y * p.y, 0.5 * p.x * p.y};
}

/// The triangle and the points beyond its hinges, unfolded into a plane.
std::array<Point2, 7> unfold(std::span<const Vec3> X, const PlateElement& element) {
  const auto& v = element.vertices;
  const Vec3 e = normalized(X[v[1]] - X[v[0]]), d = X[v[2]] - X[v[0]];
  const Vec3 across = normalized(d - e * dot(d, e));
  std::array<Point2, 7> p{{{0.0, 0.0}, {norm(X[v[1]] - X[v[0]]), 0.0}, {dot(d, e), dot(d, across)}}};
  for (int h = 0; h < element.hinge_count; ++h) {
    const auto [a, b, c, o] = plate_hinge(h);
    p[o] = unfold(p[a], p[b], X[v[a]], X[v[b]], X[v[o]]);
  }
  return p;
}

/// Fold angle of a hinge for unit curvatures: a row of C [m].
Vec3 fold_rates(const std::array<Point2, 7>& p, int hinge) {
  const auto [a, b, c, o] = plate_hinge(hinge);
  const auto za = unit_curvatures(p[a]), zb = unit_curvatures(p[b]), zc = unit_curvatures(p[c]),
             zo = unit_curvatures(p[o]);
  Vec3 rates;
  for (int k = 0; k < 3; ++k)
    rates[k] = slope(p[a], p[b], p[c], za[k], zb[k], zc[k]) + slope(p[a], p[b], p[o], za[k], zb[k], zo[k]);
  return rates;
}

Mat3 fold_rates(const std::array<Point2, 7>& p, const PlateElement& element) {
  Mat3 C;
  for (int h = 0; h < std::min(3, element.hinge_count); ++h)
    for (int k = 0; k < 3; ++k) C(h, k) = fold_rates(p, h)[k];
  return C;
}

void set_rest_angles(std::span<const Vec3> X, PlateElement& element) {
  const auto& v = element.vertices;
  for (int h = 0; h < element.hinge_count; ++h) {
    const auto [a, b, c, o] = plate_hinge(h);
    element.rest_angles[h] = fold_angle(X[v[a]], X[v[b]], X[v[c]], X[v[o]]);
  }
}

/// Of all hinges, for curvatures along and across the first edge of the triangle.
void set_angles_of_curvature(std::span<const Vec3> X, const std::array<Point2, 7>& p, PlateElement& element) {
  const auto& v = element.vertices;
  const Vec3 e = normalized(X[v[1]] - X[v[0]]), d = X[v[2]] - X[v[0]];
  const Vec3 f = normalized(d - e * dot(d, e));
  for (int h = 0; h < element.hinge_count; ++h) {
    const Vec3 rates = fold_rates(p, h) * -1.0;  // what rises beside an edge folds it by a negative angle
    const Mat3 both = outer(e, f) + outer(f, e);
    const Mat3 M = outer(e, e) * rates.x + outer(f, f) * rates.y + both * rates.z;
    element.angle_of_curvature[h] = {M(0, 0), M(1, 1), M(2, 2), 2.0 * M(1, 2), 2.0 * M(0, 2), 2.0 * M(0, 1)};
  }
}

template <typename Entry>
std::array<double, 10> form_of(const PlateElement& element, const Entry& entry) {
  std::array<double, 10> form{};
  size_t k = 0;
  for (int r = 0; r < 4; ++r)
    for (int c = r; c < 4; ++c, ++k) form[k] = c < element.hinge_count ? entry(r, c) : 0.0;
  return form;
}

/// The vertices of a triangle turned such that its hinges come first, then the ones beyond.
PlateElement place_element(const Index3& triangle, const std::vector<Hinge>& hinges, int first) {
  PlateElement element{.hinge_count = static_cast<int>(hinges.size())};
  for (int k = 0; k < 3; ++k) element.vertices[k] = triangle[(first + k) % 3];
  for (const Hinge& hinge : hinges) element.vertices[3 + (hinge.edge - first + 3) % 3] = hinge.opposite;
  return element;
}

/// `rates`: curvatures k11, k22, 2 k12 of unit fold angles.
void set_curvature(PlateElement& element, const Mat3& rates, const Mat3& remaining) {
  const double root = std::sqrt(0.5);
  for (int h = 0; h < 3; ++h) {
    element.curvature[h] = root * (rates(0, h) + rates(1, h));
    element.curvature[3 + h] = root * (rates(0, h) - rates(1, h));
    element.curvature[6 + h] = rates(2, h);
  }
  element.remaining_form = form_of(element, [&](int r, int c) { return remaining(r, c); });
}

PlateElement bending_element(std::span<const Vec3> X, const Index3& triangle,
                             const std::vector<Hinge>& hinges, double nu, double area) {
  const bool wraps = hinges.size() == 2 && hinges[1].edge - hinges[0].edge == 2;  // edges 2 and 0
  PlateElement element = place_element(triangle, hinges, wraps ? 2 : hinges.front().edge);
  set_rest_angles(X, element);
  const auto places = unfold(X, element);
  set_angles_of_curvature(X, places, element);
  const Mat3 C = fold_rates(places, element);
  const double f = 1.0 / (area * (1.0 - nu * nu));
  const Mat3 compliance{{f, -nu * f, 0, -nu * f, f, 0, 0, 0, 2.0 / (area * (1.0 - nu))}};
  Mat3 G = C * compliance * transpose(C);
  const double largest = trace(G);
  for (int h = element.hinge_count; h < 3; ++h) G(h, h) = largest;  // stands apart, and is left out below
  const Mat3 floor = Mat3::identity() * (kSmallestCompliance * largest);
  const Mat3 S = inverse(psd_project(G - floor) + floor);
  element.form = form_of(element, [&](int r, int c) { return S(r, c); });
  set_curvature(element, compliance * transpose(C) * S, S - S * G * S);
  element.area = area;
  return element;
}

/// The hinge at edge `shared` to `beyond` of the neighbour at `side` of a whole triangle, with the vertex
/// `far` beyond: held at the angle that the triangle's curvature predicts. `part`: of several predictions.
PlateElement boundary_element(std::span<const Vec3> X, const Index3& triangle,
                              const std::vector<Hinge>& hinges, int side, int32_t shared, int32_t far,
                              double area, double part) {
  PlateElement element = place_element(triangle, hinges, side);
  auto& v = element.vertices;
  if (v[0] != shared) {  // seen from the other side of the surface, where it is first
    std::swap(v[0], v[1]);
    std::swap(v[4], v[5]);
  }
  element.hinge_count = 4;
  v[6] = far;
  set_rest_angles(X, element);
  const auto p = unfold(X, element);
  set_angles_of_curvature(X, p, element);
  const Vec3 rates = fold_rates(p, 3);
  Vec3 share = transpose(inverse(fold_rates(p, element))) * rates;
  if (!(max_abs(share) < kLargestShare)) share = {};
  const std::array<double, 4> d{-share.x, -share.y, -share.z, 1.0};
  const double weight = part * squared_norm(X[v[3]] - X[v[0]]) / area;
  element.form = form_of(element, [&](int r, int c) { return weight * d[r] * d[c]; });
  return element;
}

/// Takes the triangles of a surface to elements.
class PlateBuilder {
 public:
  PlateBuilder(std::span<const Vec3> X, std::span<const Index3> triangles, double nu)
      : X_(X), triangles_(triangles), nu_(nu), hinges_(find_neighbours(triangles)) {
    for (size_t t = 0; t < triangles.size(); ++t) {
      const auto& v = triangles[t];
      own_area_.push_back(0.5 * norm(cross(X[v[1]] - X[v[0]], X[v[2]] - X[v[0]])));
      bends_.push_back(is_whole(static_cast<int32_t>(t)));
    }
  }

  std::vector<PlateElement> build() {
    for (int32_t t = 0; t < triangle_count(); ++t)
      for (const Hinge& hinge : hinges_[t])
        if (!is_whole(t) && !is_whole(hinge.neighbour) && t < hinge.neighbour) cover(t, hinge);
    const std::vector<double> areas = bending_areas();
    for (int32_t t = 0; t < triangle_count(); ++t)
      if (bends_[t]) {
        elements_.push_back(bending_element(X_, triangles_[t], hinges_[t], nu_, areas[t]));
        elements_.back().triangle = t;
      }
    return std::move(elements_);
  }

 private:
  int32_t triangle_count() const { return static_cast<int32_t>(triangles_.size()); }
  bool is_whole(int32_t t) const { return hinges_[t].size() == 3; }

  /// A hinge between two triangles at the boundary: predicted by their whole neighbours, all of them, so that
  /// no order of triangles matters, or left to the triangle that knows more of its own curvature.
  void cover(int32_t t, const Hinge& hinge) {
    const int32_t other = hinge.neighbour;
    const int32_t off = triangles_[t][(hinge.edge + 2) % 3];
    const int count = whole_neighbours(t) + whole_neighbours(other);
    if (count == 0) bends_[hinges_[other].size() > hinges_[t].size() ? other : t] = true;
    predict(t, hinge.opposite, count);
    predict(other, off, count);
  }

  int whole_neighbours(int32_t t) const {
    const auto is_at_whole = [&](const Hinge& hinge) { return is_whole(hinge.neighbour); };
    return static_cast<int>(std::ranges::count_if(hinges_[t], is_at_whole));
  }

  /// Adds an element for the hinge of t with the vertex `far` beyond for each whole triangle next to t, one
  /// of `count` of that hinge.
  void predict(int32_t t, int32_t far, int count) {
    const auto crossed =
        std::find_if(hinges_[t].begin(), hinges_[t].end(), [&](const Hinge& h) { return h.opposite == far; });
    for (const Hinge& hinge : hinges_[t]) {
      const int32_t whole = hinge.neighbour;
      if (!is_whole(whole)) continue;
      const auto back = std::find_if(hinges_[whole].begin(), hinges_[whole].end(),
                                     [&](const Hinge& h) { return h.neighbour == t; });
      const int32_t a = triangles_[t][crossed->edge], b = triangles_[t][(crossed->edge + 1) % 3];
      elements_.push_back(boundary_element(X_, triangles_[whole], hinges_[whole], back->edge,
                                           a == back->opposite ? b : a, far,
                                           own_area_[t] + own_area_[crossed->neighbour], 1.0 / count));
      elements_.back().triangle = whole;
    }
  }

  /// Triangles without an element leave their areas to neighbours that are nearer to one.
  std::vector<double> bending_areas() const {
    std::vector<int32_t> order, distance(own_area_.size(), -1);
    for (int32_t t = 0; t < triangle_count(); ++t)
      if (bends_[t]) {
        distance[t] = 0;
        order.push_back(t);
      }
    for (size_t k = 0; k < order.size(); ++k)
      for (const Hinge& hinge : hinges_[order[k]])
        if (distance[hinge.neighbour] < 0) {
          distance[hinge.neighbour] = distance[order[k]] + 1;
          order.push_back(hinge.neighbour);
        }
    std::vector<double> areas = own_area_;
    for (auto t = order.rbegin(); t != order.rend() && distance[*t] > 0; ++t) {
      std::vector<int32_t> heirs;
      for (const Hinge& hinge : hinges_[*t])
        if (distance[hinge.neighbour] < distance[*t]) heirs.push_back(hinge.neighbour);
      for (const int32_t heir : heirs) areas[heir] += areas[*t] / static_cast<double>(heirs.size());
    }
    return areas;
  }

  std::span<const Vec3> X_;
  std::span<const Index3> triangles_;
  double nu_;
  std::vector<std::vector<Hinge>> hinges_;
  std::vector<double> own_area_;
  std::vector<bool> bends_;  ///< has an element of its own
  std::vector<PlateElement> elements_;
};

}  // namespace

double fold_angle(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const Vec3 e = b - a, n = cross(e, c - a), m = cross(d - a, e);
  return std::atan2(dot(cross(n, m), e) / norm(e), dot(n, m));
}

std::array<int, 4> plate_hinge(int hinge) {
  if (hinge == 3) return {0, 3, 1, 6};
  return {hinge, (hinge + 1) % 3, (hinge + 2) % 3, 3 + hinge};
}

std::vector<PlateElement> find_plate_elements(std::span<const Vec3> X, std::span<const Index3> triangles,
                                              double poissons_ratio) {
  return PlateBuilder(X, triangles, poissons_ratio).build();
}

}  // namespace stark
