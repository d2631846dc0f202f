// Elimination tree, column counts, supernodes, fronts.
#include <stark/linalg/elimination.h>

#include <algorithm>
#include <limits>
#include <numeric>

#include <stark/base/error.h>

namespace stark {

namespace {

// Modelled nanoseconds of one front, for amalgamation: dense work on padded sizes, traffic of the update
// matrix, and a fixed cost. A merge is done when it lowers the sum.
double front_cost(double columns, double rows, int strip) {
  const double c = 3.0 * columns, r = 3.0 * rows;
  const double c_pad = strip * static_cast<double>((3 * static_cast<int64_t>(columns) + strip - 1) / strip);
  const double r_pad = strip * static_cast<double>((3 * static_cast<int64_t>(rows) + strip - 1) / strip);
  const double flops = c * c_pad * c_pad * 0.5 + c * c * r_pad + c * r_pad * (r_pad + strip);
  return 250.0 + flops * 0.04 + r * r * 0.5 * 0.9 + (c_pad + r_pad) * c * 0.2;
}

}  // namespace

void SymbolicFactorization::analyze(const BlockPattern& pattern, std::span<const int32_t> order, int strip,
                                    AssemblyTree& out_tree) {
  n_ = pattern.block_count;
  STARK_CHECK(static_cast<int32_t>(order.size()) == n_);
  STARK_CHECK(pattern.slot_count() < std::numeric_limits<int32_t>::max() / 2);
  collect_upper(pattern, order);
  build_elimination_tree();
  postorder_columns();
  count_columns();
  out_tree.block_count = n_;
  out_tree.flops = 0.0;
  for (int32_t j = 0; j < n_; ++j)
    for (int k = 0; k < 3; ++k) out_tree.flops += (3.0 * count_[j] - k) * (3.0 * count_[j] - k);
  find_supernodes();
  amalgamate(strip);
  number_supernodes(order, out_tree);
  collect_entries(pattern, out_tree);
  build_rows(out_tree);
}

// low_: for each column its neighbours that are eliminated earlier.
void SymbolicFactorization::collect_upper(const BlockPattern& pattern, std::span<const int32_t> order) {
  position_.assign(n_, -1);
  for (int32_t p = 0; p < n_; ++p) {
    STARK_CHECK(order[p] >= 0 && order[p] < n_ && position_[order[p]] < 0);
    position_[order[p]] = p;
  }
  low_start_.assign(static_cast<size_t>(n_) + 1, 0);
  for (int32_t i = 0; i < n_; ++i)
    for (int64_t k = pattern.row_start[i] + 1; k < pattern.row_start[i + 1]; ++k)
      ++low_start_[std::max(position_[i], position_[pattern.column[k]]) + 1];
  for (int32_t i = 0; i < n_; ++i) low_start_[i + 1] += low_start_[i];
  low_.resize(low_start_[n_]);
  head_.assign(low_start_.begin(), low_start_.end() - 1);
  for (int32_t i = 0; i < n_; ++i)
    for (int64_t k = pattern.row_start[i] + 1; k < pattern.row_start[i + 1]; ++k) {
      const int32_t a = position_[i], b = position_[pattern.column[k]];
      low_[head_[std::max(a, b)]++] = std::min(a, b);
    }
}

void SymbolicFactorization::build_elimination_tree() {
  parent_.assign(n_, -1);
  ancestor_.assign(n_, -1);
  for (int32_t j = 0; j < n_; ++j)
    for (int32_t k = low_start_[j]; k < low_start_[j + 1]; ++k)
      for (int32_t i = low_[k]; i != -1 && i < j;) {  // climb, shortening the path behind
        const int32_t up = ancestor_[i];
        ancestor_[i] = j;
        if (up == -1) parent_[i] = j;
        i = up;
      }
}

// Relabels columns by a postorder of the tree, in which every subtree is a range.
void SymbolicFactorization::postorder_columns() {
  head_.assign(n_, -1);
  next_.resize(n_);
  for (int32_t j = n_ - 1; j >= 0; --j)
    if (parent_[j] >= 0) next_[j] = head_[parent_[j]], head_[parent_[j]] = j;
  label_.resize(n_);
  postorder_.resize(n_);
  int32_t count = 0;
  for (int32_t root = 0; root < n_; ++root) {
    if (parent_[root] >= 0) continue;
    stack_.assign(1, root);
    while (!stack_.empty()) {
      const int32_t j = stack_.back();
      if (head_[j] >= 0) {
        stack_.push_back(head_[j]);
        head_[j] = next_[head_[j]];
      } else {
        stack_.pop_back();
        label_[j] = count;
        postorder_[count++] = j;
      }
    }
  }
  ancestor_.resize(n_);
  for (int32_t j = 0; j < n_; ++j) ancestor_[label_[j]] = parent_[j] < 0 ? -1 : label_[parent_[j]];
  std::swap(parent_, ancestor_);
  // high_: for each column, in the new labels, its later neighbours.
  high_start_.assign(static_cast<size_t>(n_) + 1, 0);
  for (int32_t i : low_) ++high_start_[label_[i] + 1];
  for (int32_t j = 0; j < n_; ++j) high_start_[j + 1] += high_start_[j];
  high_.resize(low_.size());
  head_.assign(high_start_.begin(), high_start_.end() - 1);
  for (int32_t j = 0; j < n_; ++j)
    for (int32_t k = low_start_[j]; k < low_start_[j + 1]; ++k) high_[head_[label_[low_[k]]]++] = label_[j];
}

// Row i of L is the subtree of the tree whose leaves are found here; a column counts the row subtrees it lies
// in by adding one at every leaf and taking one off where two paths meet.
void SymbolicFactorization::count_columns() {
  count_.assign(n_, 0);
  first_descendant_.assign(n_, -1);
  max_first_.assign(n_, -1);
  previous_leaf_.assign(n_, -1);
  ancestor_.resize(n_);
  for (int32_t j = 0; j < n_; ++j) {
    ancestor_[j] = j;
    if (first_descendant_[j] < 0) {
      count_[j] = 1;  // a leaf of the tree
      for (int32_t k = j; k >= 0 && first_descendant_[k] < 0; k = parent_[k]) first_descendant_[k] = j;
    }
  }
  for (int32_t j = 0; j < n_; ++j) {
    if (parent_[j] >= 0) --count_[parent_[j]];
    for (int32_t k = high_start_[j]; k < high_start_[j + 1]; ++k) {
      const int32_t i = high_[k];
      if (first_descendant_[j] <= max_first_[i]) continue;  // inside a subtree already seen: not a leaf
      max_first_[i] = first_descendant_[j];
      ++count_[j];
      const int32_t previous = previous_leaf_[i];
      previous_leaf_[i] = j;
      if (previous < 0) continue;
      int32_t meet = previous;
      while (ancestor_[meet] != meet) meet = ancestor_[meet];
      for (int32_t p = previous; p != meet;) {
        const int32_t up = ancestor_[p];
        ancestor_[p] = meet;
        p = up;
      }
      --count_[meet];
    }
    if (parent_[j] >= 0) ancestor_[j] = parent_[j];
  }
  // The first leaf of row i counts the path up to i itself, which its diagonal also does: both are right,
  // because a column's own diagonal is only counted when it has no descendants.
  for (int32_t j = 0; j < n_; ++j)
    if (parent_[j] >= 0) count_[parent_[j]] += count_[j];
}

void SymbolicFactorization::find_supernodes() {
  node_first_.clear();
  node_columns_.clear();
  node_rows_.clear();
  supernode_of_.resize(n_);
  for (int32_t j = 0; j < n_; ++j) {
    const bool same = j > 0 && parent_[j - 1] == j && count_[j - 1] == count_[j] + 1;
    if (!same) {
      node_first_.push_back(j);
      node_columns_.push_back(0);
      node_rows_.push_back(0);
    }
    ++node_columns_.back();
    node_rows_.back() = count_[j] - 1;
    supernode_of_[j] = static_cast<int32_t>(node_first_.size()) - 1;
  }
  const auto count = static_cast<int32_t>(node_first_.size());
  node_parent_.resize(count);
  for (int32_t s = 0; s < count; ++s) {
    const int32_t up = parent_[node_first_[s] + node_columns_[s] - 1];
    node_parent_[s] = up < 0 ? -1 : supernode_of_[up];
  }
}

// Merges children into parents, bottom up, where the explicit zeros cost less than a front of its own.
void SymbolicFactorization::amalgamate(int strip) {
  const auto count = static_cast<int32_t>(node_first_.size());
  merged_into_.assign(count, -1);
  chain_next_.assign(count, -1);  // parts of a merged supernode in elimination order, the survivor last
  head_.assign(count, -1);        // children of a supernode, merged ones replaced by their children
  next_.assign(count, -1);
  ancestor_.resize(count);  // first supernode of the chain
  std::iota(ancestor_.begin(), ancestor_.begin() + count, 0);
  for (int32_t s = 0; s < count; ++s) {
    double own_cost = front_cost(node_columns_[s], node_rows_[s], strip);
    // Largest update first: it brings the fewest zeros.
    stack_.clear();
    for (int32_t c = head_[s]; c >= 0; c = next_[c]) stack_.push_back(c);
    std::sort(stack_.begin(), stack_.end(), [&](int32_t a, int32_t b) {
      return node_rows_[a] != node_rows_[b] ? node_rows_[a] > node_rows_[b] : a < b;
    });
    int32_t kept = -1;
    for (const int32_t c : stack_) {
      const double child_cost = front_cost(node_columns_[c], node_rows_[c], strip);
      const double merged_cost = front_cost(node_columns_[c] + node_columns_[s], node_rows_[s], strip);
      if (merged_cost <= child_cost + own_cost) {
        own_cost = merged_cost;
        node_columns_[s] += node_columns_[c];
        merged_into_[c] = s;
        chain_next_[c] = ancestor_[s];
        ancestor_[s] = ancestor_[c];
        for (int32_t g = head_[c]; g >= 0;) {
          const int32_t following = next_[g];
          next_[g] = kept;
          kept = g;
          g = following;
        }
      } else {
        next_[c] = kept;
        kept = c;
      }
    }
    head_[s] = kept;
    if (node_parent_[s] >= 0) {
      next_[s] = head_[node_parent_[s]];
      head_[node_parent_[s]] = s;
    }
  }
}

// Numbers the surviving supernodes in postorder and their columns consecutively.
void SymbolicFactorization::number_supernodes(std::span<const int32_t> order, AssemblyTree& tree) {
  const auto count = static_cast<int32_t>(node_first_.size());
  tree.first.clear();
  tree.parent.clear();
  tree.order.resize(n_);
  mark_.assign(count, -1);  // new number of a survivor
  label_.resize(n_);        // position of a column
  int32_t position = 0;
  const auto emit = [&](int32_t s) {
    const auto number = static_cast<int32_t>(tree.first.size());
    mark_[s] = number;
    tree.first.push_back(position);
    for (int32_t part = ancestor_[s];; part = chain_next_[part]) {
      const int32_t end = part + 1 < count ? node_first_[part + 1] : n_;
      for (int32_t j = node_first_[part]; j < end; ++j) label_[j] = position++;
      if (part == s) break;
    }
  };
  for (int32_t root = 0; root < count; ++root) {
    if (merged_into_[root] >= 0 || node_parent_[root] >= 0) continue;
    stack_.assign(1, root);
    while (!stack_.empty()) {
      const int32_t s = stack_.back();
      if (head_[s] >= 0) {
        stack_.push_back(head_[s]);
        head_[s] = next_[head_[s]];
      } else {
        stack_.pop_back();
        emit(s);
      }
    }
  }
  tree.first.push_back(n_);
  STARK_CHECK(position == n_);
  const auto survivors = static_cast<int32_t>(tree.first.size()) - 1;
  tree.parent.assign(survivors, -1);
  for (int32_t s = 0; s < count; ++s) {
    if (mark_[s] < 0) continue;
    int32_t up = node_parent_[s];
    while (up >= 0 && merged_into_[up] >= 0) up = merged_into_[up];
    tree.parent[mark_[s]] = up < 0 ? -1 : mark_[up];
  }
  for (int32_t j = 0; j < n_; ++j) tree.order[label_[j]] = order[postorder_[j]];
  for (int32_t p = 0; p < n_; ++p) position_[tree.order[p]] = p;
  supernode_of_.resize(n_);
  for (int32_t s = 0; s < survivors; ++s)
    for (int32_t p = tree.first[s]; p < tree.first[s + 1]; ++p) supernode_of_[p] = s;
  tree.child_start.assign(static_cast<size_t>(survivors) + 1, 0);
  for (int32_t s = 0; s < survivors; ++s)
    if (tree.parent[s] >= 0) ++tree.child_start[tree.parent[s] + 1];
  for (int32_t s = 0; s < survivors; ++s) tree.child_start[s + 1] += tree.child_start[s];
  tree.child.resize(tree.child_start[survivors]);
  head_.assign(tree.child_start.begin(), tree.child_start.end() - 1);
  for (int32_t s = 0; s < survivors; ++s)
    if (tree.parent[s] >= 0) tree.child[head_[tree.parent[s]]++] = s;
}

// Sorts the blocks of A by the supernode that owns them; rows are still positions.
void SymbolicFactorization::collect_entries(const BlockPattern& pattern, AssemblyTree& tree) {
  const int32_t count = tree.supernode_count();
  tree.entry_start.assign(static_cast<size_t>(count) + 1, 0);
  tree.entry.resize(pattern.column.size());
  for (int32_t i = 0; i < n_; ++i)
    for (int64_t k = pattern.row_start[i]; k < pattern.row_start[i + 1]; ++k)
      ++tree.entry_start[supernode_of_[std::min(position_[i], position_[pattern.column[k]])] + 1];
  for (int32_t s = 0; s < count; ++s) tree.entry_start[s + 1] += tree.entry_start[s];
  head_.resize(count);
  for (int32_t s = 0; s < count; ++s) head_[s] = static_cast<int32_t>(tree.entry_start[s]);
  for (int32_t i = 0; i < n_; ++i)
    for (int64_t k = pattern.row_start[i]; k < pattern.row_start[i + 1]; ++k) {
      const int32_t a = position_[i], b = position_[pattern.column[k]];
      const int32_t column = std::min(a, b), s = supernode_of_[column];
      // The stored block couples row i with column j; in L the later position is the row.
      tree.entry[head_[s]++] = {static_cast<int32_t>(k), std::max(a, b), column - tree.first[s],
                                a < b ? 1 : 0};
    }
}

// Update rows of every front: later neighbours of its columns and update rows of its children.
void SymbolicFactorization::build_rows(AssemblyTree& tree) {
  const int32_t count = tree.supernode_count();
  tree.row_start.assign(static_cast<size_t>(count) + 1, 0);
  tree.row.clear();
  tree.factor_nonzeros = 0;
  mark_.assign(n_, -1);
  for (int32_t s = 0; s < count; ++s) {
    const size_t begin = tree.row.size();
    const int32_t end = tree.first[s + 1];
    const auto add = [&](int32_t p) {
      if (p < end || mark_[p] == s) return;
      mark_[p] = s;
      tree.row.push_back(p);
    };
    for (int64_t k = tree.entry_start[s]; k < tree.entry_start[s + 1]; ++k) add(tree.entry[k].row);
    for (int32_t c = tree.child_start[s]; c < tree.child_start[s + 1]; ++c) {
      const int32_t child = tree.child[c];
      for (int64_t k = tree.row_start[child]; k < tree.row_start[child + 1]; ++k) add(tree.row[k]);
    }
    std::sort(tree.row.begin() + static_cast<ptrdiff_t>(begin), tree.row.end());
    tree.row_start[s + 1] = static_cast<int64_t>(tree.row.size());
    const int64_t columns = 3 * tree.column_count(s), rows = 3 * tree.row_count(s);
    tree.factor_nonzeros += columns * (columns + 1) / 2 + columns * rows;
  }
  tree.relative.resize(tree.row.size());
  std::vector<int32_t>& local = mark_;  // position to row of the current front
  for (int32_t s = 0; s < count; ++s) {
    const int32_t columns = tree.column_count(s), begin = tree.first[s];
    for (int64_t k = tree.row_start[s]; k < tree.row_start[s + 1]; ++k)
      local[tree.row[k]] = columns + static_cast<int32_t>(k - tree.row_start[s]);
    const auto local_row = [&](int32_t p) { return p < begin + columns ? p - begin : local[p]; };
    for (int64_t k = tree.entry_start[s]; k < tree.entry_start[s + 1]; ++k)
      tree.entry[k].row = local_row(tree.entry[k].row);
    for (int32_t c = tree.child_start[s]; c < tree.child_start[s + 1]; ++c) {
      const int32_t child = tree.child[c];
      for (int64_t k = tree.row_start[child]; k < tree.row_start[child + 1]; ++k)
        tree.relative[k] = local_row(tree.row[k]);
    }
  }
}

}  // namespace stark
