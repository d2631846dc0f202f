// Ownership of vertices and edges, and tree order by median splits. See bvh.h.
#include <stark/collision/bvh.h>

#include <algorithm>

#include <stark/base/error.h>
#include <stark/geometry/edge_lookup.h>
#include <stark/geometry/topology.h>

namespace stark::detail {

namespace {

struct Splitter {
  std::vector<Vec3> centres;
  std::vector<int32_t> order;

  void split(int64_t begin, int64_t end) {
    const int64_t count = end - begin;
    if (count <= kWidth) {
      std::sort(order.begin() + begin, order.begin() + end);
      return;
    }
    int64_t block = kWidth;
    while (block * kWidth < count) block *= kWidth;
    const int64_t blocks = (count + block - 1) / block;
    const int64_t middle = begin + block * ((blocks + 1) / 2);
    Vec3 low = centres[order[begin]], high = low;
    for (int64_t k = begin + 1; k < end; ++k) {
      const Vec3& c = centres[order[k]];
      low = {std::min(low.x, c.x), std::min(low.y, c.y), std::min(low.z, c.z)};
      high = {std::max(high.x, c.x), std::max(high.y, c.y), std::max(high.z, c.z)};
    }
    const Vec3 extent = high - low;
    const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : (extent.y >= extent.z ? 1 : 2);
    std::nth_element(order.begin() + begin, order.begin() + middle, order.begin() + end,
                     [&](int32_t i, int32_t j) {
                       const double ci = centres[i][axis], cj = centres[j][axis];
                       return ci != cj ? ci < cj : i < j;
                     });
    split(begin, middle);
    split(middle, end);
  }
};

}  // namespace

void Bvh::reset(SurfaceMesh mesh, int32_t group_count) {
  validate(mesh, group_count);
  mesh_ = std::move(mesh);
  make_cells(group_count);
  make_chunks();
  clearances_.clear();
  vertex_boxes_.assign(mesh_.vertex_count, kEmptyBox);
  vertex_motions_.assign(mesh_.vertex_count, Box{});
}

void Bvh::make_cells(int32_t group_count) {
  const EdgeTriangles sides = find_edge_triangles(mesh_.triangles);
  const EdgeLookup side_between(sides.edges);

  std::vector<Cell> cells;  // in the order triangles, edges, points
  std::vector<int32_t> groups;
  std::vector<bool> owned(mesh_.vertex_count, false), inner(mesh_.vertex_count, false);
  for (const int32_t v : mesh_.inner) inner[v] = true;
  const auto own_vertex = [&](Cell& cell, int32_t v) {
    if (owned[v]) return;
    owned[v] = true;
    if (!inner[v]) cell.points[cell.point_count++] = v;
  };
  const auto own_edge = [&](Cell& cell, size_t e) {
    cell.edge_vertices[cell.edge_count] = mesh_.edges[e];
    cell.edges[cell.edge_count++] = static_cast<int32_t>(e);
  };
  for (size_t t = 0; t < mesh_.triangles.size(); ++t) {
    Cell cell;
    cell.vertices = mesh_.triangles[t];
    cell.triangle = static_cast<int32_t>(t);
    for (const int32_t v : cell.vertices) own_vertex(cell, v);
    cells.push_back(cell);
    groups.push_back(mesh_.triangle_group[t]);
  }
  for (size_t e = 0; e < mesh_.edges.size(); ++e) {
    const auto [low, high] = std::minmax(mesh_.edges[e][0], mesh_.edges[e][1]);
    // A repeated edge may find its first triangle full; then the next one, or a cell of its own.
    const int32_t side = side_between.find(low, high);
    int32_t i = side < 0 ? 0 : sides.offsets[side];
    const int32_t end = side < 0 ? 0 : sides.offsets[side + 1];
    while (i < end && cells[sides.triangles[i]].edge_count == 3) ++i;
    if (i < end) {
      own_edge(cells[sides.triangles[i]], e);
      continue;
    }
    Cell cell;
    cell.vertices = {mesh_.edges[e][0], mesh_.edges[e][1], mesh_.edges[e][1]};
    own_edge(cell, e);
    own_vertex(cell, low);
    own_vertex(cell, high);
    cells.push_back(cell);
    groups.push_back(mesh_.edge_group[e]);
  }
  for (const int32_t v : mesh_.points) {
    if (owned[v]) continue;
    Cell cell;
    cell.vertices = {v, v, v};
    own_vertex(cell, v);
    cells.push_back(cell);
    groups.push_back(mesh_.vertex_group[v]);
  }
  points_.clear();
  for (int32_t v = 0; v < mesh_.vertex_count; ++v) {
    if (owned[v]) points_.push_back(v);
  }
  std::ranges::stable_sort(points_, {}, [&](int32_t v) { return mesh_.vertex_group[v]; });

  trees_.assign(group_count, Tree{});
  for (const int32_t group : groups) ++trees_[group].cell_count;
  int32_t padded = 0;
  for (Tree& tree : trees_) {
    tree.cell_begin = padded;
    padded += (tree.cell_count + kWidth - 1) / kWidth * kWidth;
  }
  cells_.assign(padded, Cell{});
  std::vector<int32_t> next(group_count);
  for (int32_t g = 0; g < group_count; ++g) next[g] = trees_[g].cell_begin;
  for (size_t k = 0; k < cells.size(); ++k) cells_[next[groups[k]]++] = cells[k];
  // Level 0 of all groups first, where node k holds cells 8 k to 8 k + 7; upper levels follow.
  int32_t node_count = padded / kWidth;
  for (Tree& tree : trees_) {
    if (tree.cell_count == 0) continue;
    int32_t size = (tree.cell_count + kWidth - 1) / kWidth;
    tree.level_begin[0] = tree.cell_begin / kWidth;
    tree.level_size[0] = size;
    tree.level_count = 1;
    while (size > 1) {
      size = (size + kWidth - 1) / kWidth;
      STARK_CHECK(tree.level_count < kMaxLevels);
      tree.level_begin[tree.level_count] = node_count;
      tree.level_size[tree.level_count++] = size;
      node_count += size;
    }
  }
  nodes_.assign(node_count, BoxNode{});
  motion_nodes_.assign(node_count, BoxNode{});
  moved_nodes_.assign(node_count, kAll);
}

void Bvh::build(Tree& tree) {
  Splitter splitter;
  splitter.centres.resize(tree.cell_count);
  splitter.order.resize(tree.cell_count);
  for (int32_t k = 0; k < tree.cell_count; ++k) {
    Vec3& centre = splitter.centres[k];
    for (const int32_t v : cells_[tree.cell_begin + k].vertices) {
      const Box& box = vertex_boxes_[v];
      for (int axis = 0; axis < 3; ++axis)
        centre[axis] += static_cast<double>(box.low[axis]) + static_cast<double>(box.high[axis]);
    }
    splitter.order[k] = k;
  }
  splitter.split(0, tree.cell_count);
  std::vector<Cell> sorted(tree.cell_count);
  for (int32_t k = 0; k < tree.cell_count; ++k) sorted[k] = cells_[tree.cell_begin + splitter.order[k]];
  std::copy(sorted.begin(), sorted.end(), cells_.begin() + tree.cell_begin);
}

}  // namespace stark::detail
