// Symbolic Cholesky factorisation on the graph of 3x3 blocks: elimination tree (Liu 1990), column counts
// (Gilbert, Ng and Peyton 1994), supernodes with relaxed amalgamation (Ashcraft and Grimes 1989), fronts of
// the multifrontal method (Liu 1992). Phase: whenever the pattern of the system changes.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <stark/linalg/block_matrix.h>

namespace stark {

/// Where one stored block of A goes in its front.
struct FrontEntry {
  int32_t slot;  // of A
  int32_t row;   // block row and column in the front
  int32_t column;
  int32_t transposed;  // 1: the stored block is the transpose of what belongs there
};

/// The assembly tree. "Position" is the place of a block row in the elimination order; supernode s owns the
/// positions first[s] .. first[s + 1] - 1, and its front has these columns, and as rows these positions and
/// then the update rows row[row_start[s]] .., ascending. Supernodes are in postorder: children precede their
/// parent.
struct AssemblyTree {
  int32_t block_count = 0;
  std::vector<int32_t> order;               // [block_count] block row at each position
  std::vector<int32_t> first;               // [supernode_count + 1]
  std::vector<int32_t> parent;              // [supernode_count], -1 for a root
  std::vector<int32_t> child_start, child;  // children of s: child[child_start[s]] .., ascending
  std::vector<int64_t> row_start;
  std::vector<int32_t> row;
  std::vector<int32_t> relative;  // aligned with `row`: row of the parent's front that this row is added to
  std::vector<int64_t> entry_start;
  std::vector<FrontEntry> entry;
  double flops = 0.0;           // of the scalar factorisation without amalgamation
  int64_t factor_nonzeros = 0;  // scalar entries of L with amalgamation

  int32_t supernode_count() const { return static_cast<int32_t>(parent.size()); }
  int32_t column_count(int32_t s) const { return first[s + 1] - first[s]; }
  int32_t row_count(int32_t s) const { return static_cast<int32_t>(row_start[s + 1] - row_start[s]); }
};

/// Computes assembly trees, keeping its working storage from one pattern to the next.
class SymbolicFactorization {
 public:
  /// `order` [block_count] is a fill-reducing order; the tree's own order is equivalent to it (same fill up
  /// to amalgamation). `strip` is the row granularity of the numerical kernels in scalars, which amalgamation
  /// minds.
  void analyze(const BlockPattern& pattern, std::span<const int32_t> order, int strip,
               AssemblyTree& out_tree);

 private:
  void collect_upper(const BlockPattern& pattern, std::span<const int32_t> order);
  void build_elimination_tree();
  void postorder_columns();
  void count_columns();
  void find_supernodes();
  void amalgamate(int strip);
  void number_supernodes(std::span<const int32_t> order, AssemblyTree& tree);
  void collect_entries(const BlockPattern& pattern, AssemblyTree& tree);
  void build_rows(AssemblyTree& tree);

  int32_t n_ = 0;
  std::vector<int32_t> position_;         // of a block row in the working order
  std::vector<int32_t> low_start_, low_;  // per column: earlier neighbours
  std::vector<int32_t> parent_, ancestor_;
  std::vector<int32_t> head_, next_, stack_;  // children lists
  std::vector<int32_t> postorder_, label_;
  std::vector<int32_t> count_;  // rows of each column of L, diagonal included
  std::vector<int32_t> first_descendant_, max_first_, previous_leaf_;
  std::vector<int32_t> high_start_, high_;
  // Supernodes while they are merged.
  std::vector<int32_t> node_first_, node_columns_, node_rows_, node_parent_, merged_into_, chain_next_;
  std::vector<int32_t> mark_, supernode_of_;
};

}  // namespace stark
