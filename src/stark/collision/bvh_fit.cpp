// Bounds of groups, boxes of vertices and nodes at the positions of a refit. See bvh.h.
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include <stark/base/error.h>
#include <stark/collision/bvh.h>

namespace stark::detail {

namespace {

// A tree is built anew when the sum of its leaves' extents has grown by this factor.
constexpr double kRebuildGrowth = 2.0;

constexpr int32_t kPointGrain = 4096;

// The origin of boxes is a multiple of this part of a power of two above the size of all: what rests keeps
// its boxes while other things move a little.
constexpr double kOriginGrid = 0.125;

// Boxes of what rests are enlarged by so many times the rounding of moving boxes, and kept up to so many.
constexpr double kRoomyRounding = 8.0, kLoosestRounding = 64.0;

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

Box round_outward(const Bounds& bounds) {
  const Vec3 &low = bounds.low, &high = bounds.high;
  return {Float4{round_down(low.x), round_down(low.y), round_down(low.z), 0.0f},
          Float4{round_up(high.x), round_up(high.y), round_up(high.z), 0.0f}};
}

// Of what is within `bounds`, about the origin and enlarged by r.
Box box_of(const Bounds& bounds, const Vec3& origin, double r) {
  return round_outward(enlarged({bounds.low - origin, bounds.high - origin}, r));
}

// The nearest point of a grid whose cells are a power of two from `least` [m] on.
Vec3 round_to_grid(const Vec3& point, double least) {
  const double cell = std::exp2(std::ceil(std::log2(least)));
  if (!(cell > 0.0)) return point;
  return {std::round(point.x / cell) * cell, std::round(point.y / cell) * cell,
          std::round(point.z / cell) * cell};
}

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

void Bvh::make_chunks() {
  chunks_.clear();
  const auto count = static_cast<int32_t>(points_.size());
  for (int32_t begin = 0; begin < count;) {
    const int32_t group = mesh_.vertex_group[points_[begin]];
    int32_t end = begin;
    while (end < std::min(count, begin + kPointGrain) && mesh_.vertex_group[points_[end]] == group) ++end;
    Tree& tree = trees_[group];
    if (tree.chunk_end == 0) tree.chunk_begin = static_cast<int32_t>(chunks_.size());
    chunks_.push_back({group, begin, end});
    tree.chunk_end = static_cast<int32_t>(chunks_.size());
    begin = end;
  }
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
  x0_ = x0;
  x1_ = x1;
  inflation_ = group_inflation;
  is_moving_ = is_moving;
  moved_.assign(moved.begin(), moved.end());
  if (points_.empty()) return;
  find_resting();
  pool.for_each_task(static_cast<int64_t>(chunks_.size()), [&](int64_t k, int) { bound(chunks_[k]); });
  set_precision();
  bound_groups();
  note_motion();
}

// The four sites of a frame tell whether its group is where it was: all others follow, up to rounding that
// the boxes allow for.
void Bvh::find_resting() {
  for (int32_t g = 0; g < group_count(); ++g) {
    const GroupFrame* frame = mesh_.frame_of(g);
    if (frame == nullptr) continue;
    Tree& tree = trees_[g];
    bool stands = true, rests = true;
    for (size_t k = 0; k < frame->sites.size(); ++k) {
      const int32_t site = frame->sites[k];
      stands &= tree.fit.sites[k] == x0_[site];
      rests &= x1_[site] == x0_[site];
      tree.fit.sites[k] = x0_[site];
    }
    if (!stands) {
      tree.is_tight = false;
      tree.fit.radius = -1.0;
    }
    tree.is_at_rest = is_moving_ ? rests : stands;
  }
}

void Bvh::bound(Chunk& chunk) const {
  chunk.motion = chunk.from_clear = chunk.to_clear = {};
  if (const GroupFrame* frame = mesh_.frame_of(chunk.group)) {
    bound_piece(*frame, chunk);
    return;
  }
  chunk.place = {};
  chunk.has_moved = moved_.empty();
  const bool has_clearances = !clearances_.empty();
  for (int32_t k = chunk.begin; k < chunk.end; ++k) {
    const int32_t v = points_[k];
    chunk.place.add(x0_[v]);
    if (!moved_.empty() && moved_[v] != 0) chunk.has_moved = true;
    if (is_moving_) chunk.motion.add(x1_[v] - x0_[v]);
    if (!has_clearances) continue;
    chunk.from_clear.add(x0_[v] - clear_at_[v]);
    if (is_moving_) chunk.to_clear.add(x1_[v] - clear_at_[v]);
  }
}

// Bounds of a frame are wider than those of its points. What has not moved gets these where they are needed.
void Bvh::bound_piece(const GroupFrame& frame, Chunk& chunk) const {
  chunk.has_moved = moved_.empty() || moved_[frame.sites[0]] != 0;
  if (!trees_[chunk.group].is_tight) {
    if (chunk.has_moved)
      add_places(chunk);
    else
      chunk.place = frame.bound(x0_);
  }
  if (is_moving_) chunk.motion = frame.bound_motion(x0_, x1_);
  if (clearances_.empty()) return;
  chunk.from_clear = frame.bound_motion(clear_at_, x0_);
  if (is_moving_) chunk.to_clear = frame.bound_motion(clear_at_, x1_);
}

void Bvh::add_places(Chunk& chunk) const {
  chunk.place = {};
  for (int32_t k = chunk.begin; k < chunk.end; ++k) chunk.place.add(x0_[points_[k]]);
}

void Bvh::tighten(int32_t group) {
  Tree& tree = trees_[group];
  if (tree.is_tight) return;
  tree.is_tight = true;
  for (int32_t c = tree.chunk_begin; c < tree.chunk_end; ++c) add_places(chunks_[c]);
  bound_group(tree);
}

// Where boxes are measured from, and what rounding adds to them.
void Bvh::set_precision() {
  Bounds all;
  double largest_motion = 0.0;
  for (const Chunk& chunk : chunks_) {
    all.add(chunk.place);
    if (is_moving_)
      largest_motion = std::max({largest_motion, max_abs(chunk.motion.low), max_abs(chunk.motion.high)});
  }
  origin_ = round_to_grid((all.low + all.high) * 0.5, kOriginGrid * max_abs(all.high - all.low));
  // Covers the rounding of the differences below, which is relative to the distance from the origin; of boxes
  // that move also that of the sums and differences in single precision, four for each pair.
  double reach = 2.0 * std::max(max_abs(all.low - origin_), max_abs(all.high - origin_));
  slack_ = 1e-15 * reach;
  reach += 2.0 * std::ranges::max(inflation_);
  swept_slack_ = slack_ + 0x1p-24 * (reach + 3.0 * largest_motion);
  if (is_moving_) slack_ = swept_slack_;
  rounding_ = bounded(static_cast<float>(0x1p-20 * (reach + largest_motion)));
}

double Bvh::find_radius(int32_t group) const {
  const Tree& tree = trees_[group];
  const double inflation = inflation_[group] * (1.0 + 1e-12), least = inflation + slack_;
  if (!tree.is_at_rest) return least;
  const Fit& fit = tree.fit;
  const double most = inflation + kLoosestRounding * swept_slack_;
  return fit.radius >= least && fit.radius <= most ? fit.radius : inflation + kRoomyRounding * swept_slack_;
}

bool Bvh::is_kept(const Tree& tree) const {
  return tree.is_at_rest && tree.fit.radius == tree.radius && tree.fit.origin == origin_ &&
         (!is_moving_ || tree.fit.has_zero_motion);
}

void Bvh::bound_groups() {
  for (int32_t g = 0; g < group_count(); ++g) {
    Tree& tree = trees_[g];
    tree.is_fitted = false;
    tree.has_moved = moved_.empty();
    for (int32_t k = tree.chunk_begin; k < tree.chunk_end; ++k) tree.has_moved |= chunks_[k].has_moved;
    tree.is_tight |= tree.has_moved;
    tree.radius = find_radius(g);
    bound_group(tree);
  }
}

void Bvh::bound_group(Tree& tree) const {
  tree.extent = {kEmptyBox, kEmptyBox};
  for (int32_t k = tree.chunk_begin; k < tree.chunk_end; ++k) {
    tree.extent.start = merge(tree.extent.start, box_of(chunks_[k].place, origin_, tree.radius));
    if (is_moving_) tree.extent.motion = merge(tree.extent.motion, round_outward(chunks_[k].motion));
  }
  tree.bounds = tree.extent.start;
  if (!is_moving_ || tree.cell_count == 0) return;
  tree.bounds.low += min(tree.extent.motion.low, Float4{});
  tree.bounds.high += max(tree.extent.motion.high, Float4{});
}

// Brings clearances up to date, or notes what the way from here will take of them.
void Bvh::note_motion() {
  from_clear_.clear();
  to_clear_.clear();
  if (clearances_.empty()) return;
  from_clear_.resize(trees_.size());
  to_clear_.resize(trees_.size());
  for (const Chunk& chunk : chunks_) {
    const double r = slack_ + 1e-15 * std::max(max_abs(chunk.place.low), max_abs(chunk.place.high));
    from_clear_[chunk.group].add(enlarged(chunk.from_clear, r));
    if (is_moving_) to_clear_[chunk.group].add(enlarged(chunk.to_clear, r));
  }
  if (is_moving_) return;
  clearances_.move(from_clear_);
  from_clear_.clear();
  to_clear_.clear();
  note_places();
}

void Bvh::note_places() {
  for (const Chunk& chunk : chunks_) {
    const GroupFrame* frame = mesh_.frame_of(chunk.group);
    const std::span<const int32_t> all(points_.data() + chunk.begin, points_.data() + chunk.end);
    for (const int32_t v : frame != nullptr ? std::span<const int32_t>(frame->sites) : all)
      clear_at_[v] = x0_[v];
  }
}

void Bvh::fit_trees(ThreadPool& pool) {
  std::vector<int32_t> groups;
  std::vector<Tree*> trees;                         // those of them that are not kept
  std::vector<int32_t> vertices;                    // chunks of them
  std::vector<std::pair<int32_t, int32_t>> leaves;  // ranges
  for (const Task& task : tasks_) {
    for (const int32_t group : {task.a, task.b}) {
      Tree* tree = &trees_[group];
      if (tree->is_fitted) continue;
      tree->is_fitted = true;
      groups.push_back(group);
      if (is_kept(*tree)) continue;
      trees.push_back(tree);
      for (int32_t k = tree->chunk_begin; k < tree->chunk_end; ++k) vertices.push_back(k);
      constexpr int32_t kLeafGrain = 512;
      for (int32_t begin = 0; begin < tree->level_size[0]; begin += kLeafGrain)
        leaves.emplace_back(tree->level_begin[0] + begin,
                            tree->level_begin[0] + std::min(begin + kLeafGrain, tree->level_size[0]));
    }
  }
  fitted_ = static_cast<int32_t>(trees.size());
  const auto for_each = [&](const auto& items, auto&& body) {
    pool.for_each_task(static_cast<int64_t>(items.size()), [&](int64_t k, int) { body(items[k]); });
  };
  for_each(vertices, [&](int32_t chunk) { fit_vertices(chunks_[chunk]); });
  for_each(trees, [&](Tree* tree) {
    if (tree->built_size < 0.0) build(*tree);
  });
  for_each(leaves, [&](const auto& range) { refit_leaves(range.first, range.second); });
  for_each(trees, [&](Tree* tree) { finish_fit(*tree); });
  for_each(groups, [&](int32_t group) { mark_moved(group); });
}

void Bvh::finish_fit(Tree& tree) {
  const double size = leaf_size(tree);
  if (tree.built_size < 0.0) {
    tree.built_size = size;
  } else if (size > kRebuildGrowth * tree.built_size && tree.level_count > 1) {
    build(tree);
    refit_leaves(tree.level_begin[0], tree.level_begin[0] + tree.level_size[0]);
    tree.built_size = leaf_size(tree);
  }
  refit_upper_levels(tree, nodes_);
  if (is_moving_) refit_upper_levels(tree, motion_nodes_);
  tree.fit.origin = origin_;
  tree.fit.radius = tree.radius;
  if (is_moving_) tree.fit.has_zero_motion = tree.is_at_rest;
}

void Bvh::fit_vertices(const Chunk& chunk) {
  const double r = trees_[chunk.group].radius;
  for (int32_t k = chunk.begin; k < chunk.end; ++k) {
    const int32_t v = points_[k];
    vertex_boxes_[v] = box_of({x0_[v], x0_[v]}, origin_, r);
    if (!is_moving_) continue;
    const Vec3 d = x1_[v] - x0_[v];
    vertex_motions_[v] = round_outward({d, d});
  }
}

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

// Most groups have moved as a whole or not at all, and often as at the last refit.
void Bvh::mark_moved(int32_t group) {
  Tree& tree = trees_[group];
  const bool is_part = tree.has_moved && !moved_.empty() && mesh_.frame_of(group) == nullptr;
  const int32_t mask = is_part ? -1 : tree.has_moved ? kAll : 0;
  if (is_part) {
    mark_parts_moved(tree);
  } else if (mask != tree.moved_mask) {
    for (int level = 0; level < tree.level_count; ++level)
      std::fill_n(moved_nodes_.begin() + tree.level_begin[level], tree.level_size[level],
                  static_cast<uint8_t>(mask));
  }
  tree.moved_mask = mask;
}

void Bvh::mark_parts_moved(const Tree& tree) {
  const auto has_moved = [&](const Cell& cell) {
    return moved_[cell.vertices[0]] | moved_[cell.vertices[1]] | moved_[cell.vertices[2]];
  };
  for (int level = 0; level < tree.level_count; ++level) {
    const int32_t count = level == 0 ? tree.cell_count : tree.level_size[level - 1];
    for (int32_t n = 0; n < tree.level_size[level]; ++n) {
      uint8_t& mask = moved_nodes_[tree.level_begin[level] + n];
      mask = 0;
      for (int32_t child = kWidth * n; child < std::min(kWidth * (n + 1), count); ++child) {
        const bool moved = level == 0 ? has_moved(cells_[tree.cell_begin + child]) != 0
                                      : moved_nodes_[tree.level_begin[level - 1] + child] != 0;
        mask |= static_cast<uint8_t>(moved << (child - kWidth * n));
      }
    }
  }
}

}  // namespace stark::detail
