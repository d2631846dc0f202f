// Bounding volume hierarchies of all groups in flat arrays, for the broad phase and the intersection test;
// not part of the public interface. A cell is a triangle, an edge without triangles or a point without edges;
// every vertex and edge is owned by exactly one cell, so one tree serves all kinds of pairs and finds each
// pair once. Cells are ordered by recursive median splits so that any 8^k consecutive ones are compact; the
// tree is then implicit and 8-wide: a node holds the boxes of eight children, level 0 those of eight cells.
// The triangles of a floor are large beside what lies on it, and the box of one that is tilted holds all of
// that: they have slabs as well.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include <stark/base/thread_pool.h>
#include <stark/collision/bounds.h>
#include <stark/collision/boxes.h>
#include <stark/collision/candidates.h>
#include <stark/collision/group_clearances.h>
#include <stark/collision/slab.h>

namespace stark::detail {

struct Cell {
  Index3 vertices;        // repeated for edges and points
  int32_t triangle = -1;  // -1 for edges and points
  int32_t point_count = 0, edge_count = 0;
  Index3 points{};  // owned vertices
  Index3 edges{};   // owned edges
  Index2 edge_vertices[3]{};
  bool is_point() const { return vertices[0] == vertices[1]; }
};

class Bvh {
 public:
  /// Throws InvalidMesh for inconsistent input.
  void reset(SurfaceMesh mesh, int32_t group_count);

  const SurfaceMesh& mesh() const { return mesh_; }
  int32_t group_count() const { return static_cast<int32_t>(trees_.size()); }

  /// Bounds of all groups at x, inflated by the group's value. for_each_pair and learn_clearances fit
  /// vertices and trees where they need them: x and group_inflation have to stay until then; trees are built
  /// anew where leaves have grown too much. moved: by vertex, not 0 where pairs of cells with it are asked
  /// for, all or none of a group with a frame; none: all are.
  void refit(std::span<const Vec3> x, std::span<const double> group_inflation, ThreadPool& pool,
             std::span<const uint8_t> moved = {}) {
    refit(x, x, group_inflation, pool, moved, false);
  }

  /// The same for linear motion from x0 to x1.
  void refit(std::span<const Vec3> x0, std::span<const Vec3> x1, std::span<const double> group_inflation,
             ThreadPool& pool, std::span<const uint8_t> moved = {}) {
    refit(x0, x1, group_inflation, pool, moved, true);
  }

  /// Calls body(thread, cell_a, cell_b, same_group) for all pairs of cells whose boxes overlap, each pair
  /// once, in groups that the filter allows, but for those of which neither has moved, those that the slab
  /// of a triangle that is large beside the other group keeps apart, and those of groups that are known to
  /// keep clear of each other. Order unspecified; on several threads.
  /// Extent: Box, or MovingBox after a refit for motion.
  template <typename Extent, typename Body>
  void for_each_pair(const PairFilter& filter, ThreadPool& pool, Body&& body);

  /// After a refit at rest and for_each_pair: measures how far the groups are apart that were looked at and
  /// have no such pair. Later refits leave them out until their motion has used that up.
  void learn_clearances(ThreadPool& pool);
  /// How many pairs of groups the last for_each_pair has looked at.
  int32_t looked_at() const { return looked_at_; }
  /// How many trees the last for_each_pair has fitted anew; that of a group with a frame that rests is kept.
  int32_t fitted() const { return fitted_; }
  /// What boxes are measured from [m].
  const Vec3& origin() const { return origin_; }

