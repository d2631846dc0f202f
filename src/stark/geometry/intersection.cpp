// Exact predicates in expansion arithmetic and tests built on them. See intersection.h.
#include <stark/geometry/intersection.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace stark {

namespace {

// Sum of non-overlapping doubles of increasing magnitude: the exact value of a sum or product. Capacities
// below are the worst cases of the determinants (orient3d: 6 products of three 2-term differences, 16 terms
// each, 96 in all).
template <int Capacity>
struct Expansion {
  std::array<double, Capacity> term;
  int size = 0;

  int sign() const { return size == 0 ? 0 : (term[size - 1] > 0.0 ? 1 : -1); }
};

// a + b = sum + error, exactly (Knuth).
void two_sum(double a, double b, double& sum, double& error) {
  sum = a + b;
  const double b_part = sum - a, a_part = sum - b_part;
  error = (a - a_part) + (b - b_part);
}

// a b = product + error, exactly (underflow excepted).
void two_product(double a, double b, double& product, double& error) {
  product = a * b;
  error = std::fma(a, b, -product);
}

// expansion += value, zeros eliminated (grow-expansion).
template <int Capacity>
void grow(Expansion<Capacity>& expansion, double value) {
  int size = 0;
  for (int k = 0; k < expansion.size; ++k) {
    double error;
    two_sum(value, expansion.term[k], value, error);
    if (error != 0.0) expansion.term[size++] = error;
  }
  if (value != 0.0) expansion.term[size++] = value;
  expansion.size = size;
}

Expansion<2> difference(double a, double b) {
  Expansion<2> result;
  double sum, error;
  two_sum(a, -b, sum, error);
  if (error != 0.0) result.term[result.size++] = error;
  if (sum != 0.0) result.term[result.size++] = sum;
  return result;
}

template <int A, int B>
Expansion<2 * A * B> multiply(const Expansion<A>& a, const Expansion<B>& b) {
  Expansion<2 * A * B> result;
  for (int i = 0; i < a.size; ++i) {
    for (int j = 0; j < b.size; ++j) {
      double product, error;
      two_product(a.term[i], b.term[j], product, error);
      grow(result, error);
      grow(result, product);
    }
  }
  return result;
}

template <int A, int B>
Expansion<A + B> subtract(const Expansion<A>& a, const Expansion<B>& b) {
  Expansion<A + B> result;
  std::copy(a.term.begin(), a.term.begin() + a.size, result.term.begin());
  result.size = a.size;
  for (int j = 0; j < b.size; ++j) grow(result, -b.term[j]);
  return result;
}

template <int A, int B>
Expansion<A + B> add(const Expansion<A>& a, const Expansion<B>& b) {
  Expansion<A + B> result;
  std::copy(a.term.begin(), a.term.begin() + a.size, result.term.begin());
  result.size = a.size;
  for (int j = 0; j < b.size; ++j) grow(result, b.term[j]);
  return result;
}

int orient3d_exact(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const auto ux = difference(b.x, a.x), uy = difference(b.y, a.y), uz = difference(b.z, a.z);
  const auto vx = difference(c.x, a.x), vy = difference(c.y, a.y), vz = difference(c.z, a.z);
  const auto wx = difference(d.x, a.x), wy = difference(d.y, a.y), wz = difference(d.z, a.z);
  const auto x = multiply(subtract(multiply(uy, vz), multiply(uz, vy)), wx);
  const auto y = multiply(subtract(multiply(uz, vx), multiply(ux, vz)), wy);
  const auto z = multiply(subtract(multiply(ux, vy), multiply(uy, vx)), wz);
  return add(add(x, y), z).sign();
}

int orient2d_exact(double ax, double ay, double bx, double by, double cx, double cy) {
  return subtract(multiply(difference(bx, ax), difference(cy, ay)),
                  multiply(difference(by, ay), difference(cx, ax)))
      .sign();
}

// Relative error of the floating determinants per unit of the sum of magnitudes; a little above Shewchuk's
// (3 + 16 eps) eps and (7 + 56 eps) eps with eps = 2^-53.
constexpr double kOrient2dBound = 3.4e-16, kOrient3dBound = 7.9e-16;

struct Point2 {
  double x, y;
};

int orient(const Point2& a, const Point2& b, const Point2& c) {
  return orient2d(a.x, a.y, b.x, b.y, c.x, c.y);
}

bool in_box(const Point2& p, const Point2& q, const Point2& r) {
  return std::min(p.x, q.x) <= r.x && r.x <= std::max(p.x, q.x) && std::min(p.y, q.y) <= r.y &&
         r.y <= std::max(p.y, q.y);
}

bool segments_intersect(const Point2& p, const Point2& q, const Point2& a, const Point2& b) {
  const int pq_a = orient(p, q, a), pq_b = orient(p, q, b), ab_p = orient(a, b, p), ab_q = orient(a, b, q);
  if (pq_a * pq_b < 0 && ab_p * ab_q < 0) return true;
  return (pq_a == 0 && in_box(p, q, a)) || (pq_b == 0 && in_box(p, q, b)) || (ab_p == 0 && in_box(a, b, p)) ||
         (ab_q == 0 && in_box(a, b, q));
}

bool segment_intersects_triangle_2d(const Point2& p, const Point2& q, const Point2& a, const Point2& b,
                                    const Point2& c) {
  if (segments_intersect(p, q, a, b) || segments_intersect(p, q, b, c) || segments_intersect(p, q, c, a))
    return true;
  const int s0 = orient(a, b, p), s1 = orient(b, c, p), s2 = orient(c, a, p);
  return s0 != 0 && s0 == s1 && s1 == s2;
}

bool coplanar_segment_intersects_triangle(const Vec3& p, const Vec3& q, const Vec3& a, const Vec3& b,
                                          const Vec3& c) {
  // A plane maps one to one onto at least one coordinate plane, and an overlap shows in all three.
  const auto overlaps = [&](auto project) {
    return segment_intersects_triangle_2d(project(p), project(q), project(a), project(b), project(c));
  };
  return overlaps([](const Vec3& v) { return Point2{v.x, v.y}; }) &&
         overlaps([](const Vec3& v) { return Point2{v.y, v.z}; }) &&
         overlaps([](const Vec3& v) { return Point2{v.z, v.x}; });
}

}  // namespace

