// Barrier energy of contact: E = kappa b(d, d_hat), b = -(d - d_hat)^2 ln(d / d_hat) for d < d_hat
// [theory eq. 16; Li et al. 2020, "Incremental Potential Contact", eq. 6, in the distance instead of its
// square]. b is C2 at d_hat. A second barrier of the same form is infinite at a least distance, below which
// collision detection would end a step [theory eq. 16d]. Near-parallel edges are mollified with m(c) =
// (2 - c/eps) c/eps, c = |e_a x e_b|^2 [theory eq. 17; Li et al. 2020, eq. 24], since the distance of lines
// is not differentiable there. kappa [N/m] is the contact's own (contact/contact_law.h).
#include <stark/contact/distance.h>

namespace stark::models {

namespace {

Scalar barrier(PotentialBuilder& b, const Scalar& d) {
  const Scalar kappa = b.data("stiffness", "N/m", "barrier stiffness of the pair");
  const Scalar d_hat = b.data("contact_distance", "m", "distance below which the pair repels");
  const Scalar least = b.data("least_distance", "m", "distance at which the barrier is infinite");
  const Scalar u = (d - least) / least;
  const Scalar wall = select(u < 1.0, square(d_hat) * square(u - 1.0) * log(u), 0.0);
  return -(kappa * (square(d - d_hat) * log(d / d_hat) + wall));
}

Scalar mollifier(PotentialBuilder& b) {
  const Scalar c = squared_norm(cross(b.x(1) - b.x(0), b.x(3) - b.x(2)));
  const Scalar ratio =
      c / b.data("parallel_threshold", "m^4", "squared cross product below which edges are mollified");
  return ratio * (2.0 - ratio);
}

/// Puts vertices a and b of the stencil at a given distance along z, keeping the others in their own planes.
PotentialSample sample_apart(std::mt19937_64& random, std::vector<stark::Vec3> a, std::vector<stark::Vec3> b,
                             double parallel_threshold) {
  std::uniform_real_distribution<double> noise(-0.02, 0.02), gap(0.1, 0.9);
  const double d = 0.3 * gap(random);
  PotentialSample sample;
  for (const stark::Vec3& p : a) sample.x.push_back(p + stark::Vec3{noise(random), noise(random), d});
  for (const stark::Vec3& p : b) sample.x.push_back(p + stark::Vec3{noise(random), noise(random), 0.0});
  sample.X = sample.x_prev = sample.x;
  sample.values = {{"contact_distance", {0.3}},
                   {"least_distance", {0.015}},
                   {"stiffness", {2.0}},
                   {"parallel_threshold", {parallel_threshold}}};
  return sample;
}

using Points = std::vector<stark::Vec3>;

PotentialDefinition barrier_potential(const std::string& stencil, Points a, Points b,
                                      double parallel_threshold,
                                      std::function<Scalar(PotentialBuilder&)> energy) {
  PotentialDefinition definition =
      define_potential("barrier_" + stencil, static_cast<int>(a.size() + b.size()),
                       "contact barrier, stencil " + stencil, std::move(energy));
  definition.sample = [=](std::mt19937_64& random) { return sample_apart(random, a, b, parallel_threshold); };
  return definition;
}

}  // namespace

PotentialDefinition barrier_point_point() {
  return barrier_potential("point_point", Points{{0, 0, 0}}, Points{{0, 0, 0}}, 1.0, [](PotentialBuilder& b) {
    return barrier(b, point_point_distance(b.x(0), b.x(1)));
  });
}

PotentialDefinition barrier_point_edge() {
  return barrier_potential(
      "point_edge", Points{{0, 0, 0}}, Points{{-1, 0, 0}, {1, 0, 0}}, 1.0,
      [](PotentialBuilder& b) { return barrier(b, point_edge_distance(b.x(0), b.x(1), b.x(2))); });
}

PotentialDefinition barrier_point_triangle() {
  return barrier_potential("point_triangle", Points{{0, 0, 0}}, Points{{-1, -1, 0}, {1, -1, 0}, {0, 1, 0}},
                           1.0, [](PotentialBuilder& b) {
                             return barrier(b, point_triangle_distance(b.x(0), b.x(1), b.x(2), b.x(3)));
                           });
}

PotentialDefinition barrier_edge_edge() {
  return barrier_potential(
      "edge_edge", Points{{-1, 0, 0}, {1, 0, 0}}, Points{{0, -1, 0}, {0, 1, 0}}, 1.0,
      [](PotentialBuilder& b) { return barrier(b, edge_edge_distance(b.x(0), b.x(1), b.x(2), b.x(3))); });
}

// The mollified stencils order the vertices such that the closest ends come first: point 0 of edge (0, 1)
// against point 2 or against edge (2, 3).

PotentialDefinition barrier_mollified_point_point() {
  return barrier_potential(
      "mollified_point_point", Points{{0, 0, 0}, {-1, 0.1, 0}}, Points{{0, 0, 0}, {1, 0, 0}}, 1.0,
      [](PotentialBuilder& b) { return mollifier(b) * barrier(b, point_point_distance(b.x(0), b.x(2))); });
}

PotentialDefinition barrier_mollified_point_edge() {
  return barrier_potential("mollified_point_edge", Points{{0, 0, 0}, {2, 0.2, 0.1}},
                           Points{{-1, 0, 0}, {1, 0, 0}}, 1.0, [](PotentialBuilder& b) {
                             return mollifier(b) * barrier(b, point_edge_distance(b.x(0), b.x(2), b.x(3)));
                           });
}

PotentialDefinition barrier_mollified_edge_edge() {
  return barrier_potential("mollified_edge_edge", Points{{-1, 0.3, 0}, {1, -0.3, 0}},
                           Points{{-1, 0, 0}, {1, 0, 0}}, 4.0, [](PotentialBuilder& b) {
                             return mollifier(b) *
                                    barrier(b, edge_edge_distance(b.x(0), b.x(1), b.x(2), b.x(3)));
                           });
}

}  // namespace stark::models
