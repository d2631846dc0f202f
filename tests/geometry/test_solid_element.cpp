// Reference elements: partition of unity, nodal values, gradients, exactness of quadrature, closed
// boundaries.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include <stark/geometry/solid_element.h>
#include <stark/geometry/topology.h>
#include <support/random_points.h>

using namespace stark;
using namespace stark::test;

namespace {

constexpr ElementType kTypes[] = {ElementType::Tet4, ElementType::Tet10, ElementType::Hex8,
                                  ElementType::Hex27};

bool is_tet(ElementType type) { return type == ElementType::Tet4 || type == ElementType::Tet10; }

Vec3 inner_point(RandomPoints& random, ElementType type) {
  const Vec3 p{random.uniform(0, 1), random.uniform(0, 1), random.uniform(0, 1)};
  return is_tet(type) ? p * (1.0 / 3.0) : p;
}

double factorial(int n) { return n < 2 ? 1.0 : n * factorial(n - 1); }

/// Integral of x^i y^j z^k over the reference cell.
double monomial(ElementType type, int i, int j, int k) {
  if (is_tet(type)) return factorial(i) * factorial(j) * factorial(k) / factorial(i + j + k + 3);
  return 1.0 / ((i + 1) * (j + 1) * (k + 1));
}

double integrate(std::span<const QuadraturePoint> rule, int i, int j, int k) {
  double sum = 0.0;
  for (const QuadraturePoint& p : rule)
    sum += p.weight * std::pow(p.position.x, i) * std::pow(p.position.y, j) * std::pow(p.position.z, k);
  return sum;
}

}  // namespace

TEST_CASE("shape functions sum to one, are one at their node, and reproduce linear fields") {
  RandomPoints random(1);
  for (const ElementType type : kTypes) {
    const ReferenceElement& element = reference_element(type);
    const int n = element.node_count;
    std::vector<double> N(n);
    for (int a = 0; a < n; ++a) {
      shape_functions(type, element.nodes[a], N);
      for (int b = 0; b < n; ++b) CHECK(N[b] == doctest::Approx(a == b ? 1.0 : 0.0).scale(1.0));
    }
    for (int trial = 0; trial < 10; ++trial) {
      const Vec3 p = inner_point(random, type);
      shape_functions(type, p, N);
      double sum = 0.0;
      Vec3 position;
      for (int a = 0; a < n; ++a) sum += N[a], position += element.nodes[a] * N[a];
      CHECK(sum == doctest::Approx(1.0).epsilon(1e-13));
      CHECK(max_abs(position - p) < 1e-13);
    }
  }
}

TEST_CASE("gradients agree with differences of the shape functions") {
  RandomPoints random(2);
  const double h = 1e-5;  // quadratics: central differences are exact but for rounding
  for (const ElementType type : kTypes) {
    const int n = reference_element(type).node_count;
    std::vector<Vec3> gradients(n);
    std::vector<double> low(n), high(n);
    for (int trial = 0; trial < 5; ++trial) {
      const Vec3 p = inner_point(random, type);
      shape_gradients(type, p, gradients);
      for (int c = 0; c < 3; ++c) {
        Vec3 step;
        step[c] = h;
        shape_functions(type, p - step, low);
        shape_functions(type, p + step, high);
        for (int a = 0; a < n; ++a) CHECK(std::fabs(gradients[a][c] - (high[a] - low[a]) / (2 * h)) < 1e-9);
      }
    }
  }
}

TEST_CASE("quadrature is exact to the degree that the element needs") {
  for (const ElementType type : kTypes) {
    const ReferenceElement& element = reference_element(type);
    // Energy rules: total degree 1, 3 of tetrahedra; degree 3, 5 in each coordinate of hexahedra. Mass rules:
    // products of shape functions.
    const int degree = type == ElementType::Tet4    ? 1
                       : type == ElementType::Tet10 ? 3
                       : type == ElementType::Hex8  ? 3
                                                    : 5;
    const int mass = 5;
    for (int i = 0; i <= 5; ++i)
      for (int j = 0; j <= 5; ++j)
        for (int k = 0; k <= 5; ++k) {
          const int total = is_tet(type) ? i + j + k : std::max({i, j, k});
          const double exact = monomial(type, i, j, k);
          if (total <= degree)
            CHECK(integrate(element.quadrature, i, j, k) == doctest::Approx(exact).epsilon(1e-13));
          if (total <= mass)
            CHECK(integrate(element.mass_quadrature, i, j, k) == doctest::Approx(exact).epsilon(1e-13));
        }
  }
}

TEST_CASE("the triangles of all faces enclose the reference cell, outwards") {
  for (const ElementType type : kTypes) {
    const ReferenceElement& element = reference_element(type);
    std::vector<Index3> triangles;
    for (const ElementFace& face : element.faces)
      triangles.insert(triangles.end(), face.triangles.begin(), face.triangles.end());
    CHECK(is_closed(triangles));
    CHECK(is_orientation_consistent(triangles));
    double volume = 0.0;
    for (const Index3& t : triangles)
      volume += dot(element.nodes[t[0]], cross(element.nodes[t[1]], element.nodes[t[2]])) / 6.0;
    CHECK(volume == doctest::Approx(is_tet(type) ? 1.0 / 6.0 : 1.0).epsilon(1e-13));
    const size_t expected = type == ElementType::Tet4    ? 4
                            : type == ElementType::Tet10 ? 16
                            : type == ElementType::Hex8  ? 12
                                                         : 48;
    CHECK(triangles.size() == expected);
  }
}
