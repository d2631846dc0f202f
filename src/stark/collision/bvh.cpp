// Ownership of vertices and edges, tree order by median splits, refit, and pairs of groups by sweeping. See
// bvh.h.
#include <stark/collision/bvh.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include <stark/base/error.h>

namespace stark::detail {

namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr Box kEmptyBox = {{kInfinity, kInfinity, kInfinity, 0.0f},
                           {-kInfinity, -kInfinity, -kInfinity, 0.0f}};
// A tree is built anew when the sum of its leaves' extents has grown by this factor.
constexpr double kRebuildGrowth = 2.0;
// A triangle is large beside a group when the sides of its box sum to this part of those of the group's box.
constexpr float kLargePart = 0.25f;
// Leaf blocks per unit of parallel work.
constexpr int32_t kLeavesPerTask = 64;

// Boxes of what is farther away than floats reach end at the largest one: an infinite box would overlap the
// empty slots of nodes.
float bounded(float value) {
  constexpr float kLargest = std::numeric_limits<float>::max();
  return std::clamp(value, -kLargest, kLargest);
}

// One unit in the last place further out; subtracting two roundings' worth keeps the bound after the
// conversion.
float round_down(double value) {
  const float rounded = static_cast<float>(value);
  return bounded(rounded - std::fabs(rounded) * 0x1p-23f - 1e-37f);
}
float round_up(double value) {
  const float rounded = static_cast<float>(value);
  return bounded(rounded + std::fabs(rounded) * 0x1p-23f + 1e-37f);
}

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
  vertex_boxes_.assign(mesh_.vertex_count, kEmptyBox);
  vertex_motions_.assign(mesh_.vertex_count, Box{});
}

