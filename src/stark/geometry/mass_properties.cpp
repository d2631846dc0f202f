// Integrals over signed tetrahedra and triangles, cyclic Jacobi. See mass_properties.h.
#include <stark/geometry/mass_properties.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace stark {

namespace {

// Zeroth, first and second moments about a reference point: the integral of 1, r, r r^T.
struct Moments {
  double zeroth = 0.0;
  Vec3 first;
  Mat3 second;
};

MassProperties from_moments(const Moments& moments, const Vec3& reference, double density) {
  MassProperties result;
  result.measure = moments.zeroth;
  result.mass = density * moments.zeroth;
  if (moments.zeroth == 0.0) {
    result.centre = reference;
    return result;
  }
  const Vec3 centre = moments.first / moments.zeroth;
  const Mat3 central = moments.second - outer(centre, centre) * moments.zeroth;
  result.centre = reference + centre;
  result.inertia = (Mat3::identity() * trace(central) - central) * density;
  return result;
}

// Mean of the vertices in use; keeps the moments small so that the parallel axis shift does not cancel.
Vec3 mean_vertex(std::span<const Vec3> vertices, std::span<const Index3> triangles) {
  Vec3 sum;
  for (const Index3& t : triangles) sum += vertices[t[0]] + vertices[t[1]] + vertices[t[2]];
  return triangles.empty() ? sum : sum / (3.0 * static_cast<double>(triangles.size()));
}

}  // namespace

MassProperties compute_solid_mass_properties(std::span<const Vec3> vertices,
                                             std::span<const Index3> triangles, double density) {
  const Vec3 reference = mean_vertex(vertices, triangles);
  Moments moments;
  for (const Index3& t : triangles) {
    const Vec3 a = vertices[t[0]] - reference, b = vertices[t[1]] - reference, c = vertices[t[2]] - reference;
    const double six_volumes = dot(a, cross(b, c));
    const Vec3 sum = a + b + c;
    moments.zeroth += six_volumes / 6.0;
    moments.first += sum * (six_volumes / 24.0);
    // Tet with one vertex at the reference: integral of r r^T = 6V / 120 (sum of x x^T over vertices + s
    // s^T).
    moments.second += (outer(a, a) + outer(b, b) + outer(c, c) + outer(sum, sum)) * (six_volumes / 120.0);
  }
  return from_moments(moments, reference, density);
}

MassProperties compute_shell_mass_properties(std::span<const Vec3> vertices,
                                             std::span<const Index3> triangles, double area_density) {
  const Vec3 reference = mean_vertex(vertices, triangles);
  Moments moments;
  for (const Index3& t : triangles) {
    const Vec3 a = vertices[t[0]] - reference, b = vertices[t[1]] - reference, c = vertices[t[2]] - reference;
    const double area = 0.5 * norm(cross(b - a, c - a));
    const Vec3 sum = a + b + c;
    moments.zeroth += area;
    moments.first += sum * (area / 3.0);
    moments.second += (outer(a, a) + outer(b, b) + outer(c, c) + outer(sum, sum)) * (area / 12.0);
  }
  return from_moments(moments, reference, area_density);
}

PrincipalAxes compute_principal_axes(const Mat3& symmetric) {
  Mat3 a = symmetric;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < i; ++j) a(i, j) = a(j, i);
  }
  Mat3 v = Mat3::identity();
  constexpr int kMaxSweeps = 30;  // quadratic convergence: 5 or 6 are the rule
  for (int sweep = 0; sweep < kMaxSweeps; ++sweep) {
    if (a(0, 1) == 0.0 && a(0, 2) == 0.0 && a(1, 2) == 0.0) break;
    for (int p = 0; p < 2; ++p) {
      for (int q = p + 1; q < 3; ++q) {
        const double off = a(p, q);
        if (off == 0.0) continue;
        // An element that no longer changes its two diagonal entries is zero to working precision.
        if (std::fabs(a(p, p)) + std::fabs(off) * 1e-3 == std::fabs(a(p, p)) &&
            std::fabs(a(q, q)) + std::fabs(off) * 1e-3 == std::fabs(a(q, q))) {
          a(p, q) = a(q, p) = 0.0;
          continue;
        }
        const double theta = (a(q, q) - a(p, p)) / (2.0 * off);
        const double t = std::copysign(1.0, theta) / (std::fabs(theta) + std::sqrt(theta * theta + 1.0));
        const double c = 1.0 / std::sqrt(t * t + 1.0), s = t * c;
        const int r = 3 - p - q;
        const double arp = a(r, p), arq = a(r, q);
        a(p, p) -= t * off;
        a(q, q) += t * off;
        a(p, q) = a(q, p) = 0.0;
        a(r, p) = a(p, r) = c * arp - s * arq;
        a(r, q) = a(q, r) = s * arp + c * arq;
        for (int k = 0; k < 3; ++k) {
          const double vkp = v(k, p), vkq = v(k, q);
          v(k, p) = c * vkp - s * vkq;
          v(k, q) = s * vkp + c * vkq;
        }
      }
    }
  }
  std::array<int, 3> order = {0, 1, 2};
  std::stable_sort(order.begin(), order.end(), [&](int i, int j) { return a(i, i) < a(j, j); });
  const auto oriented = [](Vec3 column) {
    int largest = 0;
    for (int k = 1; k < 3; ++k) {
      // Ties up to rounding go to the first, so that symmetric input does not flip with the last bit.
      if (std::fabs(column[k]) > std::fabs(column[largest]) * (1.0 + 1e-9)) largest = k;
    }
    return column[largest] < 0.0 ? -column : column;
  };
  const Vec3 first = oriented(normalized(v.column(order[0])));
  Vec3 second = v.column(order[1]);
  second = oriented(normalized(second - first * dot(first, second)));
  PrincipalAxes result;
  result.values = {a(order[0], order[0]), a(order[1], order[1]), a(order[2], order[2])};
  result.axes = Mat3::from_columns(first, second, cross(first, second));
  return result;
}

}  // namespace stark
