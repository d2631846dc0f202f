#include <stark/collision/collision_set.h>

#include <algorithm>
#include <string>
#include <utility>

#include <stark/base/error.h>

namespace stark {

CollisionSet::CollisionSet(std::vector<int32_t> vertex_group, std::vector<Index2> edges,
                           std::vector<Index3> triangles, std::vector<int32_t> points,
                           std::span<const Index2> excluded, int threads)
    : pool_(threads) {
  SurfaceMesh mesh{.vertex_count = static_cast<int32_t>(vertex_group.size()),
                   .points = std::move(points),
                   .inner = {},
                   .edges = std::move(edges),
                   .triangles = std::move(triangles),
                   .vertex_group = std::move(vertex_group),
                   .edge_group = {},
                   .triangle_group = {}};
  const auto group_of = [&](int32_t v) {
    return v >= 0 && v < mesh.vertex_count ? mesh.vertex_group[v] : 0;  // reset() reports bad indices
  };
  for (const Index2& e : mesh.edges) mesh.edge_group.push_back(group_of(e[0]));
  for (const Index3& t : mesh.triangles) mesh.triangle_group.push_back(group_of(t[0]));
  int32_t group_count = 0;
  for (const int32_t group : mesh.vertex_group) group_count = std::max(group_count, group + 1);
  PairFilter filter(group_count);
  for (const Index2& pair : excluded) filter.set(pair[0], pair[1], false);
  broad_phase_.reset(std::move(mesh), std::move(filter));
}

CandidateList CollisionSet::find(std::span<const Vec3> x0, std::span<const Vec3> x1,
                                 std::span<const double> inflation) {
  check_count("x0", x0);
  check_count("x1", x1);
  CandidateList list;
  broad_phase_.find_swept(x0, x1, inflation, pool_, list);
  return list;
}

CcdReport CollisionSet::max_safe_step(std::span<const Vec3> x0, std::span<const Vec3> x1,
                                      std::span<const double> separation) {
  const CandidateList list = find(x0, x1, separation);
  CcdReport report;
  stark::max_safe_step(broad_phase_.mesh(), list, x0, x1, {separation}, pool_, &report);
  return report;
}

std::vector<EdgeTriangleIntersection> CollisionSet::find_intersections(std::span<const Vec3> x) {
  check_count("x", x);
  return stark::find_intersections(broad_phase_.mesh(), x, broad_phase_.filter(), pool_);
}

std::vector<ContainedGroup> CollisionSet::find_contained_groups(std::span<const Vec3> x) {
  check_count("x", x);
  return stark::find_contained_groups(broad_phase_.mesh(), x, broad_phase_.filter(), pool_);
}

void CollisionSet::check_count(const char* name, std::span<const Vec3> x) const {
  const auto count = static_cast<size_t>(broad_phase_.mesh().vertex_count);
  if (x.size() != count)
    throw InvalidArgument(std::string(name) + ": got " + std::to_string(x.size()) + " rows: must be " +
                          std::to_string(count) + ", one for each vertex");
}

}  // namespace stark