void Bvh::make_cells(int32_t group_count) {
  // Lowest triangle that has the edge, by binary search in the sorted list of triangle sides.
  struct Side {
    int32_t low, high, triangle, corner;
  };
  std::vector<Side> sides;
  sides.reserve(3 * mesh_.triangles.size());
  for (size_t t = 0; t < mesh_.triangles.size(); ++t) {
    const Index3& v = mesh_.triangles[t];
    for (int k = 0; k < 3; ++k) {
      sides.push_back(
          {std::min(v[k], v[(k + 1) % 3]), std::max(v[k], v[(k + 1) % 3]), static_cast<int32_t>(t), k});
    }
  }
  const auto less = [](const Side& a, const Side& b) {
    if (a.low != b.low) return a.low < b.low;
    return a.high != b.high ? a.high < b.high : a.triangle < b.triangle;
  };
  std::sort(sides.begin(), sides.end(), less);

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
    const int32_t low = std::min(mesh_.edges[e][0], mesh_.edges[e][1]);
    const int32_t high = std::max(mesh_.edges[e][0], mesh_.edges[e][1]);
    auto side = std::lower_bound(sides.begin(), sides.end(), Side{low, high, -1, 0}, less);
    // A repeated edge may find its first triangle full; then the next one, or a cell of its own.
    while (side != sides.end() && side->low == low && side->high == high &&
           cells[side->triangle].edge_count == 3) {
      ++side;
    }
    if (side != sides.end() && side->low == low && side->high == high) {
      Cell& cell = cells[side->triangle];
      own_edge(cell, e);
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

void Bvh::refit(std::span<const Vec3> x0, std::span<const Vec3> x1, std::span<const double> group_inflation,
                ThreadPool& pool, std::span<const uint8_t> moved, bool is_moving) {
  const size_t vertex_count = static_cast<size_t>(mesh_.vertex_count);
  if (x0.size() < vertex_count || x1.size() < vertex_count) {
    throw InvalidArgument("collision: " + std::to_string(std::min(x0.size(), x1.size())) + " positions for " +
                          std::to_string(vertex_count) + " vertices; give one each");
  }
  if (group_inflation.size() != trees_.size()) {
    throw InvalidArgument("collision: " + std::to_string(group_inflation.size()) + " inflations for " +
                          std::to_string(trees_.size()) + " groups; give one each, in metres");
  }
  if (!moved.empty() && moved.size() < vertex_count) {
    throw InvalidArgument("collision: " + std::to_string(moved.size()) + " marks of motion for " +
                          std::to_string(vertex_count) + " vertices; give one each, or none");
  }
  if (points_.empty()) return;
  is_moving_ = is_moving;
  moved_.assign(moved.begin(), moved.end());
  refit_vertices(x0, x1, group_inflation, pool);
  for (Tree& tree : trees_) {
    tree.is_fitted = false;
    tree.has_moved = moved.empty();
    tree.extent = {kEmptyBox, kEmptyBox};
  }
  for (const int32_t v : points_) {
    Tree& tree = trees_[mesh_.vertex_group[v]];
    tree.extent.start = merge(tree.extent.start, vertex_boxes_[v]);
    if (!moved.empty() && moved[v] != 0) tree.has_moved = true;
    if (is_moving) tree.extent.motion = merge(tree.extent.motion, vertex_motions_[v]);
  }
  for (Tree& tree : trees_) {
    tree.bounds = tree.extent.start;
    if (!is_moving || tree.cell_count == 0) continue;
    tree.bounds.low += min(tree.extent.motion.low, Float4{});
    tree.bounds.high += max(tree.extent.motion.high, Float4{});
  }
}

void Bvh::fit_trees(ThreadPool& pool) {
  std::vector<Tree*> trees;
  std::vector<std::pair<int32_t, int32_t>> chunks;  // of leaves
  for (const Task& task : tasks_) {
    for (Tree* tree : {&trees_[task.a], &trees_[task.b]}) {
      if (tree->is_fitted) continue;
      tree->is_fitted = true;
      trees.push_back(tree);
      if (tree->built_size < 0.0) build(*tree);
      constexpr int32_t kLeafGrain = 512;
      for (int32_t begin = 0; begin < tree->level_size[0]; begin += kLeafGrain)
        chunks.emplace_back(tree->level_begin[0] + begin,
                            tree->level_begin[0] + std::min(begin + kLeafGrain, tree->level_size[0]));
    }
  }
  pool.for_each_task(static_cast<int64_t>(chunks.size()),
                     [&](int64_t k, int) { refit_leaves(chunks[k].first, chunks[k].second); });
  for (Tree* tree : trees) {
    const double size = leaf_size(*tree);
    if (tree->built_size < 0.0) {
      tree->built_size = size;
    } else if (size > kRebuildGrowth * tree->built_size && tree->level_count > 1) {
      build(*tree);
      refit_leaves(tree->level_begin[0], tree->level_begin[0] + tree->level_size[0]);
      tree->built_size = leaf_size(*tree);
    }
    refit_upper_levels(*tree, nodes_);
    if (is_moving_) refit_upper_levels(*tree, motion_nodes_);
    mark_moved(*tree);
  }
}

void Bvh::refit_vertices(std::span<const Vec3> x0, std::span<const Vec3> x1,
                         std::span<const double> group_inflation, ThreadPool& pool) {
  Vec3 low = x0[points_[0]], high = low;
  double largest_motion = 0.0;
  for (const int32_t v : points_) {
    const Vec3& p = x0[v];
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
    if (is_moving_) largest_motion = std::max(largest_motion, max_abs(x1[v] - p));
  }
  const Vec3 origin = (low + high) * 0.5;
  // Covers the rounding of the differences below, which is relative to the distance from the origin; of boxes
  // that move also that of the sums and differences in single precision, four for each pair.
  double reach = max_abs(high - low), slack = 1e-15 * reach;
  for (const double r : group_inflation) reach = std::max(reach, max_abs(high - low) + 2.0 * r);
  if (is_moving_) slack += 0x1p-24 * (reach + 3.0 * largest_motion);
  rounding_ = bounded(static_cast<float>(0x1p-20 * (reach + largest_motion)));
  constexpr int64_t kPointGrain = 4096;
  pool.for_each_range(static_cast<int64_t>(points_.size()), kPointGrain, [&](int64_t begin, int64_t end) {
    for (int64_t k = begin; k < end; ++k) {
      const int32_t v = points_[k];
      const double r = group_inflation[mesh_.vertex_group[v]] * (1.0 + 1e-12) + slack;
      const Vec3 p = x0[v] - origin;
      vertex_boxes_[v] = {Float4{round_down(p.x - r), round_down(p.y - r), round_down(p.z - r), 0.0f},
                          Float4{round_up(p.x + r), round_up(p.y + r), round_up(p.z + r), 0.0f}};
      if (!is_moving_) continue;
      const Vec3 d = x1[v] - x0[v];
      vertex_motions_[v] = {Float4{round_down(d.x), round_down(d.y), round_down(d.z), 0.0f},
                            Float4{round_up(d.x), round_up(d.y), round_up(d.z), 0.0f}};
    }
  });
}

namespace {

void set_box(BoxNode& node, int k, const Box& box) {
  for (int axis = 0; axis < 3; ++axis) {
    node.low[axis][k] = box.low[axis];
    node.high[axis][k] = box.high[axis];
  }
}

Box node_bounds(const BoxNode& node) {
  Box box = kEmptyBox;
  for (int axis = 0; axis < 3; ++axis) {
    for (int k = 0; k < kWidth; ++k) {
      box.low[axis] = std::min<float>(box.low[axis], node.low[axis][k]);
      box.high[axis] = std::max<float>(box.high[axis], node.high[axis][k]);
    }
  }
  return box;
}

}  // namespace

void Bvh::refit_leaves(int64_t begin, int64_t end) {
  for (int64_t leaf = begin; leaf < end; ++leaf) {
    for (int k = 0; k < kWidth; ++k) {
      const Cell& cell = cells_[kWidth * leaf + k];
      const bool used = cell.triangle >= 0 || cell.point_count + cell.edge_count > 0;
      if (!is_moving_) {
        set_box(nodes_[leaf], k, used ? cell_extent<Box>(cell) : kEmptyBox);
        continue;
      }
      const MovingBox box = used ? cell_extent<MovingBox>(cell) : MovingBox{kEmptyBox, kEmptyBox};
      set_box(nodes_[leaf], k, box.start);
      set_box(motion_nodes_[leaf], k, box.motion);
    }
  }
}

double Bvh::leaf_size(const Tree& tree) const {
  double size = 0.0;
  for (int32_t leaf = 0; leaf < tree.level_size[0]; ++leaf) {
    const Box box = node_bounds(nodes_[tree.level_begin[0] + leaf]);
    for (int axis = 0; axis < 3; ++axis) size += static_cast<double>(box.high[axis]) - box.low[axis];
  }
  return size;
}

void Bvh::refit_upper_levels(const Tree& tree, std::vector<BoxNode>& nodes) const {
  for (int level = 1; level < tree.level_count; ++level) {
    for (int32_t n = 0; n < tree.level_size[level]; ++n) {
      for (int k = 0; k < kWidth; ++k) {
        const int32_t child = kWidth * n + k;
        const bool used = child < tree.level_size[level - 1];
        set_box(nodes[tree.level_begin[level] + n], k,
                used ? node_bounds(nodes[tree.level_begin[level - 1] + child]) : kEmptyBox);
      }
    }
  }
}

void Bvh::mark_moved(const Tree& tree) {
  const auto has_moved = [&](const Cell& cell) {
    return moved_[cell.vertices[0]] | moved_[cell.vertices[1]] | moved_[cell.vertices[2]];
  };
  for (int level = 0; level < tree.level_count; ++level) {
    const int32_t count = level == 0 ? tree.cell_count : tree.level_size[level - 1];
    for (int32_t n = 0; n < tree.level_size[level]; ++n) {
      uint8_t& mask = moved_nodes_[tree.level_begin[level] + n];
      mask = kAll;
      if (moved_.empty()) continue;
      mask = 0;
      for (int32_t child = kWidth * n; child < std::min(kWidth * (n + 1), count); ++child) {
        const bool moved = level == 0 ? has_moved(cells_[tree.cell_begin + child]) != 0
                                      : moved_nodes_[tree.level_begin[level - 1] + child] != 0;
        mask |= static_cast<uint8_t>(moved << (child - kWidth * n));
      }
    }
  }
}

// Of a group of one leaf there is nothing to save.
bool Bvh::is_large(const Cell& cell, const Box& box, const Tree& other) const {
  const Box& bounds = other.extent.start;
  return cell.triangle >= 0 && other.level_count > 1 &&
         sum(box.high - box.low) > kLargePart * sum(bounds.high - bounds.low);
}

void Bvh::find_tasks(const PairFilter& filter) {
  tasks_.clear();
  task_begin_.assign(1, 0);
  int32_t work = 0;
  const auto add = [&](int32_t a, int32_t b) {
    // The smaller group's leaves are looked up in the larger group's tree; few leaves against a large tree (a
    // floor of two triangles under a big cloth) are split by its subtrees instead, to keep all threads busy.
    if (trees_[a].level_size[0] > trees_[b].level_size[0]) std::swap(a, b);
    const Tree &small = trees_[a], &large = trees_[b];
    const int32_t size = small.level_size[0];
    const bool by_subtrees = size < kLeavesPerTask && large.level_count > 3;
    const int32_t level = large.level_count - (by_subtrees ? 3 : 1);
    for (int32_t node = 0; node < large.level_size[level]; ++node) {
      for (int32_t begin = 0; begin < size; begin += kLeavesPerTask) {
        const int32_t end = std::min(size, begin + kLeavesPerTask);
        tasks_.push_back({a, b, begin, end, level, node});
        work += by_subtrees ? kLeavesPerTask : end - begin;
        if (work >= kLeavesPerTask) {
          task_begin_.push_back(static_cast<int32_t>(tasks_.size()));
          work = 0;
        }
      }
    }
  };
  order_.clear();
  Box all = kEmptyBox;
  for (int32_t g = 0; g < group_count(); ++g) {
    if (trees_[g].cell_count == 0) continue;
    if (trees_[g].has_moved && filter.allowed(g, g)) add(g, g);
    order_.push_back(g);
    all = merge(all, trees_[g].bounds);
  }
  int axis = 0;
  for (int k = 1; k < 3; ++k) {
    if (all.high[k] - all.low[k] > all.high[axis] - all.low[axis]) axis = k;
  }
  std::sort(order_.begin(), order_.end(), [&](int32_t i, int32_t j) {
    const float a = trees_[i].bounds.low[axis], b = trees_[j].bounds.low[axis];
    return a != b ? a < b : i < j;
  });
  for (size_t i = 0; i < order_.size(); ++i) {
    const Box& box = trees_[order_[i]].bounds;
    for (size_t j = i + 1; j < order_.size() && trees_[order_[j]].bounds.low[axis] <= box.high[axis]; ++j) {
      const bool has_moved = trees_[order_[i]].has_moved || trees_[order_[j]].has_moved;
      if (has_moved && box.overlaps(trees_[order_[j]].bounds) && filter.allowed(order_[i], order_[j]))
        add(order_[i], order_[j]);
    }
  }
  if (task_begin_.back() != static_cast<int32_t>(tasks_.size())) {
    task_begin_.push_back(static_cast<int32_t>(tasks_.size()));
  }
}

}  // namespace stark::detail
