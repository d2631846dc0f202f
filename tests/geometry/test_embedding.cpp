// Embedded vertices and rules for cells that are filled in part.
#include <doctest/doctest.h>

#include <cmath>

#include <stark/geometry/embedding.h>
#include <stark/geometry/shapes.h>
#include <support/random_points.h>

using namespace stark;
using namespace stark::test;

namespace {

/// Filling by the box [low, high] in a cell.
CellFilling box_filling(const Vec3& low, const Vec3& high) {
  CellFilling f{.part = 1.0};
  for (int k = 0; k < 3; ++k) {
    f.part *= high[k] - low[k];
    f.mean[k] = 0.5 * (low[k] + high[k]);
    f.mean_square[k] = (low[k] * low[k] + low[k] * high[k] + high[k] * high[k]) / 3.0;
  }
  return f;
}

std::vector<Vec3> points_of(ElementType type) {
  std::vector<Vec3> points;
  for (const QuadraturePoint& q : reference_element(type).quadrature) points.push_back(q.position);
  return points;
}

}  // namespace

TEST_CASE("reference positions are found in distorted hexahedra, and weights carry affine functions") {
  RandomPoints random(3);
  for (const bool quadratic : {false, true}) {
    SolidMesh mesh = make_hex_box({1, 2, 3}, {1, 1, 1});
    if (quadratic) mesh = to_quadratic(mesh);
    for (Vec3& x : mesh.vertices) x += random.point() * 0.05;
    for (int trial = 0; trial < 50; ++trial) {
      const Vec3 xi = random.point() * 0.5 + Vec3{0.5, 0.5, 0.5};
      std::vector<double> N(mesh.node_count());
      shape_functions(mesh.type, xi, N);
      Vec3 x;
      for (int a = 0; a < mesh.node_count(); ++a) x += mesh.vertices[mesh.elements[a]] * N[a];
      CHECK(norm(find_reference_position(mesh, 0, x) - xi) < 1e-12);
      SolidMesh with = mesh;
      with.vertices.push_back(x);
      with.embedding.elements = {0};
      std::vector<double> weights(mesh.node_count());
      embedding_weights(with, 0, weights);
      for (int a = 0; a < mesh.node_count(); ++a) CHECK(std::fabs(weights[a] - N[a]) < 1e-12);
    }
    CHECK(!is_finite(find_reference_position(mesh, 0, Vec3{1e300, 1e300, 1e300})));
  }
}

TEST_CASE("full cells have Gauss's rule and the weights of whole nodes") {
  for (const ElementType type : {ElementType::Hex8, ElementType::Hex27}) {
    const auto& rule = reference_element(type).quadrature;
    std::vector<double> weights(rule.size());
    filled_rule(points_of(type), {}, weights);
    for (size_t q = 0; q < rule.size(); ++q)
      CHECK(weights[q] == doctest::Approx(rule[q].weight).epsilon(1e-12));
  }
}

TEST_CASE("rules of filled cells are positive and have volume, mean and mean square of the filling") {
  RandomPoints random(4);
  for (const ElementType type : {ElementType::Hex8, ElementType::Hex27}) {
    const std::vector<Vec3> points = points_of(type);
    std::vector<double> weights(points.size());
    for (int trial = 0; trial < 200; ++trial) {
      Vec3 low, high;
      for (int k = 0; k < 3; ++k) {
        low[k] = 0.15 * (1.0 + random.point().x);
        high[k] = 1.0 - 0.15 * (1.0 + random.point().x);
      }
      const CellFilling filling = box_filling(low, high);
      filled_rule(points, filling, weights);
      double sum = 0.0;
      Vec3 mean;
      for (size_t q = 0; q < points.size(); ++q) {
        CHECK(weights[q] > 0.0);
        sum += weights[q];
        mean += points[q] * weights[q];
      }
      CHECK(sum == doctest::Approx(1.0).epsilon(1e-13));
      CHECK(norm(mean - filling.mean) < 1e-13);  // all those means are between the Gauss points
      if (type == ElementType::Hex8) continue;
      double square = 0.0;
      for (size_t q = 0; q < points.size(); ++q) square += weights[q] * points[q].x * points[q].x;
      // Of boxes in the middle half the variance is below what positive weights at the corners can have.
      CHECK(square == doctest::Approx(filling.mean_square.x).epsilon(0.02));
    }
    for (const Vec3& corner : {Vec3{0.0, 0.0, 0.0}, Vec3{1.0, 0.0, 1.0}}) {
      filled_rule(points, {0.01, corner, {corner.x, corner.y, corner.z}}, weights);
      double sum = 0.0;
      for (const double w : weights) {
        CHECK(w >= 0.99e-6);
        sum += w;
      }
      CHECK(sum == doctest::Approx(1.0));
    }
  }
}
