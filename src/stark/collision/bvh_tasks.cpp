// Pairs of groups by sweeping, as tasks, and how far those are apart that have no pair. See bvh.h.
#include <algorithm>
#include <array>
#include <cmath>

#include <stark/collision/bvh.h>

namespace stark::detail {

namespace {

// A triangle is large beside a group when the sides of its box sum to this part of those of the group's box.
constexpr float kLargePart = 0.25f;
// Leaf blocks per unit of parallel work.
constexpr int32_t kLeavesPerTask = 64;
// Nodes that the search for a gap opens; beyond, what it has left open bounds it.
constexpr int kOpenedNodes = 2000;
constexpr float kGapRounding = 1e-6f;  // relative
constexpr float kLargestGap = 1e15f;   // [m] that is worth remembering; its square is a float

// Squared distances of the eight boxes from a box [m^2].
Float8 squared_gaps(const BoxNode& node, const Box& box) {
  Float8 sum{};
  for (int axis = 0; axis < 3; ++axis) {
    const Float8 above = node.low[axis] - box.high[axis], below = box.low[axis] - node.high[axis];
    const Float8 gap = above > below ? above : below;
    const Float8 positive = gap > Float8{} ? gap : Float8{};
    sum += positive * positive;
  }
  return sum;
}

Box box_in(const BoxNode& node, int k) {
  Box box{};
  for (int axis = 0; axis < 3; ++axis) {
    box.low[axis] = node.low[axis][k];
    box.high[axis] = node.high[axis][k];
  }
  return box;
}

}  // namespace

// Of a group of one leaf there is nothing to save.
bool Bvh::is_large(const Cell& cell, const Box& box, const Tree& other) const {
  const Box& bounds = other.extent.start;
  return cell.triangle >= 0 && other.level_count > 1 &&
         sum(box.high - box.low) > kLargePart * sum(bounds.high - bounds.low);
}

int Bvh::large_mask(int32_t node, const Tree& other) const {
  if (other.level_count < 2) return 0;
  const BoxNode& boxes = nodes_[node];
  Float8 size{};
  for (int axis = 0; axis < 3; ++axis) size += boxes.high[axis] - boxes.low[axis];
  const Box& bounds = other.extent.start;
  return lane_mask(size > Float8{} + kLargePart * sum(bounds.high - bounds.low));
}

// The smaller group's leaves are looked up in the larger group's tree; few leaves against a large tree (a
// floor of two triangles under a big cloth) are split by its subtrees instead, to keep all threads busy.
void Bvh::add_tasks(int32_t a, int32_t b, int32_t& work) {
  ++looked_at_;
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
}

bool Bvh::are_clear(int32_t a, int32_t b) const {
  return clearances_.are_apart(a, b, inflation_[a] + inflation_[b], from_clear_, to_clear_);
}

void Bvh::find_tasks(const PairFilter& filter) {
  tasks_.clear();
  looked_at_ = 0;
  task_begin_.assign(1, 0);
  int32_t work = 0;
  order_.clear();
  Box all = kEmptyBox;
  for (int32_t g = 0; g < group_count(); ++g) {
    if (trees_[g].cell_count == 0) continue;
    if (trees_[g].has_moved && filter.allowed(g, g)) add_tasks(g, g, work);
    order_.push_back(g);
    all = merge(all, trees_[g].bounds);
  }
  int axis = 0;
  for (int k = 1; k < 3; ++k) {
    if (all.high[k] - all.low[k] > all.high[axis] - all.low[axis]) axis = k;
  }
  // Bounds that are tightened on the way do not change the order.
  lows_.resize(trees_.size());
  for (const int32_t g : order_) lows_[g] = trees_[g].bounds.low[axis];
  std::sort(order_.begin(), order_.end(),
            [&](int32_t i, int32_t j) { return lows_[i] != lows_[j] ? lows_[i] < lows_[j] : i < j; });
  for (size_t i = 0; i < order_.size(); ++i) {
    const Box& box = trees_[order_[i]].bounds;
    for (size_t j = i + 1; j < order_.size() && lows_[order_[j]] <= box.high[axis]; ++j) {
      const int32_t a = order_[i], b = order_[j];
      const bool has_moved = trees_[a].has_moved || trees_[b].has_moved;
      if (!has_moved || !box.overlaps(trees_[b].bounds) || !filter.allowed(a, b) || are_clear(a, b)) continue;
      tighten(a);
      tighten(b);
      if (box.overlaps(trees_[b].bounds)) add_tasks(a, b, work);
    }
  }
  if (task_begin_.back() != static_cast<int32_t>(tasks_.size())) {
    task_begin_.push_back(static_cast<int32_t>(tasks_.size()));
  }
}

void Bvh::learn_clearances(ThreadPool& pool) {
  std::vector<Index2> pairs;
  for (size_t k = 0; k < tasks_.size();) {
    const Task& first = tasks_[k];
    bool has_found = first.a == first.b;
    for (; k < tasks_.size() && tasks_[k].a == first.a && tasks_[k].b == first.b; ++k)
      has_found |= tasks_[k].has_found;
    if (!has_found) pairs.push_back({first.a, first.b});
  }
  if (pairs.empty()) return;
  std::vector<double> gaps(pairs.size());
  pool.for_each_task(static_cast<int64_t>(pairs.size()), [&](int64_t k, int) {
    gaps[k] =
        find_gap(trees_[pairs[k][0]], trees_[pairs[k][1]], inflation_[pairs[k][0]] + inflation_[pairs[k][1]]);
  });
  if (clearances_.empty()) clear_at_.assign(x0_.begin(), x0_.begin() + mesh_.vertex_count);
  for (size_t k = 0; k < pairs.size(); ++k) {
    const auto& [a, b] = pairs[k];
    if (gaps[k] > 0.0) clearances_.set(a, b, gaps[k] + inflation_[a] + inflation_[b]);
  }
}

// Least distance between boxes of cells of both groups [m], or less; 0 where it is below `worthwhile`. The
// nearest parts first: what is farther apart than cells that were found is left out.
double Bvh::find_gap(const Tree& a, const Tree& b, double worthwhile) const {
  struct Entry {
    Part parts[2];
    float squared;
  };
  const Tree* const trees[2] = {&a, &b};
  const auto least_worthwhile = static_cast<float>(worthwhile * worthwhile);
  float least = kLargestGap * kLargestGap;
  std::vector<Entry> open = {{{a.root(), b.root()}, 0.0f}};
  for (int opened = 0; !open.empty() && opened < kOpenedNodes && least > least_worthwhile; ++opened) {
    const Entry entry = open.back();
    open.pop_back();
    if (!(entry.squared < least)) continue;
    const int side = entry.parts[0].level >= entry.parts[1].level ? 0 : 1;
    const Part &part = entry.parts[side], &other = entry.parts[1 - side];
    if (part.level < 0) {  // two cells
      least = entry.squared;
      continue;
    }
    const BoxNode& node = nodes_[trees[side]->level_begin[part.level] + part.node];
    const Float8 squared = squared_gaps(node, other.box);
    std::array<int, kWidth> order{};
    int count = 0;
    for (int k = 0; k < kWidth; ++k)
      if (squared[k] < least) order[count++] = k;
    std::sort(order.begin(), order.begin() + count, [&](int i, int j) { return squared[i] > squared[j]; });
    for (int i = 0; i < count; ++i) {
      const int k = order[i];
      Entry child{{entry.parts[0], entry.parts[1]}, squared[k]};
      child.parts[side] = {part.level - 1, kWidth * part.node + k, box_in(node, k)};
      open.push_back(child);
    }
  }
  for (const Entry& entry : open) least = std::min(least, entry.squared);
  if (!(least > least_worthwhile)) return 0.0;
  return std::sqrt(least) * (1.0f - kGapRounding);
}

}  // namespace stark::detail
