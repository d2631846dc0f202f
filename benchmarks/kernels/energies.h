// The energies of the kernel benchmark, 12 unknowns each: four points, or two rigid bodies with linear and
// angular increments. The unknowns are velocities, x = x0 + dt v, except in tet_nh; rest shapes are inverted
// in the kernel. Every energy comes with inputs that make sense, one random element at a time.
#pragma once

#include <stark/symbolic/tensor.h>

#include <cmath>
#include <functional>
#include <random>
#include <string>
#include <vector>

namespace stark::symbolic::bench {

using Random = std::mt19937_64;
inline double uniform(Random& r, double a, double b) {
  return std::uniform_real_distribution<double>(a, b)(r);
}

struct Energy {
  std::string name;
  std::function<Scalar(Graph&)> build;
  /// Values of one element: unknowns, element inputs; and the uniforms, which are the same at every call.
  std::function<void(Random&, std::vector<double>& unknowns, std::vector<double>& elements)> sample;
  std::vector<double> uniforms;
};

struct Points {
  Vec3 x[4];
};
/// x0 + dt v for four points.
inline Points moving_points(Graph& g, const Scalar& dt) {
  Points p;
  for (auto& x : p.x) {
    const Vec3 v = input_vector<3>(g, InputKind::Unknown), x0 = input_vector<3>(g, InputKind::Element);
    x = x0 + dt * v;
    mark_stage(g, x);
  }
  return p;
}
inline Mat3 edge_matrix(const Vec3* x) { return Mat3::from_columns(x[1] - x[0], x[2] - x[0], x[3] - x[0]); }

/// Neo-Hookean: mu/2 (tr F^T F - 3) - mu log J + lambda/2 log^2 J.
inline Scalar tet_nh(Graph& g) {
  Vec3 x[4];
  for (auto& p : x) p = input_vector<3>(g, InputKind::Unknown);
  const Mat3 Dm_inverse = input_matrix<3, 3>(g, InputKind::Element);
  const Scalar volume = g.input(InputKind::Element);
  const Scalar mu = g.input(InputKind::Uniform), lambda = g.input(InputKind::Uniform);
  const Mat3 F = edge_matrix(x) * Dm_inverse;
  mark_stage(g, F);
  const Scalar log_J = log(determinant(F));
  return volume * (0.5 * mu * (squared_norm(F) - 3.0) - mu * log_J + 0.5 * lambda * square(log_J));
}

/// Stable Neo-Hookean [Smith et al. 2018]; with_all adds strain-rate damping and a strain limit (a branch).
inline Scalar tet_stable(Graph& g, bool with_all) {
  const Scalar dt = g.input(InputKind::Uniform), E = g.input(InputKind::Uniform),
               nu = g.input(InputKind::Uniform);
  const Points p = moving_points(g, dt);
  Vec3 X[4];
  for (auto& q : X) q = input_vector<3>(g, InputKind::Element);
  const Mat3 Dm = edge_matrix(X);
  const Mat3 Dm_inverse = inverse(Dm);
  const Mat3 F = edge_matrix(p.x) * Dm_inverse;
  mark_stage(g, F);
  const Scalar mu = E / (2.0 * (1.0 + nu)), lambda = E * nu / ((1.0 + nu) * (1.0 - 2.0 * nu)) + mu;
  const Scalar Ic = squared_norm(F), alpha = 1.0 + 0.75 * mu / lambda;
  Scalar psi =
      0.5 * mu * (Ic - 3.0) + 0.5 * lambda * square(determinant(F) - alpha) - 0.5 * mu * log(Ic + 1.0);
  if (with_all) {
    const Scalar damping = g.input(InputKind::Uniform), limit = g.input(InputKind::Uniform),
                 stiffness = g.input(InputKind::Uniform);
    const Mat3 F0 = input_matrix<3, 3>(g, InputKind::Element);
    const Mat3 strain = 0.5 * (transpose(F) * F - Mat3::identity()),
               strain0 = 0.5 * (transpose(F0) * F0 - Mat3::identity());
    psi += 0.5 * damping * squared_norm((strain - strain0) / dt);
    const Scalar excess = sqrt(squared_norm(strain) + 1e-12) - limit;
    psi += select(excess > 0.0, stiffness * excess * excess * excess / 3.0, 0.0);
  }
  return psi * determinant(Dm) / 6.0;
}

/// Discrete shell bending [Bergou et al. 2006]: stiffness (theta - rest)^2 with the dihedral angle by atan2,
/// and damping.
inline Scalar shell(Graph& g) {
  const Scalar dt = g.input(InputKind::Uniform), stiffness = g.input(InputKind::Uniform),
               damping = g.input(InputKind::Uniform);
  const Points p = moving_points(g, dt);
  const Scalar rest = g.input(InputKind::Element), previous = g.input(InputKind::Element),
               weight = g.input(InputKind::Element);
  const Vec3 e = p.x[1] - p.x[0];
  const Vec3 n0 = cross(e, p.x[2] - p.x[0]), n1 = cross(p.x[3] - p.x[0], e);
  const Scalar theta = atan2(dot(cross(n0, n1), e) / norm(e), dot(n0, n1));
  return weight * (stiffness * square(theta - rest) + 0.5 * damping * square((theta - previous) / dt));
}

/// -(d - d_hat)^2 log(d / d_hat) for a distance d.
inline Scalar barrier(const Scalar& d, const Scalar& d_hat, const Scalar& stiffness) {
  return -stiffness * square(d - d_hat) * log(d / d_hat);
}

/// Log barrier of the distance between two lines, mollified where they become parallel (a branch) [Li et al.
/// 2020].
inline Scalar edge_edge(const Vec3& a0, const Vec3& a1, const Vec3& b0, const Vec3& b1, const Scalar& scale,
                        const Scalar& d_hat, const Scalar& stiffness) {
  const Vec3 u = a1 - a0, n = cross(u, b1 - b0);
  const Scalar c = squared_norm(n);
  const Scalar d = sqrt(square(dot(b0 - a0, n)) / c);
  const Scalar r = c / scale;
  return select(c < scale, (2.0 - r) * r, 1.0) * barrier(d, d_hat, stiffness);
}

inline Scalar ee(Graph& g) {
  const Scalar dt = g.input(InputKind::Uniform), d_hat = g.input(InputKind::Uniform),
               stiffness = g.input(InputKind::Uniform);
  const Points p = moving_points(g, dt);
  const Scalar scale = g.input(InputKind::Element);
  return edge_edge(p.x[0], p.x[1], p.x[2], p.x[3], scale, d_hat, stiffness);
}

inline Scalar pt(Graph& g) {
  const Scalar dt = g.input(InputKind::Uniform), d_hat = g.input(InputKind::Uniform),
               stiffness = g.input(InputKind::Uniform);
  const Points p = moving_points(g, dt);
  const Vec3 n = cross(p.x[2] - p.x[1], p.x[3] - p.x[1]);
  return barrier(sqrt(square(dot(p.x[0] - p.x[1], n)) / squared_norm(n)), d_hat, stiffness);
}

/// Translation and rotation after a step: quaternion q0 + dt/2 (0, w) q0, normalised.
struct Body {
  Vec3 t;
  Mat3 R;
};
inline Body moving_body(Graph& g, const Scalar& dt) {
  const Vec3 v = input_vector<3>(g, InputKind::Unknown), w = input_vector<3>(g, InputKind::Unknown);
  const Vec3 t0 = input_vector<3>(g, InputKind::Element);
  const Vec4 q0 = input_vector<4>(g, InputKind::Element);
  const Vec3 q0v{q0[1], q0[2], q0[3]};
  const Scalar half = 0.5 * dt;
  const Vec3 qv = q0v + half * (q0[0] * w + cross(w, q0v));
  Vec4 q{q0[0] - half * dot(w, q0v), qv[0], qv[1], qv[2]};
  q = q / norm(q);
  const Scalar s = q[0], x = q[1], y = q[2], z = q[3];
  const Mat3 R(1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - s * z), 2.0 * (x * z + s * y),
               2.0 * (x * y + s * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - s * x),
               2.0 * (x * z - s * y), 2.0 * (y * z + s * x), 1.0 - 2.0 * (x * x + y * y));
  return {t0 + dt * v, R};
}