  /// Of groups that the last for_each_pair has looked at.
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
  static constexpr int kAll = (1 << kWidth) - 1;
  // Some cells of a group: those of a node, or one.
  struct Part {
    int32_t level, node;  // level -1: cell
    Box box;
  };
  // What the boxes of a group with a frame are of: they stay while nothing of it changes.
  struct Fit {
    std::array<Vec3, 4> sites{};  // of the frame, at the last refit [m]
    Vec3 origin{};
    double radius = -1.0;          // [m]; < 0: boxes are of another place
    bool has_zero_motion = false;  // displacements of all boxes
  };
  struct Tree {
    int32_t cell_begin = 0, cell_count = 0;  // cell_begin is a multiple of kWidth
    int32_t level_count = 0;                 // 0 for a group without primitives
    int32_t level_begin[kMaxLevels] = {};    // node numbers
    int32_t level_size[kMaxLevels] = {};
    int32_t chunk_begin = 0, chunk_end = 0;  // of its points
    double built_size = -1.0;                // sum of leaf extents when built; < 0: not built yet
    bool is_fitted = false;                  // vertices and nodes are those of the last refit
    bool is_tight = true;                    // bounds are those of its points, not of its frame
    bool has_moved = true;                   // some of it
    bool is_at_rest = false;                 // has a frame that stands where it stood, also on the way
    int32_t moved_mask = kAll;               // of each of its nodes; -1 where they differ
    double radius = 0.0;                     // by what its boxes are enlarged [m]
    Fit fit{};                               // of a group with a frame
    MovingBox extent{};                      // of all of it
    Box bounds{};                            // of all its way
    Part root() const { return {level_count - 1, 0, extent.start}; }
  };
  // Leaf blocks [begin, end) of group a against the subtree of group b under a node.
  struct Task {
    int32_t a, b, begin, end, level, node;
    bool has_found = false;
  };
  // Points [begin, end) of a group, and where the last refit has them and how they move [m].
  struct Chunk {
    int32_t group, begin, end;
    Bounds place{}, motion{};
    Bounds from_clear{}, to_clear{};  // displacements from where clearances are known, at start and end
    bool has_moved = true;
  };

  void make_cells(int32_t group_count);
  void build(Tree& tree);
  void refit(std::span<const Vec3> x0, std::span<const Vec3> x1, std::span<const double> group_inflation,
             ThreadPool& pool, std::span<const uint8_t> moved, bool is_moving);
  void make_chunks();
  void find_resting();
  void bound(Chunk& chunk) const;
  void bound_piece(const GroupFrame& frame, Chunk& chunk) const;
  void add_places(Chunk& chunk) const;
  void bound_groups();
  void bound_group(Tree& tree) const;
  void tighten(int32_t group);
  void set_precision();
  void note_motion();
  void note_places();
  void fit_trees(ThreadPool& pool);
  void fit_vertices(const Chunk& chunk);
  void finish_fit(Tree& tree);
  /// By what boxes of the group are enlarged [m].
  double find_radius(int32_t group) const;
  bool is_kept(const Tree& tree) const;
  void refit_leaves(int64_t begin, int64_t end);
  void mark_moved(int32_t group);
  void mark_parts_moved(const Tree& tree);
  void refit_upper_levels(const Tree& tree, std::vector<BoxNode>& nodes) const;
  double leaf_size(const Tree& tree) const;
  void find_tasks(const PairFilter& filter);
  void add_tasks(int32_t a, int32_t b, int32_t& work);
  bool are_clear(int32_t a, int32_t b) const;
  double find_gap(const Tree& a, const Tree& b, double worthwhile) const;
  template <typename Extent, typename Body>
  void run_task(Task& task, int thread, Body& body);
  template <typename Extent>
  int node_mask(int32_t node, const Extent& query) const;
  template <typename Extent>
  int near_mask(int32_t node, const Extent& query, const TriangleSlabs& slabs) const;
  /// Whether the box of a leaf of a tree with levels above touches bounds.
  template <typename Extent>
  bool overlaps_leaf(const Tree& tree, int32_t leaf, const Extent& bounds) const {
    return (node_mask(tree.level_begin[1] + leaf / kWidth, bounds) >> (leaf % kWidth) & 1) != 0;
  }
  template <typename Extent>
  TriangleSlabs cell_slabs(const Cell& cell) const;
  bool is_large(const Cell& cell, const Box& box, const Tree& other) const;
  /// Bit k set where the box of cell k of a leaf is that large.
  int large_mask(int32_t node, const Tree& other) const;
  template <typename Test, typename Visit>
  void descend(const Task& task, int32_t leaf_a, Test&& test, Visit&& visit) const;

