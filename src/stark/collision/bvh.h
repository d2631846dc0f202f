// Bounding volume hierarchies of all groups in flat arrays, for the broad phase and the intersection test;
// not part of the public interface. A cell is a triangle, an edge without triangles or a point without edges;
// every vertex and edge is owned by exactly one cell, so one tree serves all kinds of pairs and finds each
// pair once. Cells are ordered by recursive median splits so that any 8^k consecutive ones are compact; the
// tree is then implicit and 8-wide: a node holds the boxes of eight children, level 0 those of eight cells.
// Boxes are single precision about a common origin, rounded outwards.
//
// Primitives that move have two boxes, that of their start and that of their displacements. Two of them can
// meet only if the first box of one overlaps that of the other, stretched by the range of their relative
// displacements: what moves along with its neighbours, a cloth that spins or falls, finds as few pairs as if
// it stood still.
#pragma once

#include <algorithm>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include <stark/base/thread_pool.h>
#include <stark/collision/candidates.h>

namespace stark::detail {

inline constexpr int kWidth = 8;
using Float4 = float __attribute__((vector_size(16)));
using Int4 = int32_t __attribute__((vector_size(16)));
using Float8 = float __attribute__((vector_size(32)));
using Int8 = int32_t __attribute__((vector_size(32)));

/// Eight boxes, structure of arrays.
struct alignas(64) BoxNode {
  Float8 low[3], high[3];
};

/// One box; the fourth components are 0.
struct Box {
  Float4 low, high;

  bool overlaps(const Box& b) const {
    const Int4 inside = (low <= b.high) & (b.low <= high);
#if defined(__SSE__)
    return __builtin_ia32_movmskps(reinterpret_cast<Float4>(inside)) == 15;
#else
    return (inside[0] & inside[1] & inside[2]) != 0;
#endif
  }
};

inline Float4 min(const Float4& a, const Float4& b) { return a < b ? a : b; }
inline Float4 max(const Float4& a, const Float4& b) { return a > b ? a : b; }

inline Box merge(const Box& a, const Box& b) { return {min(a.low, b.low), max(a.high, b.high)}; }

/// Where something is at the start, and the range of displacements of its points.
struct MovingBox {
  Box start, motion;

  bool overlaps(const MovingBox& b) const {
    const Float4 zero{};
    return start.overlaps({b.start.low + min(b.motion.low - motion.high, zero),
                           b.start.high + max(b.motion.high - motion.low, zero)});
  }
};

inline MovingBox merge(const MovingBox& a, const MovingBox& b) {
  return {merge(a.start, b.start), merge(a.motion, b.motion)};
}

struct Cell {
  Index3 vertices;        // repeated for edges and points
  int32_t triangle = -1;  // -1 for edges and points
  int32_t point_count = 0, edge_count = 0;
  Index3 points{};  // owned vertices
  Index3 edges{};   // owned edges
  Index2 edge_vertices[3]{};
  bool is_point() const { return vertices[0] == vertices[1]; }
};

/// Bit k set where box k of the node overlaps the box.
int overlap_mask(const BoxNode& node, const Box& box);

/// The same of boxes that move; `motion`: displacements of those of the node.
int overlap_mask(const BoxNode& start, const BoxNode& motion, const MovingBox& box);

class Bvh {
 public:
  /// Throws InvalidMesh for inconsistent input.
  void reset(SurfaceMesh mesh, int32_t group_count);

  const SurfaceMesh& mesh() const { return mesh_; }
  int32_t group_count() const { return static_cast<int32_t>(trees_.size()); }

  /// Boxes of all primitives at x, inflated by the group's value. Rebuilds the trees of groups whose leaves
  /// have grown too much since they were built.
  void refit(std::span<const Vec3> x, std::span<const double> group_inflation, ThreadPool& pool) {
    refit(x, x, group_inflation, pool, false);
  }

  /// The same for linear motion from x0 to x1.
  void refit(std::span<const Vec3> x0, std::span<const Vec3> x1, std::span<const double> group_inflation,
             ThreadPool& pool) {
    refit(x0, x1, group_inflation, pool, true);
  }