/// Ball point and common direction of two bodies.
inline Scalar hinge(Graph& g) {
  const Scalar dt = g.input(InputKind::Uniform), stiffness = g.input(InputKind::Uniform);
  const Body a = moving_body(g, dt), b = moving_body(g, dt);
  const auto local = [&] { return input_vector<3>(g, InputKind::Element); };
  const Vec3 pa = a.t + a.R * local(), pb = b.t + b.R * local(), da = a.R * local(), db = b.R * local();
  for (const Vec3& s : {pa, pb, da, db}) mark_stage(g, s);
  return 0.5 * stiffness * (squared_norm(pa - pb) + squared_norm(da - db));
}

/// Edges of two bodies.
inline Scalar rbee(Graph& g) {
  const Scalar dt = g.input(InputKind::Uniform), d_hat = g.input(InputKind::Uniform),
               stiffness = g.input(InputKind::Uniform);
  const Body a = moving_body(g, dt), b = moving_body(g, dt);
  const auto local = [&] { return input_vector<3>(g, InputKind::Element); };
  const Vec3 a0 = a.t + a.R * local(), a1 = a.t + a.R * local(), b0 = b.t + b.R * local(),
             b1 = b.t + b.R * local();
  for (const Vec3& s : {a0, a1, b0, b1}) mark_stage(g, s);
  return edge_edge(a0, a1, b0, b1, g.input(InputKind::Element), d_hat, stiffness);
}

