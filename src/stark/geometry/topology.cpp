// Connectivity by sorting: every list is derived from sorted half-edges or faces. See topology.h.
#include <stark/geometry/topology.h>

#include <algorithm>
#include <functional>
#include <numeric>
#include <string>
#include <tuple>

#include <stark/base/bucket_sort.h>
#include <stark/base/error.h>

namespace stark {

namespace {

// Directed edge from -> to of a triangle, opposite the vertex `apex`.
struct HalfEdge {
  int32_t low, high, triangle, from, to, apex;
};

std::vector<HalfEdge> sorted_half_edges(std::span<const Index3> triangles) {
  std::vector<HalfEdge> half_edges;
  half_edges.reserve(3 * triangles.size());
  for (size_t t = 0; t < triangles.size(); ++t) {
    for (int k = 0; k < 3; ++k) {
      const int32_t from = triangles[t][k], to = triangles[t][(k + 1) % 3], apex = triangles[t][(k + 2) % 3];
      half_edges.push_back({std::min(from, to), std::max(from, to), static_cast<int32_t>(t), from, to, apex});
    }
  }
  bucket_sort(
      half_edges, [](const HalfEdge& e) { return e.low; },
      [](const HalfEdge& a, const HalfEdge& b) {
        return std::tie(a.high, a.triangle, a.from) < std::tie(b.high, b.triangle, b.from);
      });
  return half_edges;
}

// Calls body(span of half-edges) for each undirected edge, in sorted order.
template <typename Body>
void for_each_edge(std::span<const HalfEdge> half_edges, Body&& body) {
  for (size_t begin = 0; begin < half_edges.size();) {
    size_t end = begin + 1;
    while (end < half_edges.size() && half_edges[end].low == half_edges[begin].low &&
           half_edges[end].high == half_edges[begin].high) {
      ++end;
    }
    body(half_edges.subspan(begin, end - begin));
    begin = end;
  }
}

template <size_t N>
void check_element(const std::array<int32_t, N>& element, size_t number, size_t vertex_count,
                   const char* kind, const char* name) {
  for (size_t k = 0; k < N; ++k) {
    if (element[k] < 0 || static_cast<size_t>(element[k]) >= vertex_count) {
      throw InvalidMesh(std::string(name) + ": " + kind + " " + std::to_string(number) + " uses vertex " +
                        std::to_string(element[k]) + ", but there are " + std::to_string(vertex_count) +
                        " vertices (0-based); check the index array");
    }
    for (size_t j = 0; j < k; ++j) {
      if (element[j] == element[k]) {
        throw InvalidMesh(std::string(name) + ": " + kind + " " + std::to_string(number) + " uses vertex " +
                          std::to_string(element[k]) + " twice; remove the degenerate element");
      }
    }
  }
}

void check_vertices(std::span<const Vec3> vertices, const char* name) {
  for (size_t v = 0; v < vertices.size(); ++v) {
    if (!is_finite(vertices[v])) {
      throw InvalidMesh(std::string(name) + ": the position of vertex " + std::to_string(v) +
                        " is not finite; positions must be finite numbers in metres");
    }
  }
}

double tet_volume(std::span<const Vec3> x, const Index4& t) {
  return dot(x[t[1]] - x[t[0]], cross(x[t[2]] - x[t[0]], x[t[3]] - x[t[0]])) / 6.0;
}

double triangle_area(std::span<const Vec3> x, const Index3& t) {
  return 0.5 * norm(cross(x[t[1]] - x[t[0]], x[t[2]] - x[t[0]]));
}

}  // namespace

void sort_unique(std::vector<Index2>& edges) {
  bucket_sort(
      edges, [](const Index2& e) { return e[0]; },
      [](const Index2& a, const Index2& b) { return a[1] < b[1]; });
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
}

std::vector<Index2> find_edges(std::span<const Index3> triangles) {
  std::vector<Index2> edges;
  edges.reserve(3 * triangles.size());
  for (const Index3& t : triangles) {
    for (int k = 0; k < 3; ++k)
      edges.push_back({std::min(t[k], t[(k + 1) % 3]), std::max(t[k], t[(k + 1) % 3])});
  }
  sort_unique(edges);
  return edges;
}

std::vector<Index2> find_edges(std::span<const Index4> tets) {
  std::vector<Index2> edges;
  edges.reserve(6 * tets.size());
  for (const Index4& t : tets) {
    for (int a = 0; a < 4; ++a) {
      for (int b = a + 1; b < 4; ++b) edges.push_back({std::min(t[a], t[b]), std::max(t[a], t[b])});
    }
  }
  sort_unique(edges);
  return edges;
}

std::vector<Index4> find_hinges(std::span<const Index3> triangles) {
  std::vector<Index4> hinges;
  hinges.reserve(3 * triangles.size() / 2);
  for_each_edge(sorted_half_edges(triangles), [&](std::span<const HalfEdge> group) {
    for (size_t a = 0; a < group.size(); ++a) {
      for (size_t b = a + 1; b < group.size(); ++b) {
        hinges.push_back({group[a].from, group[a].to, group[a].apex, group[b].apex});
      }
    }
  });
  return hinges;
}

EdgeTriangles find_edge_triangles(std::span<const Index3> triangles) {
  EdgeTriangles result;
  result.offsets.push_back(0);
  for_each_edge(sorted_half_edges(triangles), [&](std::span<const HalfEdge> group) {
    result.edges.push_back({group[0].low, group[0].high});
    for (const HalfEdge& half_edge : group) result.triangles.push_back(half_edge.triangle);
    result.offsets.push_back(static_cast<int32_t>(result.triangles.size()));
  });
  return result;
}

std::vector<Index2> find_boundary_edges(std::span<const Index3> triangles) {
  std::vector<Index2> edges;
  for_each_edge(sorted_half_edges(triangles), [&](std::span<const HalfEdge> group) {
    if (group.size() == 1) edges.push_back({group[0].from, group[0].to});
  });
  return edges;
}

std::vector<Index3> find_boundary_triangles(std::span<const Index4> tets) {
  // Faces opposite each vertex, outward for a positively oriented tet.
  static constexpr int kFaces[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};
  struct Face {
    Index3 sorted;
    int64_t number;  // 4 tet + face
  };
  const auto oriented = [&](int64_t number) {
    const Index4& tet = tets[number / 4];
    const int* face = kFaces[number % 4];
    return Index3{tet[face[0]], tet[face[1]], tet[face[2]]};
  };
  std::vector<Face> faces(4 * tets.size());
  for (size_t number = 0; number < faces.size(); ++number) {
    faces[number] = {oriented(static_cast<int64_t>(number)), static_cast<int64_t>(number)};
    std::sort(faces[number].sorted.begin(), faces[number].sorted.end());
  }
  bucket_sort(
      faces, [](const Face& f) { return f.sorted[0]; },
      [](const Face& a, const Face& b) {
        return std::tie(a.sorted[1], a.sorted[2], a.number) < std::tie(b.sorted[1], b.sorted[2], b.number);
      });
  std::vector<int64_t> boundary;
  for (size_t begin = 0; begin < faces.size();) {
    size_t end = begin + 1;
    while (end < faces.size() && faces[end].sorted == faces[begin].sorted) ++end;
    if (end == begin + 1) boundary.push_back(faces[begin].number);
    begin = end;
  }
  std::sort(boundary.begin(), boundary.end());
  std::vector<Index3> triangles;
  triangles.reserve(boundary.size());
  for (const int64_t number : boundary) triangles.push_back(oriented(number));
  return triangles;
}

std::vector<int32_t> find_used_vertices(std::span<const Index3> triangles) {
  std::vector<int32_t> used;
  used.reserve(3 * triangles.size());
  for (const Index3& t : triangles) used.insert(used.end(), t.begin(), t.end());
  bucket_sort(used, std::identity(), std::less());
  used.erase(std::unique(used.begin(), used.end()), used.end());
  return used;
}

std::vector<int32_t> find_connected_components(int32_t vertex_count, std::span<const Index3> triangles) {
  // Union-find in which the lowest vertex is always the root.
  std::vector<int32_t> parent(vertex_count);
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&](int32_t v) {
    while (parent[v] != v) v = parent[v] = parent[parent[v]];
    return v;
  };
  for (const Index3& t : triangles) {
    for (int k = 1; k < 3; ++k) {
      const int32_t a = root(t[0]), b = root(t[k]);
      parent[std::max(a, b)] = std::min(a, b);
    }
  }
  std::vector<int32_t> component(vertex_count);
  int32_t count = 0;
  for (int32_t v = 0; v < vertex_count; ++v) {
    const int32_t r = root(v);
    component[v] = r == v ? count++ : component[r];
  }
  return component;
}