int orient2d(double ax, double ay, double bx, double by, double cx, double cy) {
  const double left = (bx - ax) * (cy - ay), right = (by - ay) * (cx - ax);
  const double determinant = left - right;
  if (std::fabs(determinant) > kOrient2dBound * (std::fabs(left) + std::fabs(right)))
    return determinant > 0.0 ? 1 : -1;
  return orient2d_exact(ax, ay, bx, by, cx, cy);
}

int orient3d(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const Vec3 u = b - a, v = c - a, w = d - a;
  const double yz = u.y * v.z, zy = u.z * v.y, zx = u.z * v.x, xz = u.x * v.z, xy = u.x * v.y, yx = u.y * v.x;
  const double determinant = (yz - zy) * w.x + (zx - xz) * w.y + (xy - yx) * w.z;
  const double magnitude = (std::fabs(yz) + std::fabs(zy)) * std::fabs(w.x) +
                           (std::fabs(zx) + std::fabs(xz)) * std::fabs(w.y) +
                           (std::fabs(xy) + std::fabs(yx)) * std::fabs(w.z);
  if (std::fabs(determinant) > kOrient3dBound * magnitude) return determinant > 0.0 ? 1 : -1;
  return orient3d_exact(a, b, c, d);
}

bool segment_intersects_triangle(const Vec3& p, const Vec3& q, const Vec3& a, const Vec3& b, const Vec3& c) {
  const int side_p = orient3d(a, b, c, p), side_q = orient3d(a, b, c, q);
  if (side_p * side_q > 0) return false;
  if (side_p == 0 && side_q == 0) return coplanar_segment_intersects_triangle(p, q, a, b, c);
  const int ab = orient3d(p, q, a, b), bc = orient3d(p, q, b, c);
  if (ab * bc < 0) return false;
  const int ca = orient3d(p, q, c, a);
  return !(ab * ca < 0 || bc * ca < 0);
}

