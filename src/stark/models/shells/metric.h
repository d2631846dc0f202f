// Kinematics of triangles shared by the membrane laws, from edge metrics: with g_ij = e_i . e_j of the
// deformed and G of the rest edges, C = G^-1 g is the right Cauchy-Green tensor of the 3x2 deformation
// gradient in mixed components.
#pragma once

#include <stark/mechanics/define.h>

namespace stark::models {

struct Metric {
  Scalar g11, g12, g22;
  Scalar determinant() const { return g11 * g22 - g12 * g12; }
};

inline Metric metric(const Vec3& p0, const Vec3& p1, const Vec3& p2) {
  const Vec3 e1 = p1 - p0, e2 = p2 - p0;
  return {dot(e1, e1), dot(e1, e2), dot(e2, e2)};
}

inline Metric current_metric(PotentialBuilder& b) { return metric(b.x(0), b.x(1), b.x(2)); }
/// What the change of the metric within the step is measured from.
inline Metric reference_metric(PotentialBuilder& b) {
  const Vec3 g = b.reference([&](auto p) {
    const Metric m = metric((b.*p)(0), (b.*p)(1), (b.*p)(2));
    return Vec3(m.g11, m.g12, m.g22);
  });
  return {g[0], g[1], g[2]};
}
inline Metric rest_metric(PotentialBuilder& b) { return metric(b.X(0), b.X(1), b.X(2)); }

/// Mixed components of G^-1 g, row by row.
struct MixedTensor {
  Scalar c11, c12, c21, c22;
};

inline MixedTensor mixed(const Metric& G, const Metric& g) {
  const Scalar scale = 1.0 / G.determinant();
  return {scale * (G.g22 * g.g11 - G.g12 * g.g12), scale * (G.g22 * g.g12 - G.g12 * g.g22),
          scale * (G.g11 * g.g12 - G.g12 * g.g11), scale * (G.g11 * g.g22 - G.g12 * g.g12)};
}

inline Scalar rest_area(PotentialBuilder& b) { return 0.5 * sqrt(rest_metric(b).determinant()); }

}  // namespace stark::models