bool is_closed(std::span<const Index3> triangles) {
  bool closed = !triangles.empty();
  for_each_edge(sorted_half_edges(triangles),
                [&](std::span<const HalfEdge> group) { closed = closed && group.size() == 2; });
  return closed;
}

bool is_orientation_consistent(std::span<const Index3> triangles) {
  bool consistent = true;
  for_each_edge(sorted_half_edges(triangles), [&](std::span<const HalfEdge> group) {
    consistent = consistent && (group.size() == 1 || (group.size() == 2 && group[0].from == group[1].to));
  });
  return consistent;
}

Vec3 box_size(std::span<const Vec3> points) {
  Vec3 low = points[0], high = points[0];
  for (const Vec3& p : points)
    for (int i = 0; i < 3; ++i) low[i] = std::min(low[i], p[i]), high[i] = std::max(high[i], p[i]);
  return high - low;
}

std::vector<double> compute_vertex_areas(std::span<const Vec3> vertices, std::span<const Index3> triangles) {
  std::vector<double> areas(vertices.size(), 0.0);
  for (const Index3& t : triangles) {
    const double third = triangle_area(vertices, t) / 3.0;
    for (const int32_t v : t) areas[v] += third;
  }
  return areas;
}

std::vector<double> compute_edge_areas(std::span<const Vec3> vertices, std::span<const Index3> triangles,
                                       std::span<const Index2> edges) {
  STARK_CHECK(std::is_sorted(edges.begin(), edges.end()));
  std::vector<double> areas(edges.size(), 0.0);
  for (const Index3& t : triangles) {
    const double third = triangle_area(vertices, t) / 3.0;
    for (int k = 0; k < 3; ++k) {
      const Index2 edge{std::min(t[k], t[(k + 1) % 3]), std::max(t[k], t[(k + 1) % 3])};
      const auto found = std::lower_bound(edges.begin(), edges.end(), edge);
      if (found != edges.end() && *found == edge) areas[found - edges.begin()] += third;
    }
  }
  return areas;
}