Vec3 meeting_point(const Vec3& p, const Vec3& q, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 n = cross(b - a, c - a), d = q - p;
  const double height_p = dot(n, p - a), height_q = dot(n, q - a);
  const int side_p = orient3d(a, b, c, p), side_q = orient3d(a, b, c, q);
  if ((side_p != 0 || side_q != 0) && height_p != height_q)
    return p + d * std::clamp(height_p / (height_p - height_q), 0.0, 1.0);
  double low = 0.0, high = 1.0;  // of the segment, cut by the planes across the edges
  for (const auto& [from, to] : {std::pair(a, b), std::pair(b, c), std::pair(c, a)}) {
    const Vec3 inward = cross(n, to - from);
    const double at = dot(inward, p - from), rate = dot(inward, d);
    if (rate > 0.0) low = std::max(low, -at / rate);
    if (rate < 0.0) high = std::min(high, -at / rate);
  }
  return p + d * std::clamp(0.5 * (low + high), 0.0, 1.0);
}

PointLocation locate_point(const Vec3& p, std::span<const Vec3> vertices, std::span<const Index3> triangles) {
  if (triangles.empty()) return PointLocation::Outside;
  Vec3 low = vertices[triangles[0][0]], high = low;
  for (const Index3& t : triangles) {
    for (const int32_t v : t) {
      const Vec3& x = vertices[v];
      low = {std::min(low.x, x.x), std::min(low.y, x.y), std::min(low.z, x.z)};
      high = {std::max(high.x, x.x), std::max(high.y, x.y), std::max(high.z, x.z)};
    }
  }
  if (p.x < low.x || p.y < low.y || p.z < low.z || p.x > high.x || p.y > high.y || p.z > high.z) {
    return PointLocation::Outside;
  }
  // Segments to far points in fixed directions of no particular symmetry; one that meets an edge or a vertex
  // of the mesh is dropped for the next.
  const double reach = 4.0 * (norm(high - low) + max_abs(p) * 1e-12);
  constexpr int kMaxDirections = 64;
  for (int k = 0; k < kMaxDirections; ++k) {
    const double azimuth = 0.7390851 + 2.399963 * k, z = std::cos(1.0 + 1.618034 * k);
    const double r = std::sqrt(1.0 - z * z);
    const Vec3 far = p + Vec3{r * std::cos(azimuth), r * std::sin(azimuth), z} * reach;
    bool inside = false, degenerate = false;
    for (const Index3& t : triangles) {
      const Vec3 &a = vertices[t[0]], &b = vertices[t[1]], &c = vertices[t[2]];
      const int side_p = orient3d(a, b, c, p);
      if (side_p == 0 && segment_intersects_triangle(p, p, a, b, c)) return PointLocation::OnSurface;
      const int side_far = orient3d(a, b, c, far);
      if (side_p == 0 && side_far != 0) continue;  // leaves the plane at p, which is not in the triangle
      if (side_p * side_far > 0) continue;
      const int ab = orient3d(p, far, a, b), bc = orient3d(p, far, b, c), ca = orient3d(p, far, c, a);
      if (ab * bc < 0 || bc * ca < 0 || ab * ca < 0) continue;
      if (ab == 0 || bc == 0 || ca == 0 || side_far == 0) {
        degenerate = true;
        continue;  // keep looking for OnSurface
      }
      inside = !inside;
    }
    if (!degenerate) return inside ? PointLocation::Inside : PointLocation::Outside;
  }
  return PointLocation::OnSurface;
}

}  // namespace stark
