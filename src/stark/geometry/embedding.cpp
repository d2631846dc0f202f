// See embedding.h.
#include <stark/geometry/embedding.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace stark {

namespace {

/// Least weight of a node in a direction: it keeps every node heavy.
constexpr double kLeastWeight = 0.01;

constexpr int kMaxIterations = 30;

/// Coordinates of the points in a direction, sorted.
std::vector<double> places_of(std::span<const Vec3> points, int axis) {
  std::vector<double> places;
  for (const Vec3& p : points) places.push_back(p[axis]);
  std::ranges::sort(places);
  const auto is_same = [](double a, double b) { return std::fabs(a - b) < 1e-9; };
  places.erase(std::unique(places.begin(), places.end(), is_same), places.end());
  return places;
}

/// Weights at two places, or at three places that are symmetrical, for a mean and a mean square.
std::array<double, 3> weights_at(std::span<const double> places, double mean, double mean_square) {
  constexpr double least = kLeastWeight;
  if (places.size() == 2) {
    const double second = (mean - places[0]) / (places[1] - places[0]);
    const double w = std::clamp(second, least, 1.0 - least);
    return {1.0 - w, w, 0.0};
  }
  const double middle = places[1], reach = places[2] - middle;
  const double variance = mean_square - 2.0 * middle * mean + middle * middle;
  const double difference = std::clamp((mean - middle) / reach, -1.0 + 3.0 * least, 1.0 - 3.0 * least);
  const double sum = std::clamp(variance / (reach * reach), std::fabs(difference) + 2.0 * least, 1.0 - least);
  return {0.5 * (sum - difference), 1.0 - sum, 0.5 * (sum + difference)};
}

}  // namespace

Vec3 find_reference_position(const SolidMesh& mesh, int64_t element, const Vec3& position) {
  const auto nodes = mesh.element(element);
  std::array<double, 27> N;
  std::array<Vec3, 27> G;
  Vec3 xi{0.5, 0.5, 0.5};
  for (int k = 0; k < kMaxIterations; ++k) {
    shape_functions(mesh.type, xi, N);
    shape_gradients(mesh.type, xi, G);
    Vec3 miss = position;
    Mat3 J;
    for (size_t a = 0; a < nodes.size(); ++a) {
      const Vec3& x = mesh.vertices[nodes[a]];
      miss -= x * N[a];
      J = J + outer(x, G[a]);
    }
    const Vec3 step = inverse(J) * miss;
    xi += step;
    if (!is_finite(xi)) break;
    if (max_abs(step) < 1e-14) return xi;
    if (k + 1 == kMaxIterations && max_abs(step) < 1e-9) return xi;
  }
  const double nan = std::numeric_limits<double>::quiet_NaN();
  return {nan, nan, nan};
}

void embedding_weights(const SolidMesh& mesh, size_t k, std::span<double> out) {
  const Vec3& x = mesh.vertices[mesh.first_embedded() + k];
  shape_functions(mesh.type, find_reference_position(mesh, mesh.embedding.elements[k], x), out);
}

std::vector<double> embedding_weights(const SolidMesh& mesh) {
  const size_t nodes = mesh.node_count(), count = mesh.embedding.elements.size();
  std::vector<double> weights(count * nodes);
  for (size_t k = 0; k < count; ++k) embedding_weights(mesh, k, std::span(weights).subspan(k * nodes, nodes));
  return weights;
}

void filled_rule(std::span<const Vec3> points, const CellFilling& filling, std::span<double> out) {
  std::fill(out.begin(), out.end(), 1.0);
  const Vec3 mean = filling.mean(), mean_square = filling.mean_square();
  for (int axis = 0; axis < 3; ++axis) {
    const std::vector<double> places = places_of(points, axis);
    const std::array<double, 3> weights = weights_at(places, mean[axis], mean_square[axis]);
    for (size_t q = 0; q < points.size(); ++q) {
      size_t nearest = 0;
      for (size_t k = 1; k < places.size(); ++k)
        if (std::fabs(points[q][axis] - places[k]) < std::fabs(points[q][axis] - places[nearest]))
          nearest = k;
      out[q] *= weights[nearest];
    }
  }
}

}  // namespace stark
