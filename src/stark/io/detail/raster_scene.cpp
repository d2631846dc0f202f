// Flattening of meshes for the rasteriser, with normals that break at sharp edges.
#include <stark/io/detail/raster_scene.h>

#include <algorithm>
#include <numeric>
#include <string>
#include <utility>

#include <stark/base/error.h>

namespace stark::raster {
namespace {

void check(const RasterMesh& mesh, size_t index) {
  const std::string name = "mesh " + std::to_string(index);
  for (size_t v = 0; v < mesh.positions.size(); ++v)
    if (!is_finite(mesh.positions[v]))
      throw InvalidArgument(name + ": vertex " + std::to_string(v) +
                            " is not finite; only finite positions can be drawn");
  for (size_t t = 0; t < mesh.triangles.size(); ++t)
    for (const int32_t v : mesh.triangles[t])
      if (v < 0 || static_cast<size_t>(v) >= mesh.positions.size())
        throw InvalidArgument(name + ": triangle " + std::to_string(t) + " names vertex " +
                              std::to_string(v) + "; the mesh has " + std::to_string(mesh.positions.size()));
}

int32_t find(std::vector<int32_t>& parent, int32_t i) {
  while (parent[i] != i) i = parent[i] = parent[parent[i]];
  return i;
}

/// Corners of triangles that meet in a smooth edge join; each joined set gets the area-weighted mean normal.
void append_corner_normals(const RasterMesh& mesh, std::span<const Triangle> triangles,
                           std::vector<std::array<Vec3, 3>>& out_normals) {
  struct Edge {
    int32_t low, high, corner;  // corner: where the edge begins in its triangle
  };
  const auto count = static_cast<int32_t>(triangles.size());
  std::vector<Edge> edges;
  edges.reserve(3 * triangles.size());
  for (int32_t t = 0; t < count; ++t)
    for (int e = 0; e < 3; ++e) {
      const auto [low, high] = std::minmax(mesh.triangles[t][e], mesh.triangles[t][(e + 1) % 3]);
      edges.push_back({low, high, 3 * t + e});
    }
  std::sort(edges.begin(), edges.end(), [](const Edge& a, const Edge& b) {
    return a.low != b.low ? a.low < b.low : (a.high != b.high ? a.high < b.high : a.corner < b.corner);
  });
  std::vector<int32_t> parent(3 * triangles.size());
  std::iota(parent.begin(), parent.end(), 0);
  const double cosine = mesh.crease_angle >= 3.14 ? -2.0 : std::cos(mesh.crease_angle);
  const auto corner_of = [&](int32_t triangle, int32_t vertex) {
    for (int e = 0; e < 3; ++e)
      if (mesh.triangles[triangle][e] == vertex) return 3 * triangle + e;
    return 3 * triangle;
  };
  for (size_t i = 1; i < edges.size(); ++i) {
    const Edge &a = edges[i - 1], &b = edges[i];
    if (a.low != b.low || a.high != b.high) continue;
    const int32_t s = a.corner / 3, t = b.corner / 3;
    if (dot(triangles[s].normal, triangles[t].normal) < cosine) continue;
    for (const int32_t vertex : {a.low, a.high})
      parent[find(parent, corner_of(s, vertex))] = find(parent, corner_of(t, vertex));
  }
  std::vector<Vec3> sums(parent.size());
  for (int32_t t = 0; t < count; ++t) {
    const auto& c = triangles[t].corners;
    const Vec3 area = cross(c[1] - c[0], c[2] - c[0]);
    for (int e = 0; e < 3; ++e) sums[find(parent, 3 * t + e)] += area;
  }
  for (int32_t t = 0; t < count; ++t) {
    std::array<Vec3, 3> normals;
    for (int e = 0; e < 3; ++e) {
      const Vec3& sum = sums[find(parent, 3 * t + e)];
      const double length = norm(sum);
      normals[e] = length > 0.0 ? sum / length : triangles[t].normal;
    }
    out_normals.push_back(normals);
  }
}

}  // namespace

TriangleScene flatten(std::span<const RasterMesh> meshes) {
  TriangleScene scene;
  for (size_t m = 0; m < meshes.size(); ++m) {
    const RasterMesh& mesh = meshes[m];
    check(mesh, m);
    const size_t begin = scene.triangles.size();
    for (const auto& t : mesh.triangles) {
      Triangle triangle{
          {mesh.positions[t[0]], mesh.positions[t[1]], mesh.positions[t[2]]}, {}, static_cast<int32_t>(m)};
      const auto& c = triangle.corners;
      const Vec3 area = cross(c[1] - c[0], c[2] - c[0]);
      const double length = norm(area);
      if (length > 0.0) triangle.normal = area / length;
      scene.triangles.push_back(triangle);
    }
    append_corner_normals(mesh, std::span(scene.triangles).subspan(begin), scene.corner_normals);
  }
  return scene;
}

}  // namespace stark::raster