inline std::vector<Energy> all_energies() {
  using Values = std::vector<double>;
  const double dt = 0.01;
  const double tet[12] = {0.0, 0.0, 0.0, 1.0, 0.1, 0.0, 0.0, 1.1, 0.1, 0.1, 0.0, 0.9};
  const auto velocities = [](Random& r, Values& u, double size) {
    for (int i = 0; i < 12; ++i) u.push_back(uniform(r, -size, size));
  };
  const auto near = [](Random& r, Values& e, const double* x, double noise) {
    for (int i = 0; i < 12; ++i) e.push_back(x[i] + uniform(r, -noise, noise));
  };
  const auto bodies = [velocities](Random& r, Values& u, Values& e, const double (&t)[6]) {
    velocities(r, u, 0.3);
    for (int body = 0; body < 2; ++body) {
      for (int i = 0; i < 3; ++i) e.push_back(t[3 * body + i] + uniform(r, -0.02, 0.02));
      const double q[4] = {1.0, uniform(r, -0.2, 0.2), uniform(r, -0.2, 0.2), uniform(r, -0.2, 0.2)};
      const double length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
      for (const double c : q) e.push_back(c / length);
    }
  };
  static const double quad[12] = {0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.4, 0.9, 0.1, 0.6, -0.8, 0.15};
  static const double edges[12] = {-1.0, 0.0, 0.0, 1.0, 0.0, 0.1, 0.0, -1.0, 0.3, 0.1, 1.0, 0.3};
  static const double over[12] = {0.3, 0.3, 0.35, 0.0, 0.0, 0.0, 1.0, 0.0, 0.05, 0.0, 1.0, 0.0};
  static double tet_rest[12];
  for (int i = 0; i < 12; ++i) tet_rest[i] = tet[i];

  std::vector<Energy> all;
  all.push_back({"tet_nh",
                 tet_nh,
                 [=](Random& r, Values& u, Values& e) {
                   near(r, u, tet_rest, 0.1);
                   for (int i = 0; i < 9; ++i) e.push_back((i % 4 == 0 ? 1.0 : 0.0) + uniform(r, -0.1, 0.1));
                   e.push_back(uniform(r, 0.1, 0.2));
                 },
                 {3.0e4, 8.0e4}});
  all.push_back({"tet_snh",
                 [](Graph& g) { return tet_stable(g, false); },
                 [=](Random& r, Values& u, Values& e) {
                   velocities(r, u, 1.0);
                   near(r, e, tet_rest, 0.1);
                   near(r, e, tet_rest, 0.01);
                 },
                 {dt, 1.0e5, 0.4}});
  all.push_back({"tet_full",
                 [](Graph& g) { return tet_stable(g, true); },
                 [=](Random& r, Values& u, Values& e) {
                   velocities(r, u, 1.0);
                   near(r, e, tet_rest, 0.1);
                   near(r, e, tet_rest, 0.01);
                   for (int i = 0; i < 9; ++i) e.push_back((i % 4 == 0 ? 1.0 : 0.0) + uniform(r, -0.1, 0.1));
                 },
                 {dt, 1.0e5, 0.4, 10.0, 0.1, 1.0e6}});
  all.push_back({"shell",
                 shell,
                 [=](Random& r, Values& u, Values& e) {
                   velocities(r, u, 1.0);
                   near(r, e, quad, 0.1);
                   e.push_back(uniform(r, -0.5, 0.5));
                   e.push_back(uniform(r, -0.5, 0.5));
                   e.push_back(uniform(r, 0.5, 2.0));
                 },
                 {dt, 0.1, 0.01}});
  all.push_back({"ee",
                 ee,
                 [=](Random& r, Values& u, Values& e) {
                   velocities(r, u, 1.0);
                   near(r, e, edges, 0.1);
                   e.push_back(uniform(r, 0.0, 1.0) < 0.3 ? 30.0 : 0.01);
                 },
                 {dt, 0.6, 1.0e4}});
  all.push_back({"pt",
                 pt,
                 [=](Random& r, Values& u, Values& e) {
                   velocities(r, u, 1.0);
                   near(r, e, over, 0.1);
                 },
                 {dt, 0.6, 1.0e4}});
  all.push_back({"hinge",
                 hinge,
                 [=](Random& r, Values& u, Values& e) {
                   bodies(r, u, e, {0.0, 0.0, 0.0, 1.0, 0.0, 0.0});
                   // Element inputs come in the order of creation: after the bodies two points and two
                   // directions.
                   for (const double sign : {1.0, -1.0}) {
                     e.push_back(0.5 * sign);
                     e.push_back(uniform(r, -0.1, 0.1));
                     e.push_back(uniform(r, -0.1, 0.1));
                   }
                   for (int k = 0; k < 2; ++k) {
                     e.push_back(0.0);
                     e.push_back(0.0);
                     e.push_back(1.0);
                   }
                 },
                 {dt, 1.0e6}});
  all.push_back({"rbee",
                 rbee,
                 [=](Random& r, Values& u, Values& e) {
                   bodies(r, u, e, {0.0, 0.0, 0.0, 0.0, 0.0, 0.3});
                   const double local[12] = {-1.0, 0.0,  0.05,  1.0, 0.0, 0.05,
                                             0.0,  -1.0, -0.05, 0.0, 1.0, -0.05};
                   near(r, e, local, 0.02);
                   e.push_back(uniform(r, 0.0, 1.0) < 0.3 ? 30.0 : 0.01);
                 },
                 {dt, 0.8, 1.0e4}});
  return all;
}

}  // namespace stark::symbolic::bench