  /// Calls body(thread, cell_a, cell_b, same_group) for all pairs of cells whose boxes overlap, each pair
  /// once, in groups that the filter allows. Order unspecified; on several threads. Extent: Box, or MovingBox
  /// after a refit for motion.
  template <typename Extent, typename Body>
  void for_each_pair(const PairFilter& filter, ThreadPool& pool, Body&& body);

  template <typename Extent>
  Extent vertex_extent(int32_t vertex) const;
  template <typename Extent>
  Extent edge_extent(const Index2& edge) const {
    return merge(vertex_extent<Extent>(edge[0]), vertex_extent<Extent>(edge[1]));
  }
  template <typename Extent>
  Extent cell_extent(const Cell& cell) const {
    return merge(merge(vertex_extent<Extent>(cell.vertices[0]), vertex_extent<Extent>(cell.vertices[1])),
                 vertex_extent<Extent>(cell.vertices[2]));
  }

 private:
  static constexpr int kMaxLevels = 11;
  struct Tree {
    int32_t cell_begin = 0, cell_count = 0;  // cell_begin is a multiple of kWidth
    int32_t level_count = 0;                 // 0 for a group without primitives
    int32_t level_begin[kMaxLevels] = {};    // node numbers
    int32_t level_size[kMaxLevels] = {};
    double built_size = -1.0;  // sum of leaf extents when built; < 0: not built yet
    MovingBox extent{};        // of all of it
    Box bounds{};              // of all its way
  };
  // Leaf blocks [begin, end) of group a against the subtree of group b under a node.
  struct Task {
    int32_t a, b, begin, end, level, node;
  };

  void make_cells(int32_t group_count);
  void build(Tree& tree, std::span<const Vec3> x);
  void refit(std::span<const Vec3> x0, std::span<const Vec3> x1, std::span<const double> group_inflation,
             ThreadPool& pool, bool is_moving);
  void refit_vertices(std::span<const Vec3> x0, std::span<const Vec3> x1,
                      std::span<const double> group_inflation, ThreadPool& pool);
  void refit_leaves(int64_t begin, int64_t end);
  void refit_upper_levels(const Tree& tree, std::vector<BoxNode>& nodes) const;
  double leaf_size(const Tree& tree) const;
  void find_tasks(const PairFilter& filter);
  Box root_box(const Tree& tree, const std::vector<BoxNode>& nodes) const;
  template <typename Extent, typename Body>
  void run_task(const Task& task, int thread, Body& body);
  template <typename Extent>
  int node_mask(int32_t node, const Extent& query) const;

