#include <stark/contact/surface_directions.h>

#include <cmath>

#include <stark/geometry/edge_lookup.h>

namespace stark {

namespace {

/// Part of a direction in a plane below which it counts as normal to it.
constexpr double kSmallestSine = 1e-3;

}  // namespace

TangentComponents tangent_components(const Vec3& x0, const Vec3& x1, const Vec3& x2, const Vec3& direction) {
  const Vec3 a = x1 - x0, b = x2 - x0, n = cross(a, b);
  const double squared = squared_norm(n);
  Vec3 t = direction / norm(direction);
  t = t - n * (dot(n, t) / squared);
  if (norm(t) < kSmallestSine) return {};
  t = normalized(t);
  return {dot(cross(t, b), n) / squared, dot(cross(a, t), n) / squared};
}

SurfaceDirections::SurfaceDirections(const SurfaceMesh& mesh, std::vector<TangentComponents> components)
    : components_(std::move(components)) {
  if (components_.empty()) return;
  triangles_of_vertex_.resize(mesh.vertex_count);
  triangles_of_edge_.resize(mesh.edges.size());
  const EdgeLookup edges(mesh.edges);
  for (size_t t = 0; t < components_.size(); ++t) {
    for (int k = 0; k < 3; ++k) {
      const int32_t a = mesh.triangles[t][k], b = mesh.triangles[t][(k + 1) % 3];
      triangles_of_vertex_[a].push_back(static_cast<int32_t>(t));
      if (const int32_t edge = edges.find(a, b); edge >= 0)
        triangles_of_edge_[edge].push_back(static_cast<int32_t>(t));
    }
  }
}

Vec3 SurfaceDirections::of_triangles(const SurfaceMesh& mesh, std::span<const int32_t> triangles,
                                     const Vec3& normal, std::span<const Vec3> x) const {
  Vec3 sum;
  double total = 0.0;
  for (const int32_t t : triangles) {
    const auto& [v0, v1, v2] = mesh.triangles[t];
    const Vec3 a = x[v1] - x[v0], b = x[v2] - x[v0];
    const Vec3 pushed = a * components_[t][0] + b * components_[t][1];
    const double length = norm(pushed), weight = std::fabs(dot(cross(a, b), normal));
    total += weight;
    if (length > 0.0) sum += pushed * ((dot(sum, pushed) < 0.0 ? -weight : weight) / length);
  }
  const Vec3 in_plane = sum - normal * dot(normal, sum);
  return norm(in_plane) > kSmallestSine * total ? normalized(in_plane) : Vec3{};
}

Vec3 SurfaceDirections::of_pair(const SurfaceMesh& mesh, const PairKey& key, int32_t group,
                                const Vec3& normal, std::span<const Vec3> x) const {
  if (components_.empty()) return {};
  const auto of = [&](std::span<const int32_t> triangles) {
    return of_triangles(mesh, triangles, normal, x);
  };
  if (key.kind == PairKind::PointTriangle) {
    if (mesh.triangle_group[key.second] == group) return of({&key.second, 1});
    return of(triangles_of_vertex_[key.first]);
  }
  if (key.kind == PairKind::EdgeEdge)
    return of(triangles_of_edge_[mesh.edge_group[key.first] == group ? key.first : key.second]);
  if ((key.kind == PairKind::PointEdge || key.kind == PairKey::kOther) &&
      mesh.vertex_group[key.first] == group)
    return of(triangles_of_vertex_[key.first]);
  return {};
}

}  // namespace stark
