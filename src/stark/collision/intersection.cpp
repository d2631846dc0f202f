// Edge-triangle intersections through the hierarchy with exact predicates, containment by connected pieces.
// See intersection.h.
#include <stark/collision/intersection.h>

#include <algorithm>
#include <array>
#include <cmath>

#include <stark/collision/bounds.h>
#include <stark/collision/bvh.h>
#include <stark/geometry/distance.h>
#include <stark/geometry/intersection.h>
#include <stark/geometry/topology.h>

namespace stark {

namespace {

using detail::Bvh;
using detail::Cell;

void add_edge_triangle(const Bvh& bvh, const Cell& a, const Cell& b, std::span<const Vec3> x,
                       std::vector<EdgeTriangleIntersection>& out) {
  if (b.triangle < 0 || a.edge_count == 0) return;
  const auto box = bvh.cell_extent<detail::Box>(b);
  const Index3& t = b.vertices;
  for (int k = 0; k < a.edge_count; ++k) {
    const Index2& e = a.edge_vertices[k];
    if (e[0] == t[0] || e[0] == t[1] || e[0] == t[2] || e[1] == t[0] || e[1] == t[1] || e[1] == t[2])
      continue;
    if (!box.overlaps(bvh.edge_extent<detail::Box>(e))) continue;
    if (segment_intersects_triangle(x[e[0]], x[e[1]], x[t[0]], x[t[1]], x[t[2]])) {
      out.push_back({a.edges[k], b.triangle});
    }
  }
}

// Lowest vertex of each connected piece of the collision primitives, sorted.
std::vector<int32_t> find_piece_vertices(const SurfaceMesh& mesh) {
  std::vector<Index3> links = mesh.triangles;
  for (const Index2& e : mesh.edges) links.push_back({e[0], e[1], e[1]});
  for (const int32_t v : mesh.points) links.push_back({v, v, v});
  const std::vector<int32_t> component = find_connected_components(mesh.vertex_count, links);
  std::vector<bool> seen(mesh.vertex_count, false);
  std::vector<int32_t> result;
  for (const int32_t v : find_used_vertices(links)) {
    if (!seen[component[v]]) result.push_back(v);
    seen[component[v]] = true;
  }
  return result;
}

}  // namespace

struct IntersectionFinder::Parts {
  Bvh bvh;
  std::vector<bool> is_solid;                  // by group: closed, and filled
  std::vector<std::vector<Index3>> triangles;  // of solid groups
  std::vector<int32_t> pieces;                 // a vertex of each connected piece, sorted
  std::vector<double> no_inflation;            // by group
};

IntersectionFinder::IntersectionFinder(SurfaceMesh mesh, int32_t group_count, std::vector<bool> is_filled)
    : parts_(std::make_unique<Parts>()) {
  parts_->triangles.resize(group_count);
  for (size_t t = 0; t < mesh.triangles.size(); ++t)
    parts_->triangles[mesh.triangle_group[t]].push_back(mesh.triangles[t]);
  for (int32_t g = 0; g < group_count; ++g) {
    const bool is_solid = (is_filled.empty() || is_filled[g]) && is_closed(parts_->triangles[g]);
    parts_->is_solid.push_back(is_solid);
    if (!is_solid) parts_->triangles[g] = {};
  }
  parts_->pieces = find_piece_vertices(mesh);
  parts_->no_inflation.assign(group_count, 0.0);
  parts_->bvh.reset(std::move(mesh), group_count);
}

IntersectionFinder::~IntersectionFinder() = default;

std::vector<EdgeTriangleIntersection> IntersectionFinder::intersections(std::span<const Vec3> x,
                                                                        const PairFilter& filter,
                                                                        ThreadPool& pool) {
  Bvh& bvh = parts_->bvh;
  const SurfaceMesh& mesh = bvh.mesh();
  bvh.refit(x, parts_->no_inflation, pool);
  std::vector<std::vector<EdgeTriangleIntersection>> found(pool.thread_count());
  bvh.for_each_pair<detail::Box>(filter, pool, [&](int thread, const Cell& a, const Cell& b, bool) {
    add_edge_triangle(bvh, a, b, x, found[thread]);
    add_edge_triangle(bvh, b, a, x, found[thread]);
  });
  std::vector<EdgeTriangleIntersection> result;
  for (const auto& part : found) result.insert(result.end(), part.begin(), part.end());
  if (filter.has_exclusions())
    std::erase_if(result, [&](const EdgeTriangleIntersection& pair) {
      return filter.excluded(mesh.edges[pair.edge], mesh.edge_group[pair.edge], mesh.triangles[pair.triangle],
                             mesh.triangle_group[pair.triangle]);
    });
  std::sort(result.begin(), result.end(), [](const auto& a, const auto& b) {
    return a.edge != b.edge ? a.edge < b.edge : a.triangle < b.triangle;
  });
  return result;
}

std::vector<ContainedGroup> IntersectionFinder::contained_groups(std::span<const Vec3> x,
                                                                 const PairFilter& filter,
                                                                 ThreadPool& pool) const {
  const SurfaceMesh& mesh = parts_->bvh.mesh();
  const auto group_count = static_cast<int32_t>(parts_->is_solid.size());
  std::vector<std::vector<ContainedGroup>> found(group_count);
  pool.for_each_task(group_count, [&](int64_t task, int) {
    const int32_t outer = static_cast<int32_t>(task);
    if (!parts_->is_solid[outer]) return;
    Bounds bounds;
    for (const Index3& triangle : parts_->triangles[outer])
      for (const int32_t v : triangle) bounds.add(x[v]);
    std::vector<bool> reported(group_count, false);
    for (const int32_t v : parts_->pieces) {
      const int32_t inner = mesh.vertex_group[v];
      if (inner == outer || reported[inner] || !filter.allowed(inner, outer) || filter.excluded(v, outer) ||
          !bounds.contains(x[v]))
        continue;
      if (locate_point(x[v], x, parts_->triangles[outer]) != PointLocation::Inside) continue;
      reported[inner] = true;
      found[outer].push_back({inner, outer, v});
    }
  });
  std::vector<ContainedGroup> result;
  for (const auto& part : found) result.insert(result.end(), part.begin(), part.end());
  std::sort(result.begin(), result.end(), [](const auto& a, const auto& b) {
    return a.inner != b.inner ? a.inner < b.inner : a.outer < b.outer;
  });
  return result;
}

namespace {

constexpr int kCorners[3][2] = {{0, 1}, {1, 2}, {2, 0}};

void keep_nearest(const ClosestPoints& found, ClosestPoints& nearest) {
  if (found.distance < nearest.distance) nearest = found;
}

void add_point_to_triangle(const Vec3& p, const Index3& t, std::span<const Vec3> x, bool is_turned,
                           ClosestPoints& nearest) {
  const std::array<double, 3> w =
      point_triangle_weights(p, x[t[0]], x[t[1]], x[t[2]], point_triangle_type(p, x[t[0]], x[t[1]], x[t[2]]));
  const Vec3 q = x[t[0]] * w[0] + x[t[1]] * w[1] + x[t[2]] * w[2];
  keep_nearest(is_turned ? ClosestPoints{norm(p - q), q, p} : ClosestPoints{norm(p - q), p, q}, nearest);
}

/// Between two cells, of groups a and b.
void add_cells(const Cell& a, const Cell& b, std::span<const Vec3> x, ClosestPoints& nearest) {
  for (int k = 0; k < 3; ++k) {
    if (b.triangle >= 0) add_point_to_triangle(x[a.vertices[k]], b.vertices, x, false, nearest);
    if (a.triangle >= 0) add_point_to_triangle(x[b.vertices[k]], a.vertices, x, true, nearest);
  }
  for (const auto& i : kCorners)
    for (const auto& j : kCorners) {
      const Vec3 &a0 = x[a.vertices[i[0]]], &a1 = x[a.vertices[i[1]]];
      const Vec3 &b0 = x[b.vertices[j[0]]], &b1 = x[b.vertices[j[1]]];
      const std::array<double, 4> w = edge_edge_weights(a0, a1, b0, b1, edge_edge_type(a0, a1, b0, b1));
      const Vec3 p = a0 * w[0] + a1 * w[1], q = b0 * w[2] + b1 * w[3];
      keep_nearest({norm(p - q), p, q}, nearest);
    }
}

}  // namespace

ClosestPoints IntersectionFinder::closest_points(std::span<const Vec3> x, int32_t group_a, int32_t group_b,
                                                 ThreadPool& pool) {
  Bvh& bvh = parts_->bvh;
  const SurfaceMesh& mesh = bvh.mesh();
  PairFilter filter(bvh.group_count(), false, false);
  filter.set(group_a, group_b, true);
  if (const auto meeting = intersections(x, filter, pool); !meeting.empty()) {
    const Index2& edge = mesh.edges[meeting.front().edge];
    const Index3& t = mesh.triangles[meeting.front().triangle];
    const Vec3 place = meeting_point(x[edge[0]], x[edge[1]], x[t[0]], x[t[1]], x[t[2]]);
    return {0.0, place, place};
  }
  Bounds bounds[2];
  for (int32_t v = 0; v < mesh.vertex_count; ++v)
    for (const int side : {0, 1})
      if (mesh.vertex_group[v] == (side == 0 ? group_a : group_b)) bounds[side].add(x[v]);
  Vec3 gap, size;
  for (int k = 0; k < 3; ++k) {
    gap[k] = std::max({0.0, bounds[0].low[k] - bounds[1].high[k], bounds[1].low[k] - bounds[0].high[k]});
    size[k] = std::max(bounds[0].high[k], bounds[1].high[k]) - std::min(bounds[0].low[k], bounds[1].low[k]);
  }
  // Pairs within a reach, which grows until the nearest one is known.
  ClosestPoints nearest;
  ThreadPool alone(1);  // few pairs, in a fixed order
  double reach = norm(gap) + 1e-3 * norm(size);
  while (reach <= 16.0 * norm(size)) {  // not NaN
    std::vector<double> inflation(bvh.group_count(), 0.0);
    inflation[group_a] = inflation[group_b] = 0.5 * reach;
    bvh.refit(x, inflation, pool);
    std::vector<std::pair<const Cell*, const Cell*>> pairs;
    bvh.for_each_pair<detail::Box>(filter, alone, [&](int, const Cell& a, const Cell& b, bool) {
      const bool is_turned = mesh.vertex_group[a.vertices[0]] != group_a;
      pairs.emplace_back(is_turned ? &b : &a, is_turned ? &a : &b);
    });
    for (const auto& [a, b] : pairs) add_cells(*a, *b, x, nearest);
    if (nearest.distance <= reach || reach == 0.0) break;
    reach = std::min(2.0 * reach, nearest.distance);
  }
  return nearest;
}

std::vector<EdgeTriangleIntersection> find_intersections(const SurfaceMesh& mesh, std::span<const Vec3> x,
                                                         const PairFilter& filter, ThreadPool& pool) {
  return IntersectionFinder(mesh, filter.group_count()).intersections(x, filter, pool);
}

std::vector<ContainedGroup> find_contained_groups(const SurfaceMesh& mesh, std::span<const Vec3> x,
                                                  const PairFilter& filter, ThreadPool& pool,
                                                  const std::vector<bool>& is_filled) {
  return IntersectionFinder(mesh, filter.group_count(), is_filled).contained_groups(x, filter, pool);
}

}  // namespace stark
