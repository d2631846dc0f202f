// See solid_mesh.h.
#include <stark/geometry/solid_mesh.h>

#include <algorithm>
#include <limits>
#include <map>
#include <string>
#include <tuple>

#include <stark/base/bucket_sort.h>
#include <stark/base/error.h>
#include <stark/geometry/cut_rule.h>
#include <stark/geometry/embedding.h>
#include <stark/geometry/topology.h>

namespace stark {

namespace {

/// Jacobian of the map from the reference cell, column k its derivative by reference coordinate k.
Mat3 jacobian(const SolidMesh& mesh, int64_t element, std::span<const Vec3> gradients) {
  Mat3 J;
  const auto nodes = mesh.element(element);
  for (size_t a = 0; a < nodes.size(); ++a)
    for (int i = 0; i < 3; ++i)
      for (int k = 0; k < 3; ++k) J(i, k) += mesh.vertices[nodes[a]][i] * gradients[a][k];
  return J;
}

double jacobian_determinant(const SolidMesh& mesh, int64_t element, const Vec3& position) {
  std::array<Vec3, 27> gradients;
  shape_gradients(mesh.type, position, gradients);
  return determinant(jacobian(mesh, element, gradients));
}

bool is_cut(const SolidMesh& mesh, int64_t element) {
  return mesh.is_embedded() && !mesh.embedding.fillings[element].is_full();
}

/// Filled volume of a hexahedron.
double filled_volume(const SolidMesh& mesh, int64_t element) {
  double volume = 0.0;
  for (const QuadraturePoint& p : reference_element(mesh.type).quadrature)
    volume += p.weight * jacobian_determinant(mesh, element, p.position);
  return volume * mesh.embedding.fillings[element].part();
}

void check_embedded(const SolidMesh& mesh) {
  const std::vector<int32_t>& elements = mesh.embedding.elements;
  const int64_t count = mesh.element_count();
  if (elements.size() > mesh.vertices.size())
    throw InvalidMesh(std::to_string(elements.size()) + " of " + std::to_string(mesh.vertices.size()) +
                      " vertices are embedded: must be some of them");
  for (size_t k = 0; k < elements.size(); ++k)
    if (elements[k] < 0 || elements[k] >= count)
      throw InvalidMesh("embedded vertex " + std::to_string(mesh.first_embedded() + k) + " is in element " +
                        std::to_string(elements[k]) + ": must be in [0, " + std::to_string(count) + ")");
  const size_t fillings = mesh.embedding.fillings.size();
  if (mesh.is_embedded() && fillings != static_cast<size_t>(count))
    throw InvalidMesh(std::to_string(fillings) + " fillings of " + std::to_string(count) +
                      " elements: must be one for each");
}

}  // namespace

SolidMesh::SolidMesh(const TetMesh& mesh) : vertices(mesh.vertices) {
  for (const Index4& t : mesh.tets) elements.insert(elements.end(), t.begin(), t.end());
}

SolidMesh::SolidMesh(std::vector<Vec3> v, ElementType t, std::vector<int32_t> e)
    : vertices(std::move(v)), type(t), elements(std::move(e)) {}

void check_indices(const SolidMesh& mesh) {
  for (size_t k = 0; k < mesh.elements.size(); ++k)
    if (mesh.elements[k] < 0 || static_cast<size_t>(mesh.elements[k]) >= mesh.vertices.size())
      throw InvalidMesh("element " + std::to_string(k / mesh.node_count()) + " refers to vertex " +
                        std::to_string(mesh.elements[k]) + ": indices must be in [0, " +
                        std::to_string(mesh.vertices.size()) + ")");
  check_embedded(mesh);
}

double rest_gradients(const SolidMesh& mesh, int64_t element, const Vec3& position, std::span<Vec3> out) {
  shape_gradients(mesh.type, position, out);
  const Mat3 J = jacobian(mesh, element, out);
  const double det = determinant(J);
  // Rows of J^-1 are cross products of its columns; the gradient is J^-T dN.
  const Vec3 r0 = cross(J.column(1), J.column(2)), r1 = cross(J.column(2), J.column(0)),
             r2 = cross(J.column(0), J.column(1));
  for (int a = 0; a < mesh.node_count(); ++a)
    out[a] = (r0 * out[a].x + r1 * out[a].y + r2 * out[a].z) * (1.0 / det);
  return det;
}

Vec3 rest_position(const SolidMesh& mesh, int64_t element, const Vec3& position) {
  std::vector<double> values(mesh.node_count());
  shape_functions(mesh.type, position, values);
  Vec3 sum;
  for (int a = 0; a < mesh.node_count(); ++a) sum += mesh.vertices[mesh.element(element)[a]] * values[a];
  return sum;
}

double smallest_jacobian(const SolidMesh& mesh, int64_t element) {
  double smallest = std::numeric_limits<double>::infinity();
  for (const QuadraturePoint& p : reference_element(mesh.type).quadrature)
    smallest = std::min(smallest, jacobian_determinant(mesh, element, p.position));
  return smallest;
}

std::vector<QuadraturePoint> quadrature_rule(const SolidMesh& mesh, int64_t element) {
  if (is_cut(mesh, element)) {
    std::vector<QuadraturePoint> rule = cut_rule(mesh.type, mesh.embedding.fillings[element]);
    const double volume = filled_volume(mesh, element);
    for (QuadraturePoint& q : rule) q.weight *= volume;
    return rule;
  }
  std::vector<QuadraturePoint> rule = reference_element(mesh.type).quadrature;
  for (QuadraturePoint& q : rule) q.weight *= jacobian_determinant(mesh, element, q.position);
  return rule;
}

std::vector<double> compute_element_volumes(const SolidMesh& mesh) {
  std::vector<double> volumes(mesh.element_count(), 0.0);
  if (mesh.is_embedded()) {
    for (int64_t e = 0; e < mesh.element_count(); ++e) volumes[e] = filled_volume(mesh, e);
    return volumes;
  }
  for (int64_t e = 0; e < mesh.element_count(); ++e)
    for (const QuadraturePoint& p : reference_element(mesh.type).quadrature)
      volumes[e] += p.weight * jacobian_determinant(mesh, e, p.position);
  return volumes;
}

void lump_volume(const SolidMesh& mesh, int64_t element, std::span<double> out) {
  const int nodes = mesh.node_count();
  if (mesh.type == ElementType::Tet4) {
    std::fill(out.begin(), out.end(), jacobian_determinant(mesh, element, {}) / 24.0);
    return;
  }
  if (is_cut(mesh, element)) {
    filled_rule(reference_element(mesh.type).nodes, mesh.embedding.fillings[element], out);
    const double volume = filled_volume(mesh, element);
    for (int a = 0; a < nodes; ++a) out[a] *= volume;
    return;
  }
  std::array<double, 27> N;
  std::fill(out.begin(), out.end(), 0.0);
  double volume = 0.0, sum = 0.0;
  for (const QuadraturePoint& p : reference_element(mesh.type).mass_quadrature) {
    shape_functions(mesh.type, p.position, N);
    const double weight = p.weight * jacobian_determinant(mesh, element, p.position);
    volume += weight;
    for (int a = 0; a < nodes; ++a) out[a] += weight * N[a] * N[a];
  }
  for (int a = 0; a < nodes; ++a) sum += out[a];
  for (int a = 0; a < nodes; ++a) out[a] *= volume / sum;
}

std::vector<Index3> find_boundary_triangles(const SolidMesh& mesh) {
  if (mesh.is_embedded()) return mesh.embedding.triangles;
  const auto& faces = reference_element(mesh.type).faces;
  struct Face {
    std::array<int32_t, 4> sorted;
    int64_t number;  // face_count * element + face
  };
  const int64_t count = static_cast<int64_t>(faces.size());
  std::vector<Face> all;
  all.reserve(count * mesh.element_count());
  for (int64_t e = 0; e < mesh.element_count(); ++e)
    for (int64_t f = 0; f < count; ++f) {
      Face face{{-1, -1, -1, -1}, count * e + f};
      for (size_t c = 0; c < faces[f].corners.size(); ++c)
        face.sorted[c] = mesh.element(e)[faces[f].corners[c]];
      std::ranges::sort(face.sorted);
      all.push_back(face);
    }
  // By the second corner, which triangles have, too.
  bucket_sort(
      all, [](const Face& f) { return f.sorted[1]; },
      [](const Face& a, const Face& b) {
        return std::tie(a.sorted[0], a.sorted[2], a.sorted[3], a.number) <
               std::tie(b.sorted[0], b.sorted[2], b.sorted[3], b.number);
      });
  std::vector<int64_t> boundary;
  for (size_t begin = 0, end = 0; begin < all.size(); begin = end) {
    while (end < all.size() && all[end].sorted == all[begin].sorted) ++end;
    if (end == begin + 1) boundary.push_back(all[begin].number);
  }
  std::ranges::sort(boundary);
  std::vector<Index3> triangles;
  for (const int64_t number : boundary)
    for (const Index3& t : faces[number % count].triangles) {
      const auto nodes = mesh.element(number / count);
      triangles.push_back({nodes[t[0]], nodes[t[1]], nodes[t[2]]});
    }
  return triangles;
}

std::vector<Index2> find_edges(const SolidMesh& mesh) {
  std::vector<Index2> edges;
  for (int64_t e = 0; e < mesh.element_count(); ++e)
    for (const Index2& edge : reference_element(mesh.type).edges) {
      const int32_t a = mesh.element(e)[edge[0]], b = mesh.element(e)[edge[1]];
      edges.push_back({std::min(a, b), std::max(a, b)});
    }
  sort_unique(edges);
  return edges;
}

SolidMesh make_hex_box(const Vec3& size, const Index3& cells) {
  SolidMesh mesh;
  mesh.type = ElementType::Hex8;
  const auto node = [&](int32_t i, int32_t j, int32_t k) {
    return (k * (cells[1] + 1) + j) * (cells[0] + 1) + i;
  };
  for (int32_t k = 0; k <= cells[2]; ++k)
    for (int32_t j = 0; j <= cells[1]; ++j)
      for (int32_t i = 0; i <= cells[0]; ++i)
        mesh.vertices.push_back({size.x * (double(i) / cells[0] - 0.5), size.y * (double(j) / cells[1] - 0.5),
                                 size.z * (double(k) / cells[2] - 0.5)});
  for (int32_t k = 0; k < cells[2]; ++k)
    for (int32_t j = 0; j < cells[1]; ++j)
      for (int32_t i = 0; i < cells[0]; ++i)
        for (const int32_t z : {k, k + 1})
          for (const auto& [x, y] : {Index2{i, j}, Index2{i + 1, j}, Index2{i + 1, j + 1}, Index2{i, j + 1}})
            mesh.elements.push_back(node(x, y, z));
  return mesh;
}

SolidMesh to_quadratic(const SolidMesh& mesh) {
  if (mesh.type == ElementType::Tet10 || mesh.type == ElementType::Hex27) return mesh;
  SolidMesh result(mesh.vertices, mesh.type == ElementType::Tet4 ? ElementType::Tet10 : ElementType::Hex27,
                   {});
  std::map<std::vector<int32_t>, int32_t> middles;  // by sorted parents
  for (int64_t e = 0; e < mesh.element_count(); ++e)
    for (const auto& parents : reference_element(result.type).parents) {
      std::vector<int32_t> corners;
      for (const int32_t p : parents) corners.push_back(mesh.element(e)[p]);
      if (corners.size() == 1) {
        result.elements.push_back(corners[0]);
        continue;
      }
      std::ranges::sort(corners);
      const auto [found, is_new] = middles.try_emplace(corners, static_cast<int32_t>(result.vertices.size()));
      if (is_new) {
        Vec3 sum;
        for (const int32_t c : corners) sum += mesh.vertices[c];
        result.vertices.push_back(sum * (1.0 / double(corners.size())));
      }
      result.elements.push_back(found->second);
    }
  return result;
}

}  // namespace stark
