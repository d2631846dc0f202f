// Embedded vertices and rules for cells that are filled in part.
#include <doctest/doctest.h>

#include <algorithm>
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

TEST_CASE("full cells have Gauss's rule, and masses of whole nodes") {
  for (const ElementType type : {ElementType::Hex8, ElementType::Hex27}) {
    const ReferenceElement& element = reference_element(type);
    for (const QuadraturePoint& q : element.quadrature)
      CHECK(norm(filled_position(type, {}, q.position) - q.position) < 1e-15);
    SolidMesh mesh = make_hex_box({1, 1, 1}, {1, 1, 1});
    if (type == ElementType::Hex27) mesh = to_quadratic(mesh);
    std::vector<double> whole(element.node_count), weights(element.node_count);
    lump_volume(mesh, 0, whole);
    filled_rule(element.nodes, {}, weights);
    for (int a = 0; a < element.node_count; ++a)
      CHECK(weights[a] == doctest::Approx(whole[a]).epsilon(1e-12));
  }
}

TEST_CASE("rules of filled cells have volume, mean and mean squares of the filling") {
  RandomPoints random(4);
  for (const ElementType type : {ElementType::Hex8, ElementType::Hex27}) {
    const ReferenceElement& element = reference_element(type);
    std::vector<double> weights(element.node_count);
    for (int trial = 0; trial < 200; ++trial) {
      Vec3 low, high;
      for (int k = 0; k < 3; ++k) {
        low[k] = random.uniform(0.0, 0.45);
        high[k] = random.uniform(0.55, 1.0);
        if (type == ElementType::Hex27) high[k] = std::max(high[k], low[k] + 0.47);  // a tenth of the cell
      }
      const CellFilling filling = box_filling(low, high);
      Vec3 mean, squares;
      for (const QuadraturePoint& q : element.quadrature) {
        const Vec3 x = filled_position(type, filling, q.position);
        mean += x * q.weight;
        squares += Vec3{x.x * x.x, x.y * x.y, x.z * x.z} * q.weight;
        for (int k = 0; k < 3; ++k) {  // Gauss's rule of that very box
          CHECK(x[k] > low[k]);
          CHECK(x[k] < high[k]);
        }
      }
      CHECK(norm(mean - filling.mean) < 1e-14);
      CHECK(norm(squares - filling.mean_square) < 1e-14);
      filled_rule(element.nodes, filling, weights);
      double sum = 0.0;
      mean = {};
      for (int a = 0; a < element.node_count; ++a) {
        CHECK(weights[a] > 0.0);
        sum += weights[a];
        mean += element.nodes[a] * weights[a];
      }
      CHECK(sum == doctest::Approx(1.0).epsilon(1e-13));
      CHECK(norm(mean - filling.mean) < 1e-13);
    }
    for (const Vec3& corner : {Vec3{0.0, 0.0, 0.0}, Vec3{1.0, 0.0, 1.0}}) {
      const CellFilling sliver{0.01, corner, {corner.x, corner.y, corner.z}};
      filled_rule(element.nodes, sliver, weights);
      for (const double w : weights) CHECK(w >= 0.99e-6);
      const Vec3 a = filled_position(type, sliver, {0.0, 0.0, 0.0}),
                 b = filled_position(type, sliver, {1.0, 1.0, 1.0});
      const double width = type == ElementType::Hex27 ? 0.5 : 0.1;
      CHECK(norm(b - a - Vec3{width, width, width}) < 1e-14);
    }
  }
}
