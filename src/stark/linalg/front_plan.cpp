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

int64_t round_up(int64_t value, int64_t unit) { return (value + unit - 1) / unit * unit; }

/// Places the parts of the factor one behind the other; returns the sizes of the update matrices [scalars].
std::vector<int64_t> place_factor(const AssemblyTree& tree, int strip, int tile, FrontPlan& plan) {
  const int32_t count = tree.supernode_count();
  plan.factor_offset.assign(static_cast<size_t>(count) + 1, 0);
  std::vector<int64_t> update_size(count);
  plan.max_rows = 0;
  for (int32_t s = 0; s < count; ++s) {
    const int64_t columns = round_up(3 * tree.column_count(s), tile),
                  pivot_strips = round_up(columns, strip) / strip;
    const int64_t border_strips = round_up(3 * tree.row_count(s), strip) / strip;
    // Whole strips of the pivot block but the last, whose columns end with the padded pivots.
    const int64_t pivot = strip * (strip * (pivot_strips * (pivot_strips - 1) / 2) + columns);
    plan.factor_offset[s + 1] = plan.factor_offset[s] + pivot + border_strips * strip * columns;
    update_size[s] = strip * strip * (border_strips * (border_strips + 1) / 2);
    plan.max_rows = std::max(plan.max_rows, static_cast<int>((pivot_strips + border_strips) * strip));
  }
  return update_size;
}

/// Floating-point operations of each supernode with all below it, and of all.
std::vector<double> work_below(const AssemblyTree& tree, double& out_total) {
  std::vector<double> work(tree.supernode_count(), 0.0);
  out_total = 0.0;
  for (int32_t s = 0; s < tree.supernode_count(); ++s) {
    const double own = front_flops(tree.column_count(s), tree.row_count(s));
    work[s] += own;
    out_total += own;
    if (tree.parent[s] >= 0) work[tree.parent[s]] += work[s];
  }
  return work;
}

std::vector<int32_t> first_descendants(const AssemblyTree& tree) {
  std::vector<int32_t> first(tree.supernode_count());
  for (int32_t s = 0; s < tree.supernode_count(); ++s) {
    const int32_t child = tree.child_start[s];
    first[s] = child < tree.child_start[s + 1] ? first[tree.child[child]] : s;
  }
  return first;
}

/// Maximal subtrees below a threshold of work are tasks; neighbours are joined up to it.
void split_into_tasks(const AssemblyTree& tree, FrontPlan& plan) {
  const int32_t count = tree.supernode_count();
  double total;
  const std::vector<double> work = work_below(tree, total);
  const std::vector<int32_t> first_descendant = first_descendants(tree);
  const double limit = std::max(kSubtreeFlops, kSubtreeShare * total);
  plan.in_subtree.assign(count, 0);
  plan.update_shared.assign(count, 1);
  plan.subtrees.clear();
  plan.top.clear();
  double joined = 0.0;
  for (int32_t s = 0; s < count; ++s) {
    if (work[s] > limit) {
      plan.top.push_back(s);
      continue;
    }
    plan.in_subtree[s] = 1;
    const bool is_root = tree.parent[s] < 0 || work[tree.parent[s]] > limit;
    plan.update_shared[s] = is_root;
    if (!is_root) continue;
    std::vector<FrontPlan::Subtree>& subtrees = plan.subtrees;
    if (!subtrees.empty() && subtrees.back().end == first_descendant[s] && joined + work[s] <= limit) {
      subtrees.back().end = s + 1;
      joined += work[s];
    } else {
      subtrees.push_back({first_descendant[s], s + 1});
      joined = work[s];
    }
  }
}

/// Places update matrices, which live from their front to their parent's. Levels of odd and even depth have a
/// stack each, so that a front's matrix can be allocated before those of its children are released; the
/// second stack lies behind the first one.
class UpdateStacks {
 public:
  UpdateStacks(const AssemblyTree& tree, const std::vector<int64_t>& sizes, FrontPlan& plan)
      : tree_(tree), sizes_(sizes), plan_(plan), parity_(sizes.size()) {
    plan.update_offset.assign(sizes.size(), 0);
    for (int32_t s = tree.supernode_count() - 1; s >= 0; --s)
      parity_[s] = tree.parent[s] < 0 ? 0 : 1 - parity_[tree.parent[s]];
  }

  /// In the arena of the thread that has a subtree.
  void place_in_subtrees() {
    plan_.thread_arena_size = 0;
    for (const FrontPlan::Subtree& subtree : plan_.subtrees) {
      clear();
      for (int32_t s = subtree.begin; s < subtree.end; ++s) {
        if (!plan_.update_shared[s]) allocate(s);
        release_children(s, false);
      }
      for (int32_t s = subtree.begin; s < subtree.end; ++s)
        if (!plan_.update_shared[s]) plan_.update_offset[s] += stack_begin(s);
      plan_.thread_arena_size = std::max(plan_.thread_arena_size, size());
    }
  }

  /// The roots of the subtrees first, each for itself, then the stacks of the top.
  void place_shared() {
    int64_t roots = 0;
    for (const FrontPlan::Subtree& subtree : plan_.subtrees)
      for (int32_t s = subtree.begin; s < subtree.end; ++s)
        if (plan_.update_shared[s]) plan_.update_offset[s] = roots, roots += sizes_[s];
    clear();
    for (const int32_t s : plan_.top) {
      allocate(s);
      release_children(s, true);
    }
    for (const int32_t s : plan_.top) plan_.update_offset[s] += roots + stack_begin(s);
    plan_.shared_arena_size = roots + size();
  }

 private:
  void clear() { height_[0] = height_[1] = peak_[0] = peak_[1] = 0; }
  void allocate(int32_t s) {
    const int side = parity_[s];
    plan_.update_offset[s] = height_[side];
    height_[side] += sizes_[s];
    peak_[side] = std::max(peak_[side], height_[side]);
  }
  /// `above`: those of the top alone, as roots of subtrees are on no stack.
  void release_children(int32_t s, bool above) {
    for (int32_t c = tree_.child_start[s]; c < tree_.child_start[s + 1]; ++c)
      if (!(above && plan_.in_subtree[tree_.child[c]])) height_[1 - parity_[s]] -= sizes_[tree_.child[c]];
  }
  int64_t stack_begin(int32_t s) const { return parity_[s] == 1 ? peak_[0] : 0; }
  int64_t size() const { return peak_[0] + peak_[1]; }

  const AssemblyTree& tree_;
  const std::vector<int64_t>& sizes_;
  FrontPlan& plan_;
  std::vector<uint8_t> parity_;
  int64_t height_[2] = {}, peak_[2] = {};
};

}  // namespace

void FrontPlan::build(const AssemblyTree& tree, int strip, int tile) {
  const std::vector<int64_t> update_sizes = place_factor(tree, strip, tile, *this);
  split_into_tasks(tree, *this);
  UpdateStacks stacks(tree, update_sizes, *this);
  stacks.place_in_subtrees();
  stacks.place_shared();
}

}  // namespace stark