  SurfaceMesh mesh_;
  std::vector<int32_t> points_;        // all collision points, sorted
  std::vector<Cell> cells_;            // per group in tree order, padded to a multiple of kWidth
  std::vector<BoxNode> nodes_;         // level 0 of all groups first: node k holds cells 8 k ...
  std::vector<BoxNode> motion_nodes_;  // displacements, where there are any
  std::vector<Tree> trees_;
  std::vector<Box> vertex_boxes_, vertex_motions_;
  bool is_moving_ = false;
  std::vector<Task> tasks_;
  std::vector<int32_t> task_begin_;  // tasks of one unit of parallel work
  std::vector<int32_t> order_;       // groups along the sweep axis
  int64_t leaf_count_ = 0;
};

template <typename Extent>
Extent Bvh::vertex_extent(int32_t vertex) const {
  if constexpr (std::is_same_v<Extent, Box>)
    return vertex_boxes_[vertex];
  else
    return {vertex_boxes_[vertex], vertex_motions_[vertex]};
}

template <typename Extent>
int Bvh::node_mask(int32_t node, const Extent& query) const {
  if constexpr (std::is_same_v<Extent, Box>)
    return overlap_mask(nodes_[node], query);
  else
    return overlap_mask(nodes_[node], motion_nodes_[node], query);
}

inline int lane_mask(const Int8& inside) {
#if defined(__AVX__)
  return __builtin_ia32_movmskps256(reinterpret_cast<Float8>(inside));
#else
  int mask = 0;
  for (int k = 0; k < kWidth; ++k) mask |= (inside[k] & 1) << k;
  return mask;
#endif
}

inline int overlap_mask(const BoxNode& node, const Box& box) {
  Int8 inside = (node.low[0] <= box.high[0]) & (node.high[0] >= box.low[0]);
  inside &= (node.low[1] <= box.high[1]) & (node.high[1] >= box.low[1]);
  inside &= (node.low[2] <= box.high[2]) & (node.high[2] >= box.low[2]);
  return lane_mask(inside);
}

inline int overlap_mask(const BoxNode& start, const BoxNode& motion, const MovingBox& box) {
  const Float8 zero{};
  Int8 inside = zero == zero;
  for (int axis = 0; axis < 3; ++axis) {
    const Float8 back = motion.low[axis] - box.motion.high[axis];
    const Float8 forth = motion.high[axis] - box.motion.low[axis];
    inside &= start.low[axis] + (back < zero ? back : zero) <= box.start.high[axis];
    inside &= start.high[axis] + (forth > zero ? forth : zero) >= box.start.low[axis];
  }
  return lane_mask(inside);
}

template <typename Extent, typename Body>
void Bvh::for_each_pair(const PairFilter& filter, ThreadPool& pool, Body&& body) {
  find_tasks(filter);
  if (task_begin_.size() < 2) return;
  pool.for_each_task(static_cast<int64_t>(task_begin_.size()) - 1, [&](int64_t unit, int thread) {
    for (int32_t k = task_begin_[unit]; k < task_begin_[unit + 1]; ++k)
      run_task<Extent>(tasks_[k], thread, body);
  });
}

template <typename Extent, typename Body>
void Bvh::run_task(const Task& task, int thread, Body& body) {
  const Tree &a = trees_[task.a], &b = trees_[task.b];
  const bool self = task.a == task.b;
  struct Entry {
    int32_t level, node;
  };
  Entry stack[kMaxLevels * kWidth];
  Extent boxes[kWidth];
  Extent bounds;  // of all of b
  if constexpr (std::is_same_v<Extent, Box>)
    bounds = b.extent.start;
  else
    bounds = b.extent;
  for (int32_t leaf_a = task.begin; leaf_a < task.end; ++leaf_a) {
    const Cell* cells_a = &cells_[a.cell_begin + kWidth * leaf_a];
    const int count_a = std::min(kWidth, a.cell_count - kWidth * leaf_a);
    Extent query = boxes[0] = cell_extent<Extent>(cells_a[0]);
    for (int k = 1; k < count_a; ++k) query = merge(query, boxes[k] = cell_extent<Extent>(cells_a[k]));
    if (!self && !query.overlaps(bounds)) continue;
    int stack_size = 0;
    stack[stack_size++] = {task.level, task.node};
    while (stack_size > 0) {
      const Entry entry = stack[--stack_size];
      const int32_t node = b.level_begin[entry.level] + entry.node;
      int mask = node_mask(node, query);
      if (entry.level > 0) {
        const int below = entry.level - 1;
        for (; mask != 0; mask &= mask - 1) {
          const int32_t child = kWidth * entry.node + __builtin_ctz(static_cast<unsigned>(mask));
          // Within a group each pair of leaves is visited from the lower one.
          if (self && (((child + 1) << (3 * below)) <= leaf_a)) continue;
          stack[stack_size++] = {below, child};
        }
        continue;
      }
      const Cell* cells_b = &cells_[b.cell_begin + kWidth * entry.node];
      const bool same_leaf = self && entry.node == leaf_a;
      for (int k = 0; k < count_a; ++k) {
        int hits = node_mask(node, boxes[k]);
        if (same_leaf) hits &= ~((2 << k) - 1);
        for (; hits != 0; hits &= hits - 1) {
          body(thread, cells_a[k], cells_b[__builtin_ctz(static_cast<unsigned>(hits))], self);
        }
      }
    }
  }
}

}  // namespace stark::detail
