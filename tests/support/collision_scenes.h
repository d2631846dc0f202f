// Surface meshes of several bodies for collision tests.
#pragma once

#include <algorithm>

#include <stark/collision/candidates.h>
#include <stark/collision/primitive_pairs.h>
#include <stark/geometry/mesh.h>
#include <stark/geometry/topology.h>

namespace stark::test {

/// Collects bodies into one SurfaceMesh; each add_* is a new group.
class SceneBuilder {
 public:
  int32_t add_mesh(const TriangleMesh& mesh, const Vec3& shift = {}) {
    const int32_t offset = add_vertices(mesh.vertices, shift);
    for (const Index2& e : find_edges(mesh.triangles)) {
      surface.edges.push_back({e[0] + offset, e[1] + offset});
      surface.edge_group.push_back(group_count);
    }
    for (const Index3& t : mesh.triangles) {
      surface.triangles.push_back({t[0] + offset, t[1] + offset, t[2] + offset});
      surface.triangle_group.push_back(group_count);
    }
    return group_count++;
  }

  /// Polyline without triangles.
  int32_t add_rod(const std::vector<Vec3>& vertices) {
    const int32_t offset = add_vertices(vertices, {});
    for (size_t k = 0; k + 1 < vertices.size(); ++k) {
      surface.edges.push_back({static_cast<int32_t>(offset + k), static_cast<int32_t>(offset + k + 1)});
      surface.edge_group.push_back(group_count);
    }
    return group_count++;
  }

  int32_t add_particles(const std::vector<Vec3>& vertices) {
    const int32_t offset = add_vertices(vertices, {});
    for (size_t k = 0; k < vertices.size(); ++k) surface.points.push_back(static_cast<int32_t>(offset + k));
    return group_count++;
  }

  SurfaceMesh surface;
  std::vector<Vec3> x;
  int32_t group_count = 0;

 private:
  int32_t add_vertices(const std::vector<Vec3>& vertices, const Vec3& shift) {
    const int32_t offset = surface.vertex_count;
    for (const Vec3& v : vertices) x.push_back(v + shift);
    surface.vertex_count += static_cast<int32_t>(vertices.size());
    surface.vertex_group.resize(surface.vertex_count, group_count);
    return offset;
  }
};

/// Whether the lists of `large` are sorted, without doubles, and have all of `small`.
inline bool includes(const CandidateList& large, const CandidateList& small) {
  bool holds = true;
  for_each_pair_kind([&](auto kind) {
    holds = holds && std::ranges::is_sorted(large[kind]) &&
            std::ranges::adjacent_find(large[kind]) == large[kind].end() &&
            std::ranges::includes(large[kind], small[kind]);
  });
  return holds;
}

}  // namespace stark::test
