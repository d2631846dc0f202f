// Task split and stack layout of the update matrices.
#include <stark/linalg/front_plan.h>

#include <algorithm>

namespace stark {

namespace {

constexpr double kSubtreeShare = 1.0 / 24.0;  // largest part of the work in one subtree task
constexpr double kSubtreeFlops = 4e6;         // below this a subtree is never split (about 0.2 ms)

double front_flops(int32_t column_blocks, int32_t row_blocks) {
  const double n = 3.0 * column_blocks, m = 3.0 * row_blocks;
  return n * n * n / 3.0 + n * n * m + n * m * m;
}

}  // namespace

void FrontPlan::build(const AssemblyTree& tree, int strip, int tile) {
  const int32_t count = tree.supernode_count();
  const auto round_up = [](int64_t value, int64_t unit) { return (value + unit - 1) / unit * unit; };
  factor_offset.assign(static_cast<size_t>(count) + 1, 0);
  update_offset.assign(count, 0);
  std::vector<int64_t> update_size(count);
  max_rows = 0;
  for (int32_t s = 0; s < count; ++s) {
    const int64_t columns = round_up(3 * tree.column_count(s), tile),
                  pivot_strips = round_up(columns, strip) / strip;
    const int64_t border_strips = round_up(3 * tree.row_count(s), strip) / strip;
    // Whole strips of the pivot block but the last, whose columns end with the padded pivots.
    const int64_t pivot = strip * (strip * (pivot_strips * (pivot_strips - 1) / 2) + columns);
    factor_offset[s + 1] = factor_offset[s] + pivot + border_strips * strip * columns;
    update_size[s] = strip * strip * (border_strips * (border_strips + 1) / 2);
    max_rows = std::max(max_rows, static_cast<int>((pivot_strips + border_strips) * strip));
  }

  // Maximal subtrees below the threshold; neighbours are joined up to it.
  std::vector<double> work(count, 0.0);
  double total = 0.0;
  for (int32_t s = 0; s < count; ++s) {
    const double own = front_flops(tree.column_count(s), tree.row_count(s));
    work[s] += own;
    total += own;
    if (tree.parent[s] >= 0) work[tree.parent[s]] += work[s];
  }
  const double limit = std::max(kSubtreeFlops, kSubtreeShare * total);
  in_subtree.assign(count, 0);
  update_shared.assign(count, 1);
  subtrees.clear();
  top.clear();
  std::vector<int32_t> first_descendant(count);
  for (int32_t s = 0; s < count; ++s)
    first_descendant[s] =
        tree.child_start[s] < tree.child_start[s + 1] ? first_descendant[tree.child[tree.child_start[s]]] : s;
  double joined = 0.0;
  for (int32_t s = 0; s < count; ++s) {
    if (work[s] > limit) {
      top.push_back(s);
      continue;
    }
    in_subtree[s] = 1;
    const bool is_root = tree.parent[s] < 0 || work[tree.parent[s]] > limit;
    update_shared[s] = is_root;
    if (!is_root) continue;
    if (!subtrees.empty() && subtrees.back().end == first_descendant[s] && joined + work[s] <= limit) {
      subtrees.back().end = s + 1;
      joined += work[s];
    } else {
      subtrees.push_back({first_descendant[s], s + 1});
      joined = work[s];
    }
  }

  // Update matrices live from their front to their parent's. Levels of odd and even depth have a stack each,
  // so that a front's matrix can be allocated before those of its children are released.
  std::vector<uint8_t> parity(count);
  for (int32_t s = count - 1; s >= 0; --s) parity[s] = tree.parent[s] < 0 ? 0 : 1 - parity[tree.parent[s]];
  int64_t height[2], peak[2];
  const auto release_children = [&](int32_t s, bool above) {
    for (int32_t c = tree.child_start[s]; c < tree.child_start[s + 1]; ++c)
      if (!(above && in_subtree[tree.child[c]])) height[1 - parity[s]] -= update_size[tree.child[c]];
  };
  const auto allocate = [&](int32_t s) {
    const int side = parity[s];
    update_offset[s] = height[side];
    height[side] += update_size[s];
    peak[side] = std::max(peak[side], height[side]);
  };
  thread_arena_size = 0;
  for (const Subtree& subtree : subtrees) {
    height[0] = height[1] = peak[0] = peak[1] = 0;
    for (int32_t s = subtree.begin; s < subtree.end; ++s) {
      if (!update_shared[s]) allocate(s);
      release_children(s, false);
    }
    for (int32_t s = subtree.begin; s < subtree.end; ++s)
      if (!update_shared[s] && parity[s] == 1) update_offset[s] += peak[0];
    thread_arena_size = std::max(thread_arena_size, peak[0] + peak[1]);
  }
  // Shared: the roots of the subtrees first, each for itself, then the stacks of the top.
  int64_t roots = 0;
  for (const Subtree& subtree : subtrees)
    for (int32_t s = subtree.begin; s < subtree.end; ++s)
      if (update_shared[s]) update_offset[s] = roots, roots += update_size[s];
  height[0] = height[1] = peak[0] = peak[1] = 0;
  for (const int32_t s : top) {
    allocate(s);
    release_children(s, true);
  }
  for (const int32_t s : top) update_offset[s] += roots + (parity[s] == 1 ? peak[0] : 0);
  shared_arena_size = roots + peak[0] + peak[1];
}

}  // namespace stark
