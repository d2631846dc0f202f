// Shape functions, quadrature rules and connectivity of the element types. See solid_element.h.
#include <stark/geometry/solid_element.h>

#include <array>
#include <cmath>

#include <stark/base/error.h>

namespace stark {

namespace {

// Corners of the edges with a node in their middle, in VTK's order (node 4 of tetrahedra, 8 of hexahedra on).
constexpr Index2 kTetEdges[] = {{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}};
constexpr Index2 kHexEdges[] = {{0, 1}, {1, 2}, {2, 3}, {3, 0}, {4, 5}, {5, 6},
                                {6, 7}, {7, 4}, {0, 4}, {1, 5}, {2, 6}, {3, 7}};
constexpr Index3 kTetFaces[] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};  // outwards
// Outwards; in the order of the face nodes 20 to 25 of VTK's triquadratic hexahedron: -x, +x, -y, +y, -z, +z.
constexpr Index4 kHexFaces[] = {{0, 4, 7, 3}, {1, 2, 6, 5}, {0, 1, 5, 4},
                                {3, 7, 6, 2}, {0, 3, 2, 1}, {4, 5, 6, 7}};
constexpr int kHexCorners[8][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0},
                                   {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};

bool is_quadratic(ElementType type) { return type == ElementType::Tet10 || type == ElementType::Hex27; }
bool is_tet(ElementType type) { return type == ElementType::Tet4 || type == ElementType::Tet10; }

struct GaussPoint {
  double x, weight;
};

/// Gauss-Legendre on [0, 1], exact to degree 2 n - 1.
std::vector<GaussPoint> gauss(int n) {
  const auto pair = [](double x, double w) {
    return std::array<GaussPoint, 2>{GaussPoint{0.5 - 0.5 * x, 0.5 * w}, GaussPoint{0.5 + 0.5 * x, 0.5 * w}};
  };
  if (n == 2) {
    const auto p = pair(1.0 / std::sqrt(3.0), 1.0);
    return {p[0], p[1]};
  }
  if (n == 3) {
    const auto p = pair(std::sqrt(0.6), 5.0 / 9.0);
    return {p[0], {0.5, 4.0 / 9.0}, p[1]};
  }
  STARK_CHECK(n == 4);
  const double root = 2.0 / 7.0 * std::sqrt(1.2);
  const auto inner = pair(std::sqrt(3.0 / 7.0 - root), (18.0 + std::sqrt(30.0)) / 36.0);
  const auto outer = pair(std::sqrt(3.0 / 7.0 + root), (18.0 - std::sqrt(30.0)) / 36.0);
  return {outer[0], inner[0], inner[1], outer[1]};
}

std::vector<QuadraturePoint> hex_rule(int n) {
  std::vector<QuadraturePoint> rule;
  for (const GaussPoint& z : gauss(n))
    for (const GaussPoint& y : gauss(n))
      for (const GaussPoint& x : gauss(n)) rule.push_back({{x.x, y.x, z.x}, x.weight * y.weight * z.weight});
  return rule;
}

/// One point, exact to degree 1, or eight, exact to degree 3 with positive weights [Witherden, Vincent 2015].
/// Degree 3 is what forces of a constant stress need on tetrahedra with curved edges (patch test).
std::vector<QuadraturePoint> tet_rule(int points) {
  if (points == 1) return {{{0.25, 0.25, 0.25}, 1.0 / 6.0}};
  std::vector<QuadraturePoint> rule;
  for (const auto& [a, weight] : {GaussPoint{0.3281633025163817, 0.1362178425370874 / 6.0},
                                  GaussPoint{0.1080472498984286, 0.1137821574629126 / 6.0}}) {
    const double b = 1.0 - 3.0 * a;
    for (const Vec3& p : {Vec3{a, a, a}, Vec3{b, a, a}, Vec3{a, b, a}, Vec3{a, a, b}})
      rule.push_back({p, weight});
  }
  return rule;
}

/// Cube collapsed to a tetrahedron, exact to degree 5.
std::vector<QuadraturePoint> collapsed_rule() {
  std::vector<QuadraturePoint> rule;
  for (const QuadraturePoint& p : hex_rule(4)) {
    const auto& [u, v, w] = p.position;
    rule.push_back({{u, v * (1 - u), w * (1 - u) * (1 - v)}, p.weight * (1 - u) * (1 - u) * (1 - v)});
  }
  return rule;
}

/// Value and derivative of the Lagrange polynomial of the node at `at` (0, 1/2, 1) on [0, 1].
std::array<double, 2> lagrange(bool quadratic, double at, double x) {
  if (!quadratic) return at == 0.0 ? std::array{1.0 - x, -1.0} : std::array{x, 1.0};
  if (at == 0.0) return {(1.0 - 2.0 * x) * (1.0 - x), 4.0 * x - 3.0};
  if (at == 1.0) return {x * (2.0 * x - 1.0), 4.0 * x - 1.0};
  return {4.0 * x * (1.0 - x), 4.0 - 8.0 * x};
}

/// Calls visit(node, value, gradient) for every shape function at p.
template <typename Visit>
void visit_shapes(ElementType type, const Vec3& p, Visit&& visit) {
  if (!is_tet(type)) {
    const auto& nodes = reference_element(type).nodes;
    for (size_t a = 0; a < nodes.size(); ++a) {
      std::array<double, 2> l[3];
      for (int c = 0; c < 3; ++c) l[c] = lagrange(is_quadratic(type), nodes[a][c], p[c]);
      visit(a, l[0][0] * l[1][0] * l[2][0],
            Vec3{l[0][1] * l[1][0] * l[2][0], l[0][0] * l[1][1] * l[2][0], l[0][0] * l[1][0] * l[2][1]});
    }
    return;
  }
  const double L[4] = {1.0 - p.x - p.y - p.z, p.x, p.y, p.z};
  const Vec3 dL[4] = {{-1, -1, -1}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  for (size_t a = 0; a < 4; ++a) {
    if (is_quadratic(type))
      visit(a, L[a] * (2.0 * L[a] - 1.0), dL[a] * (4.0 * L[a] - 1.0));
    else
      visit(a, L[a], dL[a]);
  }
  if (is_quadratic(type))
    for (size_t e = 0; e < 6; ++e) {
      const auto [i, j] = kTetEdges[e];
      visit(4 + e, 4.0 * L[i] * L[j], (dL[i] * L[j] + dL[j] * L[i]) * 4.0);
    }
}

void set_parents(ReferenceElement& element) {
  const bool tet = is_tet(element.type);
  for (int32_t corner = 0; corner < (tet ? 4 : 8); ++corner) element.parents.push_back({corner});
  if (is_quadratic(element.type)) {
    for (const Index2& e : tet ? std::span<const Index2>(kTetEdges) : std::span<const Index2>(kHexEdges))
      element.parents.push_back({e[0], e[1]});
    if (!tet) {
      for (const Index4& f : kHexFaces) element.parents.push_back({f.begin(), f.end()});
      element.parents.push_back({0, 1, 2, 3, 4, 5, 6, 7});
    }
  }
  element.node_count = static_cast<int>(element.parents.size());
}

void set_nodes(ReferenceElement& element) {
  const auto corner = [&](int32_t c) {
    if (is_tet(element.type)) return Vec3{c == 1 ? 1.0 : 0.0, c == 2 ? 1.0 : 0.0, c == 3 ? 1.0 : 0.0};
    return Vec3{double(kHexCorners[c][0]), double(kHexCorners[c][1]), double(kHexCorners[c][2])};
  };
  for (const auto& parents : element.parents) {
    Vec3 sum;
    for (const int32_t c : parents) sum += corner(c);
    element.nodes.push_back(sum * (1.0 / double(parents.size())));
  }
}

/// Node in the middle of two corners.
int32_t middle(const ReferenceElement& element, int32_t a, int32_t b) {
  for (size_t k = 0; k < element.parents.size(); ++k) {
    const auto& p = element.parents[k];
    if (p.size() == 2 && ((p[0] == a && p[1] == b) || (p[0] == b && p[1] == a)))
      return static_cast<int32_t>(k);
  }
  throw InternalError("element without a node between two corners");
}

/// Triangles of a face: the polygon of its corners and edge nodes cut into corner triangles and a middle.
void set_faces(ReferenceElement& element) {
  const auto add = [&](std::span<const int32_t> c, int32_t centre) {
    ElementFace face{{c.begin(), c.end()}, {}};
    if (!is_quadratic(element.type)) {
      face.triangles.push_back({c[0], c[1], c[2]});
      if (c.size() == 4) face.triangles.push_back({c[0], c[2], c[3]});
    } else if (c.size() == 3) {
      const int32_t a = middle(element, c[0], c[1]), b = middle(element, c[1], c[2]),
                    d = middle(element, c[2], c[0]);
      face.triangles = {{c[0], a, d}, {c[1], b, a}, {c[2], d, b}, {a, b, d}};
    } else {
      for (size_t k = 0; k < 4; ++k) {
        const int32_t m = middle(element, c[k], c[(k + 1) % 4]);
        face.triangles.push_back({c[k], m, centre});
        face.triangles.push_back({m, c[(k + 1) % 4], centre});
      }
    }
    element.faces.push_back(std::move(face));
  };
  if (is_tet(element.type))
    for (const Index3& f : kTetFaces) add(f, -1);
  else
    for (int32_t k = 0; k < 6; ++k) add(kHexFaces[k], 20 + k);
}

void set_edges(ReferenceElement& element) {
  const bool tet = is_tet(element.type);
  for (const Index2& e : tet ? std::span<const Index2>(kTetEdges) : std::span<const Index2>(kHexEdges)) {
    if (!is_quadratic(element.type)) {
      element.edges.push_back(e);
      continue;
    }
    const int32_t m = middle(element, e[0], e[1]);
    element.edges.push_back({e[0], m});
    element.edges.push_back({m, e[1]});
  }
}

ReferenceElement make(ElementType type, std::string_view name, std::vector<QuadraturePoint> quadrature) {
  ReferenceElement element{.type = type, .name = name};
  set_parents(element);
  set_nodes(element);
  element.quadrature = std::move(quadrature);
  element.mass_quadrature = is_tet(type) ? collapsed_rule() : hex_rule(3);
  set_faces(element);
  set_edges(element);
  return element;
}

}  // namespace

const ReferenceElement& reference_element(ElementType type) {
  static const ReferenceElement elements[] = {
      make(ElementType::Tet4, "tetrahedron", tet_rule(1)),
      make(ElementType::Tet10, "10-node tetrahedron", tet_rule(8)),
      make(ElementType::Hex8, "hexahedron", hex_rule(2)),
      make(ElementType::Hex27, "27-node hexahedron", hex_rule(3)),
  };
  return elements[static_cast<int>(type)];
}

int mean_dilatation_modes(ElementType type) { return type == ElementType::Hex27 ? 4 : 1; }

void shape_functions(ElementType type, const Vec3& position, std::span<double> out) {
  visit_shapes(type, position, [&](size_t a, double value, const Vec3&) { out[a] = value; });
}

void shape_gradients(ElementType type, const Vec3& position, std::span<Vec3> out) {
  visit_shapes(type, position, [&](size_t a, double, const Vec3& gradient) { out[a] = gradient; });
}

}  // namespace stark