std::vector<double> compute_triangle_areas(std::span<const Vec3> vertices,
                                           std::span<const Index3> triangles) {
  std::vector<double> areas;
  areas.reserve(triangles.size());
  for (const Index3& t : triangles) areas.push_back(triangle_area(vertices, t));
  return areas;
}

std::vector<double> compute_tet_volumes(std::span<const Vec3> vertices, std::span<const Index4> tets) {
  std::vector<double> volumes;
  volumes.reserve(tets.size());
  for (const Index4& t : tets) volumes.push_back(tet_volume(vertices, t));
  return volumes;
}

void validate(const TriangleMesh& mesh, const char* name) {
  check_vertices(mesh.vertices, name);
  for (size_t t = 0; t < mesh.triangles.size(); ++t) {
    check_element(mesh.triangles[t], t, mesh.vertices.size(), "triangle", name);
  }
}

void validate(const TetMesh& mesh, const char* name) {
  check_vertices(mesh.vertices, name);
  for (size_t t = 0; t < mesh.tets.size(); ++t) {
    check_element(mesh.tets[t], t, mesh.vertices.size(), "tet", name);
    const double volume = tet_volume(mesh.vertices, mesh.tets[t]);
    if (!(volume > 0.0)) {
      throw InvalidMesh(
          std::string(name) + ": tet " + std::to_string(t) + " has volume " + std::to_string(volume) +
          " m^3; volumes must be positive, swap two vertices of inverted tets and remove flat ones");
    }
  }
}

}  // namespace stark
