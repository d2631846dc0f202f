// Checks of meshes, poses and numbers at the border of the library. See validation.h.
#include <stark/sim/scene/validation.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>

#include <stark/base/error.h>
#include <stark/geometry/cut_rule.h>
#include <stark/geometry/edge_directions.h>
#include <stark/geometry/embedding.h>
#include <stark/geometry/polyline.h>
#include <stark/geometry/topology.h>

namespace stark {

namespace {

// Height of an element over its longest edge below which inverting its edge matrix loses more than half of
// the digits.
constexpr double kThinnestElement = 1e-6;
// Rigid surfaces only need a normal direction; below this ratio a triangle is a line within rounding.
constexpr double kThinnestRigidTriangle = 1e-12;
/// Smallest 1 + cos of the angle between consecutive edges: sharper bends have no tangent to speak of.
constexpr double kSharpestBend = 0.05;
/// Shortest edge over the longest one.
constexpr double kShortestEdge = 1e-6;
/// Sine of the smallest angle between the normal and the first tangent.
constexpr double kSmallestAngle = 1e-6;

std::string text(const Vec3& v) { return to_text(FieldValue(v)); }

[[noreturn]] void fail_mesh(std::string_view owner, const std::string& message) {
  throw InvalidMesh(std::string(owner) + ": " + message);
}

void check_vertices(std::string_view owner, std::string_view what, std::span<const Vec3> vertices) {
  for (size_t i = 0; i < vertices.size(); ++i)
    if (!is_finite(vertices[i]))
      fail_mesh(owner, std::string(what) + " " + std::to_string(i) + " is at " + text(vertices[i]) +
                           " m: positions must be finite; repair or remove this vertex");
}

/// One element: indices in range, no vertex twice.
void check_element(std::string_view owner, std::string_view kind, size_t number,
                   std::span<const int32_t> vertices, size_t vertex_count) {
  for (size_t i = 0; i < vertices.size(); ++i) {
    const int32_t v = vertices[i];
    if (v < 0 || static_cast<size_t>(v) >= vertex_count)
      fail_mesh(owner, std::string(kind) + " " + std::to_string(number) + " refers to vertex " +
                           std::to_string(v) + ": indices must be in [0, " + std::to_string(vertex_count) +
                           "); indices start at 0, check the numbering of the mesh");
    for (size_t j = 0; j < i; ++j)
      if (vertices[j] == v)
        fail_mesh(owner, std::string(kind) + " " + std::to_string(number) + " uses vertex " +
                             std::to_string(v) +
                             " twice: its vertices must be different; remove the element");
  }
}

/// All vertex numbers of the elements in a row.
std::span<const int32_t> flat(std::span<const Index3> triangles) {
  return {triangles.empty() ? nullptr : triangles[0].data(), 3 * triangles.size()};
}

int32_t find_first_unused(std::span<const int32_t> used_vertices, size_t vertex_count, size_t& out_count) {
  std::vector<char> used(vertex_count, 0);
  for (const int32_t v : used_vertices) used[v] = 1;
  out_count = static_cast<size_t>(std::count(used.begin(), used.end(), 0));
  return static_cast<int32_t>(std::find(used.begin(), used.end(), 0) - used.begin());
}

std::string count_text(size_t count, const char* singular, const char* plural) {
  return std::to_string(count) + " " + (count == 1 ? singular : plural);
}

void check_all_used(std::string_view owner, std::string_view kind, std::span<const int32_t> used_vertices,
                    size_t vertex_count) {
  size_t count = 0;
  const int32_t first = find_first_unused(used_vertices, vertex_count, count);
  if (count > 0)
    fail_mesh(owner, count_text(count, "vertex", "vertices") + " (first: " + std::to_string(first) +
                         ") in no " + std::string(kind) +
                         ": every vertex must have mass; remove them with stark.mesh.compact(mesh)");
}

double longest_edge(const Vec3& a, const Vec3& b, const Vec3& c) {
  return std::max({norm(b - a), norm(c - b), norm(a - c)});
}

/// Longest edge between corners; edges of quadratic elements count from corner to corner.
double longest_element_edge(const SolidMesh& mesh, int64_t element) {
  const auto nodes = mesh.element(element);
  const bool is_tet = mesh.type == ElementType::Tet4 || mesh.type == ElementType::Tet10;
  double longest = 0.0;
  for (int a = 0; a < (is_tet ? 4 : 8); ++a)
    for (int b = 0; b < a; ++b)
      longest = std::max(longest, norm(mesh.vertices[nodes[a]] - mesh.vertices[nodes[b]]));
  return longest;
}

void check_triangles(std::string_view owner, const TriangleMesh& mesh, double thinnest) {
  if (mesh.triangles.empty())
    fail_mesh(owner, "the mesh has 0 triangles: it must have at least one; check the file or the generator");
  check_vertices(owner, "vertex", mesh.vertices);
  for (size_t t = 0; t < mesh.triangles.size(); ++t)
    check_element(owner, "triangle", t, mesh.triangles[t], mesh.vertices.size());
  for (size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto [i, j, k] = mesh.triangles[t];
    const Vec3 &a = mesh.vertices[i], &b = mesh.vertices[j], &c = mesh.vertices[k];
    const double area = 0.5 * norm(cross(b - a, c - a)), longest = longest_edge(a, b, c);
    if (!(2.0 * area > thinnest * longest * longest))
      fail_mesh(owner, "triangle " + std::to_string(t) + " (vertices " + std::to_string(i) + ", " +
                           std::to_string(j) + ", " + std::to_string(k) + ") has an area of " +
                           rough_text(area, "m^2") +
                           ": triangles must not be degenerate; remove it or merge its vertices");
  }
}

void warn_about_edges(std::string_view owner, const TriangleMesh& mesh, std::vector<std::string>& warnings) {
  const EdgeTriangles adjacency = find_edge_triangles(mesh.triangles);
  size_t crowded = 0;
  Index2 first{};
  for (size_t e = 0; e < adjacency.edges.size(); ++e)
    if (adjacency.offsets[e + 1] - adjacency.offsets[e] > 2 && crowded++ == 0) first = adjacency.edges[e];
  if (crowded > 0)
    warnings.push_back(std::string(owner) + ": " + count_text(crowded, "edge", "edges") +
                       " shared by more than two triangles (first: " + std::to_string(first[0]) + "-" +
                       std::to_string(first[1]) +
                       "); each pair of triangles there bends as a hinge of its own");
}

}  // namespace

void check_number(std::string_view owner, std::string_view name, double value, std::string_view unit,
                  const FieldRule& rule, std::string_view remedy) {
  if (rule.holds(value)) return;
  throw InvalidArgument(std::string(owner) + ": " + std::string(name) + " = " + quantity_text(value, unit) +
                        ": " + rule.text() + "; " + std::string(remedy));
}

void check_finite(std::string_view owner, std::string_view name, const Vec3& value, std::string_view unit) {
  // Lengths of vectors are roots of sums of squares, which overflow beyond.
  constexpr double kLargest = 1e150;
  if (is_finite(value) && max_abs(value) < kLargest) return;
  throw InvalidArgument(std::string(owner) + ": " + std::string(name) + " = " + text(value) + " " +
                        std::string(unit) +
                        ": must be three finite numbers, none beyond 1e150; check where it is computed");
}

void check_rotation(std::string_view owner, const Mat3& rotation) {
  double deviation = 0.0;
  const Mat3 error = transpose(rotation) * rotation - Mat3::identity();
  for (double value : error.m)
    deviation = std::isfinite(value) ? std::max(deviation, std::fabs(value)) : INFINITY;
  const double orientation = determinant(rotation);
  if (deviation <= 1e-6 && orientation > 0.0) return;
  throw InvalidArgument(
      std::string(owner) + ": rotation has R^T R - 1 of size " + to_text(deviation) + " and determinant " +
      to_text(orientation) +
      ": must be orthonormal with determinant +1; build it with stark.rotation(axis=, angle=)");
}

void check_rigid_mesh(std::string_view owner, const TriangleMesh& mesh, std::vector<std::string>& warnings) {
  check_triangles(owner, mesh, kThinnestRigidTriangle);
  size_t unused = 0;
  const int32_t first = find_first_unused(flat(mesh.triangles), mesh.vertices.size(), unused);
  if (unused > 0)
    warnings.push_back(std::string(owner) + ": " + count_text(unused, "vertex", "vertices") +
                       " (first: " + std::to_string(first) +
                       ") in no triangle, ignored in contact; remove them with stark.mesh.compact(mesh)");
}

void check_cloth_mesh(std::string_view owner, const TriangleMesh& mesh, std::vector<std::string>& warnings) {
  check_triangles(owner, mesh, kThinnestElement);
  check_all_used(owner, "triangle", flat(mesh.triangles), mesh.vertices.size());
  warn_about_edges(owner, mesh, warnings);
  if (!is_orientation_consistent(mesh.triangles))
    warnings.push_back(
        std::string(owner) +
        ": neighbouring triangles are oriented differently; what follows their normals does, too: pressures "
        "on faces, natural curvature; stark.mesh.oriented turns them");
}

namespace {

void check_tet_volumes(std::string_view owner, const SolidMesh& mesh) {
  const std::vector<double> volumes = compute_element_volumes(mesh);
  size_t inverted = 0, first = 0;
  for (size_t e = 0; e < volumes.size(); ++e)
    if (volumes[e] < 0.0 && inverted++ == 0) first = e;
  for (size_t e = 0; e < volumes.size(); ++e) {
    const double longest = longest_element_edge(mesh, static_cast<int64_t>(e));
    // Six volumes over the cube of the longest edge bounds the smallest height over that edge from below.
    if (!(6.0 * std::fabs(volumes[e]) > kThinnestElement * longest * longest * longest))
      fail_mesh(owner, "tetrahedron " + std::to_string(e) + " has a volume of " +
                           rough_text(volumes[e], "m^3") + " with edges of " + rough_text(longest, "m") +
                           ": tetrahedra must not be degenerate; remove it or remesh");
  }
  if (inverted > 0)
    fail_mesh(owner, "tetrahedron " + std::to_string(first) + " has a volume of " +
                         rough_text(volumes[first], "m^3") + " (" + std::to_string(inverted) + " of " +
                         std::to_string(volumes.size()) +
                         " are inverted): volumes must be positive; reorder their vertices with "
                         "stark.mesh.oriented(mesh)");
}

void check_jacobians(std::string_view owner, const SolidMesh& mesh) {
  const std::string kind(reference_element(mesh.type).name);
  for (int64_t e = 0; e < mesh.element_count(); ++e) {
    const double smallest = smallest_jacobian(mesh, e), longest = longest_element_edge(mesh, e);
    if (!(smallest > kThinnestElement * longest * longest * longest))
      fail_mesh(owner, kind + " " + std::to_string(e) + " has a Jacobian of " + rough_text(smallest, "m^3") +
                           " at a quadrature point, with edges of " + rough_text(longest, "m") +
                           ": must be positive at all of them; its nodes must be in the order of VTK, nodes "
                           "between corners near the middle, and the element neither flat nor inverted");
  }
}

}  // namespace

namespace {

/// How far embedded vertices may be outside of their elements, in reference coordinates: rounding.
constexpr double kOutside = 1e-6;

void check_embedding(std::string_view owner, const SolidMesh& mesh) {
  const Embedding& embedding = mesh.embedding;
  const auto elements = static_cast<int32_t>(mesh.element_count());
  if (mesh.type != ElementType::Hex8 && mesh.type != ElementType::Hex27)
    fail_mesh(owner, "has an embedded surface in tetrahedra: must be in hexahedra; use stark.mesh.lattice");
  if (embedding.elements.size() >= mesh.vertices.size() ||
      embedding.fillings.size() != static_cast<size_t>(mesh.element_count()))
    fail_mesh(owner, "has " + count_text(embedding.elements.size(), "embedded vertex", "embedded vertices") +
                         " and " + count_text(embedding.fillings.size(), "filling", "fillings") + " for " +
                         std::to_string(mesh.vertices.size()) + " vertices and " +
                         count_text(static_cast<size_t>(mesh.element_count()), "element", "elements") +
                         ": must be fewer than vertices, and one filling for each element");
  const auto first = static_cast<int32_t>(mesh.first_embedded());
  for (size_t k = 0; k < mesh.elements.size(); ++k)
    if (mesh.elements[k] >= first)
      fail_mesh(owner, "element " + std::to_string(k / mesh.node_count()) + " refers to vertex " +
                           std::to_string(mesh.elements[k]) + ", which is embedded: must refer to nodes");
  for (size_t e = 0; e < embedding.fillings.size(); ++e)
    if (const CellFilling& f = embedding.fillings[e]; !is_of_a_cell(f))
      fail_mesh(owner, "element " + std::to_string(e) + " is filled by a part of " + to_text(f.part()) +
                           ", with a mean position of " + text(f.mean()) +
                           ": must be in (0, 1], with moments of a part of the cell; use stark.mesh.lattice");
  TriangleMesh surface{mesh.vertices, embedding.triangles};
  check_triangles(owner, surface, kThinnestRigidTriangle);
  std::vector<char> used(embedding.elements.size(), 0);
  for (const Index3& t : embedding.triangles)
    for (const int32_t v : t) {
      if (v < first)
        fail_mesh(owner, "a triangle of its surface refers to vertex " + std::to_string(v) +
                             ", a node: must refer to embedded vertices");
      used[v - first] = 1;
    }
  for (size_t k = 0; k < used.size(); ++k) {
    const int32_t e = embedding.elements[k];
    const std::string vertex = "embedded vertex " + std::to_string(first + static_cast<int32_t>(k));
    if (!used[k]) fail_mesh(owner, vertex + " is in no triangle of the surface: must be in one");
    if (e < 0 || e >= elements)
      fail_mesh(owner, vertex + " is in element " + std::to_string(e) + ": must be in [0, " +
                           std::to_string(elements) + ")");
    const Vec3 xi = find_reference_position(mesh, e, mesh.vertices[first + k]);
    if (!is_finite(xi) || max_abs(xi - Vec3{0.5, 0.5, 0.5}) > 0.5 + kOutside)
      fail_mesh(owner, vertex + " is outside of its element " + std::to_string(e) + ": must be inside");
  }
}

}  // namespace

void check_solid_mesh(std::string_view owner, const SolidMesh& mesh) {
  const std::string_view kind = reference_element(mesh.type).name;
  if (mesh.elements.empty())
    fail_mesh(owner, std::string("the mesh has 0 ") +
                         (mesh.type == ElementType::Tet4 ? "tetrahedra" : "elements") +
                         ": it must have at least one; for surfaces use stark.mesh.tetrahedralise(mesh) or "
                         "add_cloth");
  check_vertices(owner, "vertex", mesh.vertices);
  for (int64_t e = 0; e < mesh.element_count(); ++e)
    check_element(owner, kind, static_cast<size_t>(e), mesh.element(e), mesh.vertices.size());
  if (mesh.type == ElementType::Tet4)
    check_tet_volumes(owner, mesh);
  else
    check_jacobians(owner, mesh);
  if (mesh.is_embedded() || !mesh.embedding.elements.empty()) check_embedding(owner, mesh);
  check_all_used(owner, kind, mesh.elements, mesh.first_embedded());
}

void check_layer_triangles(std::string_view owner, const TriangleMesh& mesh,
                           std::vector<std::string>& warnings) {
  check_triangles(owner, mesh, kThinnestElement);
  std::map<Index3, size_t> known;
  for (size_t t = 0; t < mesh.triangles.size(); ++t) {
    Index3 sorted = mesh.triangles[t];
    std::sort(sorted.begin(), sorted.end());
    const auto [first, is_new] = known.try_emplace(sorted, t);
    if (!is_new)
      fail_mesh(owner, "triangles " + std::to_string(first->second) + " and " + std::to_string(t) +
                           " have the same vertices: must be different; for two layers add two skins");
  }
  warn_about_edges(owner, mesh, warnings);
}

void check_edge_lengths(const std::string& owner, const std::string& what, std::span<const Vec3> points) {
  const std::vector<double> lengths = polyline_lengths(points);
  const double longest = *std::max_element(lengths.begin(), lengths.end());
  for (size_t i = 0; i < lengths.size(); ++i)
    if (!(lengths[i] > kShortestEdge * longest))
      fail_mesh(owner, what + ": edge " + std::to_string(i) + " has a length of " +
                           quantity_text(lengths[i], "m") + ": must not be degenerate; remove a point");
}

void warn_about_free_directions(std::string_view owner, const TriangleMesh& mesh,
                                const ShellMaterial& material, std::vector<std::string>& warnings) {
  if (material.strain_limit_law != StrainLimitLaw::Edges || !std::isfinite(material.strain_limit)) return;
  constexpr double kFree = 75.0 * std::numbers::pi / 180.0;  // stretch by 1/cos(kFree/2) - 1 = 26 %
  const std::vector<double> gaps = compute_direction_gaps(mesh.vertices, mesh.triangles);
  const std::vector<double> areas = compute_triangle_areas(mesh.vertices, mesh.triangles);
  double total = 0.0, free = 0.0, widest = 0.0;
  for (size_t t = 0; t < gaps.size(); ++t) {
    total += areas[t];
    if (gaps[t] <= kFree) continue;
    free += areas[t];
    widest += areas[t] * gaps[t];
  }
  if (!(free > 0.1 * total)) return;
  const auto percent = [](double share) { return std::to_string(std::lround(100.0 * share)) + " %"; };
  warnings.push_back(
      std::string(owner) +
      ": strain_limit_law = edges with strain_limit = " + to_text(material.strain_limit) +
      " on a mesh whose edges leave a direction free on " + percent(free / total) +
      " of its area, where the sheet can stretch by " + percent(1.0 / std::cos(0.5 * widest / free) - 1.0) +
      " before an edge does; use strain_limit_law = green_strain, or a mesh with diagonals in both "
      "directions");
}

void warn_about_weak_plates(std::string_view owner, const TriangleMesh& mesh, const ShellMaterial& material,
                            std::vector<std::string>& warnings) {
  if (!(material.flexural_rigidity > 0.0)) return;
  std::vector<int> triangles(mesh.vertices.size(), 0);
  for (const Index3& triangle : mesh.triangles)
    for (const int32_t vertex : triangle) ++triangles[static_cast<size_t>(vertex)];
  for (const Index2& edge : find_boundary_edges(mesh.triangles))
    for (const int32_t vertex : edge) triangles[static_cast<size_t>(vertex)] = 0;
  const auto inner = std::ranges::count_if(triangles, [](int count) { return count > 0; });
  const auto fours = std::ranges::count(triangles, 4);
  if (!(4 * fours > inner) || fours < 4) return;
  warnings.push_back(std::string(owner) + ": " + std::to_string(fours) + " of " + std::to_string(inner) +
                     " inner vertices have four triangles, as on a grid with diagonals in turn; with a "
                     "flexural_rigidity such a sheet bends up to 1.8 times as far as a plate; take parallel "
                     "diagonals (stark.mesh.grid) or triangles that are nearly equilateral");
}

void check_polyline(const std::string& owner, const std::string& what, std::span<const Vec3> points) {
  if (points.size() < 2)
    fail_mesh(owner, what + " has " + std::to_string(points.size()) +
                         " points: must have at least 2, one for each node; use stark.mesh.polyline");
  for (size_t i = 0; i < points.size(); ++i)
    if (!is_finite(points[i]))
      fail_mesh(owner, what + ": point " + std::to_string(i) + " = " + text(points[i]) +
                           " m: must be finite; check where it is computed");
  check_edge_lengths(owner, what, points);
  const std::vector<double> lengths = polyline_lengths(points);
  for (size_t i = 0; i + 1 < lengths.size(); ++i) {
    const double cosine =
        dot(points[i + 1] - points[i], points[i + 2] - points[i + 1]) / (lengths[i] * lengths[i + 1]);
    if (!(1.0 + cosine > kSharpestBend))
      fail_mesh(owner, what + " turns by " + to_text(std::acos(std::max(-1.0, cosine))) + " rad at point " +
                           std::to_string(i + 1) +
                           ": must turn by less than 2.8 rad; round the bend with more points");
  }
}

void check_normal(const std::string& owner, const Vec3& normal, std::span<const Vec3> points) {
  check_finite(owner, "normal", normal, "1");
  const Vec3 tangent = normalized(points[1] - points[0]);
  if (!(norm(cross(normal, tangent)) > kSmallestAngle * norm(normal)))
    throw InvalidArgument(owner + ": normal = " + text(normal) +
                          " is zero or along the first edge: must have a part across it; give the direction "
                          "of the width of the section");
}

void check_initial_positions(std::string_view owner, std::span<const Vec3> positions, size_t vertex_count) {
  if (positions.empty()) return;
  if (positions.size() != vertex_count)
    fail_mesh(owner, "initial_positions has " + std::to_string(positions.size()) +
                         " rows: must have one for each of the " + std::to_string(vertex_count) +
                         " vertices of the rest mesh; leave it out to start at rest");
  check_vertices(owner, "initial position", positions);
}

void check_closed(std::string_view owner, const TriangleMesh& mesh, std::string_view purpose) {
  if (!is_closed(mesh.triangles)) {
    const std::vector<Index2> open = find_boundary_edges(mesh.triangles);
    const std::string where = open.empty()
                                  ? "an edge belongs to more than two triangles"
                                  : count_text(open.size(), "edge", "edges") +
                                        " of one triangle only (first: " + std::to_string(open[0][0]) + "-" +
                                        std::to_string(open[0][1]) + ")";
    fail_mesh(owner, "the mesh is not watertight, " + where + ": it must enclose a volume for " +
                         std::string(purpose) +
                         "; close the mesh, as stark.mesh.cleaned(mesh) does, or give inertia= explicitly");
  }
  if (!is_orientation_consistent(mesh.triangles))
    fail_mesh(
        owner,
        "neighbouring triangles are oriented differently: all must be counter-clockwise seen from outside "
        "for " +
            std::string(purpose) + "; use stark.mesh.oriented(mesh)");
}

SmallestHeight find_smallest_height(std::span<const Vec3> vertices, std::span<const Index3> triangles) {
  SmallestHeight smallest{std::numeric_limits<double>::infinity(), -1};
  for (size_t t = 0; t < triangles.size(); ++t) {
    const auto [i, j, k] = triangles[t];
    const Vec3 &a = vertices[i], &b = vertices[j], &c = vertices[k];
    const double height = norm(cross(b - a, c - a)) / longest_edge(a, b, c);
    if (height < smallest.height) smallest = {height, static_cast<int32_t>(t)};
  }
  return smallest;
}

}  // namespace stark
