// Embedded vertices and rules for cells that are filled in part.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include <stark/geometry/embedding.h>
#include <stark/geometry/shapes.h>
#include <support/box_filling.h>
#include <support/random_points.h>

using namespace stark;
using namespace stark::test;

namespace {}  // namespace

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

TEST_CASE("full cells have masses of whole nodes") {
  for (const ElementType type : {ElementType::Hex8, ElementType::Hex27}) {
    const ReferenceElement& element = reference_element(type);
    SolidMesh mesh = make_hex_box({1, 1, 1}, {1, 1, 1});
    if (type == ElementType::Hex27) mesh = to_quadratic(mesh);
    std::vector<double> whole(element.node_count), weights(element.node_count);
    lump_volume(mesh, 0, whole);
    filled_rule(element.nodes, {}, weights);
    for (int a = 0; a < element.node_count; ++a)
      CHECK(weights[a] == doctest::Approx(whole[a]).epsilon(1e-12));
  }
}

TEST_CASE("masses of filled cells have volume and centre of the filling") {
  RandomPoints random(4);
  for (const ElementType type : {ElementType::Hex8, ElementType::Hex27}) {
    const ReferenceElement& element = reference_element(type);
    std::vector<double> weights(element.node_count);
    for (int trial = 0; trial < 200; ++trial) {
      Vec3 low, high;
      for (int k = 0; k < 3; ++k) {
        low[k] = random.uniform(0.0, 0.45);
        high[k] = random.uniform(0.55, 1.0);
      }
      const CellFilling filling = box_filling(low, high);
      filled_rule(element.nodes, filling, weights);
      double sum = 0.0;
      Vec3 mean;
      for (int a = 0; a < element.node_count; ++a) {
        CHECK(weights[a] > 0.0);
        sum += weights[a];
        mean += element.nodes[a] * weights[a];
      }
      CHECK(sum == doctest::Approx(1.0).epsilon(1e-13));
      CHECK(norm(mean - filling.mean()) < 1e-13);
    }
    for (const Vec3& corner : {Vec3{0.0, 0.0, 0.0}, Vec3{1.0, 0.0, 1.0}}) {
      filled_rule(element.nodes, box_filling(corner, corner, 0.01), weights);
      for (const double w : weights) CHECK(w >= 0.99e-6);
    }
  }
}