  SurfaceMesh mesh_;
  std::vector<int32_t> points_;        // all collision points, by group
  std::vector<Chunk> chunks_;          // of them, by group
  std::vector<Cell> cells_;            // per group in tree order, padded to a multiple of kWidth
  std::vector<BoxNode> nodes_;         // level 0 of all groups first: node k holds cells 8 k ...
  std::vector<BoxNode> motion_nodes_;  // displacements, where there are any
  std::vector<uint8_t> moved_;         // by vertex; empty: all have
  std::vector<uint8_t> moved_nodes_;   // bit k set where some of box k has moved
  std::vector<Tree> trees_;
  std::vector<Box> vertex_boxes_, vertex_motions_;
  std::span<const Vec3> x0_, x1_;      // of the last refit
  std::span<const double> inflation_;  // by group [m]
  Vec3 origin_{};
  double slack_ = 0.0;        // rounding of boxes [m]
  double swept_slack_ = 0.0;  // of boxes that move
  bool is_moving_ = false;
  float rounding_ = 0.0f;  // of sums of products with components of a normal [m]
  GroupClearances clearances_;
  std::vector<Vec3> clear_at_;                 // where vertices were when clearances were brought up to date
  std::vector<Bounds> from_clear_, to_clear_;  // displacements from there on a way, by group; empty at rest
  std::vector<Task> tasks_;
  std::vector<RecentSlabs> recent_slabs_;  // by thread
  int32_t looked_at_ = 0, fitted_ = 0;
  std::vector<int32_t> task_begin_;  // tasks of one unit of parallel work
  std::vector<int32_t> order_;       // groups along the sweep axis
  std::vector<float> lows_;          // where their bounds begin there, by group
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

template <typename Extent, typename Body>
void Bvh::for_each_pair(const PairFilter& filter, ThreadPool& pool, Body&& body) {
  find_tasks(filter);
  if (task_begin_.size() < 2) return;
  fit_trees(pool);
  recent_slabs_.resize(static_cast<size_t>(pool.thread_count()));
  for (RecentSlabs& slabs : recent_slabs_) slabs.forget();
  pool.for_each_task(static_cast<int64_t>(task_begin_.size()) - 1, [&](int64_t unit, int thread) {
    for (int32_t k = task_begin_[unit]; k < task_begin_[unit + 1]; ++k)
      run_task<Extent>(tasks_[k], thread, body);
  });
}

template <typename Extent>
int Bvh::near_mask(int32_t node, const Extent& query, const TriangleSlabs& slabs) const {
  int mask = node_mask(node, query);
  for (const Slab& slab : slabs) {
    if (mask == 0) return 0;
    if constexpr (std::is_same_v<Extent, Box>)
      mask &= ~separated_mask(nodes_[node], slab);
    else
      mask &= ~separated_mask(nodes_[node], motion_nodes_[node], slab);
  }
  return mask;
}

template <typename Extent>
TriangleSlabs Bvh::cell_slabs(const Cell& cell) const {
  const auto& v = cell.vertices;
  return slabs_of<Extent>(
      {vertex_extent<Extent>(v[0]), vertex_extent<Extent>(v[1]), vertex_extent<Extent>(v[2])}, rounding_);
}

// Calls visit(leaf, mask) for the leaves of the other group that test(node) leaves over.
template <typename Test, typename Visit>
void Bvh::descend(const Task& task, int32_t leaf_a, Test&& test, Visit&& visit) const {
  const Tree& b = trees_[task.b];
  const bool self = task.a == task.b;
  struct Entry {
    int32_t level, node;
  };
  Entry stack[kMaxLevels * kWidth];
  int stack_size = 0;
  stack[stack_size++] = {task.level, task.node};
  while (stack_size > 0) {
    const Entry entry = stack[--stack_size];
    int mask = test(b.level_begin[entry.level] + entry.node);
    if (entry.level == 0) {
      if (mask != 0) visit(entry.node, mask);
      continue;
    }
    const int below = entry.level - 1;
    for (; mask != 0; mask &= mask - 1) {
      const int32_t child = kWidth * entry.node + __builtin_ctz(static_cast<unsigned>(mask));
      // Within a group each pair of leaves is visited from the lower one.
      if (self && (((child + 1) << (3 * below)) <= leaf_a)) continue;
      stack[stack_size++] = {below, child};
    }
  }
}

// What has not moved is looked up among what has.
template <typename Extent, typename Body>
void Bvh::run_task(Task& task, int thread, Body& body) {
  const Tree &a = trees_[task.a], &b = trees_[task.b];
  const bool self = task.a == task.b;
  Extent boxes[kWidth];
  Extent bounds;  // of all of b
  if constexpr (std::is_same_v<Extent, Box>)
    bounds = b.extent.start;
  else
    bounds = b.extent;
  for (int32_t leaf_a = task.begin; leaf_a < task.end; ++leaf_a) {
    const Cell* cells_a = &cells_[a.cell_begin + kWidth * leaf_a];
    const int count_a = std::min(kWidth, a.cell_count - kWidth * leaf_a);
    const auto pass = [&](int k, int32_t leaf_b, int hits) {
      const Cell* cells_b = &cells_[b.cell_begin + kWidth * leaf_b];
      task.has_found |= hits != 0;
      for (; hits != 0; hits &= hits - 1)
        body(thread, cells_a[k], cells_b[__builtin_ctz(static_cast<unsigned>(hits))], self);
    };
    if (!self && a.level_count > 1 && !overlaps_leaf(a, leaf_a, bounds)) continue;
    Extent query = boxes[0] = cell_extent<Extent>(cells_a[0]);
    for (int k = 1; k < count_a; ++k) query = merge(query, boxes[k] = cell_extent<Extent>(cells_a[k]));
    if (!self && !query.overlaps(bounds)) continue;
    const int moved = moved_nodes_[a.level_begin[0] + leaf_a];
    const auto partners = [&](int k, int32_t node) { return (moved >> k) & 1 ? kAll : moved_nodes_[node]; };
    int small = (1 << count_a) - 1;
    for (int left = self ? 0 : small & large_mask(a.level_begin[0] + leaf_a, b); left != 0;
         left &= left - 1) {
      const int k = __builtin_ctz(static_cast<unsigned>(left));
      if (!is_large(cells_a[k], start_of(boxes[k]), b) || !boxes[k].overlaps(bounds)) continue;
      small &= ~(1 << k);
      const TriangleSlabs slabs = cell_slabs<Extent>(cells_a[k]);
      descend(
          task, leaf_a, [&](int32_t node) { return near_mask(node, boxes[k], slabs) & partners(k, node); },
          [&](int32_t leaf_b, int hits) { pass(k, leaf_b, hits); });
    }
    if (small == 0) continue;
    descend(
        task, leaf_a,
        [&](int32_t node) { return (moved == 0 ? moved_nodes_[node] : kAll) & node_mask(node, query); },
        [&](int32_t leaf_b, int) {
          const int32_t node = b.level_begin[0] + leaf_b;
          int hits[kWidth] = {}, all = 0;
          for (int left = small; left != 0; left &= left - 1) {
            const int k = __builtin_ctz(static_cast<unsigned>(left));
            hits[k] = node_mask(node, boxes[k]) & partners(k, node);
            if (self && leaf_b == leaf_a) hits[k] &= ~((2 << k) - 1);
            all |= hits[k];
          }
          for (int large = self ? 0 : all & large_mask(node, a); large != 0; large &= large - 1) {
            const int j = __builtin_ctz(static_cast<unsigned>(large));
            const int32_t cell = b.cell_begin + kWidth * leaf_b + j;
            const TriangleSlabs& slabs =
                recent_slabs_[thread].of(cell, [&] { return cell_slabs<Extent>(cells_[cell]); });
            for (int k = 0; k < count_a; ++k)
              if (is_separated(slabs[0], boxes[k]) || is_separated(slabs[1], boxes[k])) hits[k] &= ~(1 << j);
          }
          for (int k = 0; k < count_a; ++k) pass(k, leaf_b, hits[k]);
        });
  }
}

}  // namespace stark::detail
