// Multifrontal Cholesky: a front gathers the blocks of A of its columns and the update matrices of its
// children, is factorised densely, and leaves the Schur complement of its update rows to its parent. Subtrees
// run in parallel, the fronts above them are shared strip by strip; in both cases every entry is computed by
// the same sequence of operations on any number of threads.
#include <stark/linalg/cholesky.h>

#include <algorithm>
#include <atomic>
#include <vector>

#include <stark/base/aligned.h>
#include <stark/base/cpu.h>
#include <stark/base/error.h>
#include <stark/base/for_each_range.h>
#include <stark/linalg/elimination.h>
#include <stark/linalg/front_assembly.h>
#include <stark/linalg/front_kernels.h>
#include <stark/linalg/front_plan.h>
#include <stark/linalg/ordering.h>

namespace stark {

namespace {

using front::Assembly;
using front::Front;
using front::kColumnBlock;
using front::kStrip;
using front::kTile;
using front::strips_of;
using front::triangle_offset;

constexpr double kReorderFactor = 2.0;  // fill tolerated, in flops, before a new ordering
// An ordering made for many contacts is poor for few: it is redone when this share of the blocks is left, but
// not until so many analyses later, as contacts may come back.
constexpr double kShrinkFactor = 0.95;
constexpr int64_t kShrinkPatience = 20;
constexpr int64_t kStripGrain = 4;      // strips of one task in a shared front
constexpr int64_t kAssemblyGrain = 16;  // child columns of one task when a shared front is assembled
constexpr int64_t kZerosGrain = 65536;  // entries of one task when a shared front is cleared
constexpr int64_t kSolveGrain = 32768;  // entries of the factor of one task of a solve with a shared front
constexpr int64_t kRowsGrain = 8192;    // block rows of one task when vectors are permuted
constexpr int32_t kNoFailure = INT32_MAX;

/// Of `length` entries a row, for a solve with a shared front.
template <typename Real>
int64_t strips_per_task(int64_t length) {
  return std::max<int64_t>(kSolveGrain / (kStrip<Real> * std::max<int64_t>(length, 1)), 1);
}

}  // namespace

template <typename Real>
struct Cholesky<Real>::Implementation {
  std::vector<int32_t> order;
  double flops_at_ordering = 0.0;
  int64_t slots_at_ordering = 0, analyses_at_ordering = 0;
  uint64_t ordered_pattern = 0;  // hash of the pattern that the ordering was made for
  bool new_sequence = false;
  int64_t orderings = 0, analyses = 0;
  int64_t slot_count = -1;
  const bool wide = cpu_features().avx512;
  SymbolicFactorization symbolic;
  AssemblyTree tree;
  FrontPlan plan;

  ScratchBuffer<Real> factor_storage, shared_arena;
  std::vector<ScratchBuffer<Real>> thread_arenas;
  std::vector<Assembly> assemblies;        // per thread
  AlignedVector<Real> y, w;                // permuted right-hand side; update rows of every front
  std::vector<AlignedVector<Real>> local;  // per thread: pivots and update rows of one front

  Front<Real> front_of(int32_t s, int thread);
  std::span<const int32_t> relative_of(int32_t child) const {
    return {tree.relative.data() + tree.row_start[child], static_cast<size_t>(tree.row_count(child))};
  }
  std::span<const FrontEntry> entries_of(int32_t s) const {
    return {tree.entry.data() + tree.entry_start[s], tree.entry.data() + tree.entry_start[s + 1]};
  }
  int32_t failed_position(int32_t s, const Front<Real>& f, int column) const;
  int32_t factor_front(const BlockMatrix& matrix, int32_t s, int thread);
  int32_t factor_shared_front(const BlockMatrix& matrix, int32_t s, ThreadPool& pool);
  void forward(int32_t s, Real* scratch, ThreadPool* shared);
  void backward(int32_t s, Real* scratch, ThreadPool* shared);
};

template <typename Real>
Front<Real> Cholesky<Real>::Implementation::front_of(int32_t s, int thread) {
  Front<Real> f;
  f.columns = 3 * tree.column_count(s);
  f.rows = 3 * tree.row_count(s);
  f.padded_columns = (f.columns + kTile - 1) / kTile * kTile;
  f.pivot_strips = strips_of<Real>(f.padded_columns);
  f.border_strips = strips_of<Real>(f.rows);
  f.pivot = factor_storage.data() + plan.factor_offset[s];
  f.border = f.pivot + triangle_offset<Real>(f.pivot_strips - 1) + kStrip<Real> * f.padded_columns;
  f.update =
      (plan.update_shared[s] ? shared_arena.data() : thread_arenas[thread].data()) + plan.update_offset[s];
  return f;
}

template <typename Real>
int32_t Cholesky<Real>::Implementation::failed_position(int32_t s, const Front<Real>& f, int column) const {
  return tree.first[s] + std::min(column, f.columns - 1) / 3;
}

// One front on one thread. Returns the position of the first pivot that is not positive, or kNoFailure.
template <typename Real>
int32_t Cholesky<Real>::Implementation::factor_front(const BlockMatrix& matrix, int32_t s, int thread) {
  const Front<Real> f = front_of(s, thread);
  std::ranges::fill(f.panel(), Real(0));
  front::load_matrix(f, matrix, entries_of(s));
  const int32_t begin = tree.child_start[s], end = tree.child_start[s + 1];
  Assembly& assembly = assemblies[thread];
  for (int32_t c = begin; c < end; ++c) {
    const int32_t child = tree.child[c];
    const auto relative = relative_of(child);
    front::prepare_assembly(f, relative, assembly);
    front::assemble(f, front_of(child, thread).update, relative, assembly, 0,
                    front::pivot_columns(f, relative));
  }
  for (int block = 0; block < f.padded_columns; block += kColumnBlock) {
    const int block_end = std::min(block + kColumnBlock, f.padded_columns);
    front::update_diagonal(f.pivot, block, block_end, block / kStrip<Real>, strips_of<Real>(block_end));
    const int failed = front::factor_diagonal(f.pivot, block, block_end);
    if (failed >= 0) return failed_position(s, f, failed);
    front::solve_strips(f.pivot, block, block_end, strips_of<Real>(block_end), f.pivot_strips, wide,
                        [&](int strip) { return f.pivot_strip(strip); });
    front::solve_strips(f.pivot, block, block_end, 0, f.border_strips, wide,
                        [&](int strip) { return f.border_strip(strip); });
  }
  front::form_update(f.update, f.border, f.padded_columns, 0, f.border_strips, wide);
  for (int32_t c = begin; c < end; ++c) {
    const int32_t child = tree.child[c];
    const auto relative = relative_of(child);
    if (end - begin > 1) front::prepare_assembly(f, relative, assembly);
    front::assemble(f, front_of(child, thread).update, relative, assembly, front::pivot_columns(f, relative),
                    tree.row_count(child));
  }
  return kNoFailure;
}

// The same operations on every entry, shared among threads by strips and by child columns.
template <typename Real>
int32_t Cholesky<Real>::Implementation::factor_shared_front(const BlockMatrix& matrix, int32_t s,
                                                            ThreadPool& pool) {
  const Front<Real> f = front_of(s, 0);
  const std::span<Real> panel = f.panel();
  pool.for_each_range(std::ssize(panel), kZerosGrain, [&](int64_t from, int64_t to) {
    std::ranges::fill(panel.subspan(from, to - from), Real(0));
  });
  front::load_matrix(f, matrix, entries_of(s));
  const auto assemble_shared = [&](int32_t child, int32_t begin, int32_t end) {
    const Real* source = front_of(child, 0).update;
    pool.for_each_range(end - begin, kAssemblyGrain, [&](int64_t from, int64_t to) {
      front::assemble(f, source, relative_of(child), assemblies[0], begin + static_cast<int32_t>(from),
                      begin + static_cast<int32_t>(to));
    });
  };
  const int32_t begin = tree.child_start[s], end = tree.child_start[s + 1];
  for (int32_t c = begin; c < end; ++c) {
    const auto relative = relative_of(tree.child[c]);
    front::prepare_assembly(f, relative, assemblies[0]);
    assemble_shared(tree.child[c], 0, front::pivot_columns(f, relative));
  }
  for (int block = 0; block < f.padded_columns; block += kColumnBlock) {
    const int block_end = std::min(block + kColumnBlock, f.padded_columns);
    const int own = block / kStrip<Real>, first = strips_of<Real>(block_end), below = f.pivot_strips - first;
    if (block > 0)
      pool.for_each_task(first - own, [&](int64_t strip, int) {
        const int at = own + static_cast<int>(strip);
        front::update_diagonal(f.pivot, block, block_end, at, at + 1);
      });
    const int failed = front::factor_diagonal(f.pivot, block, block_end);
    if (failed >= 0) return failed_position(s, f, failed);
    pool.for_each_range(std::max(below, 0) + f.border_strips, kStripGrain, [&](int64_t from, int64_t to) {
      front::solve_strips(f.pivot, block, block_end, first + static_cast<int>(from),
                          first + static_cast<int>(to), wide, [&](int strip) {
                            return strip < f.pivot_strips ? f.pivot_strip(strip)
                                                          : f.border_strip(strip - f.pivot_strips);
                          });
    });
  }
  // The last strips are the longest: they go first.
  const int64_t tasks = (f.border_strips + kStripGrain - 1) / kStripGrain;
  pool.for_each_task(tasks, [&](int64_t task, int) {
    const auto from = static_cast<int>((tasks - 1 - task) * kStripGrain);
    front::form_update(f.update, f.border, f.padded_columns, from,
                       std::min(from + static_cast<int>(kStripGrain), f.border_strips), wide);
  });
  for (int32_t c = begin; c < end; ++c) {
    const auto relative = relative_of(tree.child[c]);
    front::prepare_assembly(f, relative, assemblies[0]);
    assemble_shared(tree.child[c], front::pivot_columns(f, relative), tree.row_count(tree.child[c]));
  }
  return kNoFailure;
}

template <typename Real>
Cholesky<Real>::Cholesky() : implementation_(std::make_unique<Implementation>()) {}
template <typename Real>
Cholesky<Real>::~Cholesky() = default;
template <typename Real>
Cholesky<Real>::Cholesky(Cholesky&&) noexcept = default;
template <typename Real>
Cholesky<Real>& Cholesky<Real>::operator=(Cholesky&&) noexcept = default;

template <typename Real>
void Cholesky<Real>::analyze(const BlockPattern& pattern, ThreadPool& pool) {
  Implementation& s = *implementation_;
  const uint64_t hash = pattern.hash();
  const bool foreign = s.new_sequence && s.ordered_pattern != hash;
  const bool keep =
      s.orderings > 0 && static_cast<int32_t>(s.order.size()) == pattern.block_count && !foreign;
  s.new_sequence = false;
  const auto reorder = [&] {
    s.order = fill_reducing_order(AdjacencyGraph::from_pattern(pattern), pool);
    ++s.orderings;
    s.ordered_pattern = hash;
    s.symbolic.analyze(pattern, s.order, kStrip<Real>, s.tree);
    s.flops_at_ordering = s.tree.flops;
    s.slots_at_ordering = pattern.slot_count();
    s.analyses_at_ordering = s.analyses;
  };
  const bool shrunk =
      static_cast<double>(pattern.slot_count()) < kShrinkFactor * static_cast<double>(s.slots_at_ordering) &&
      s.analyses >= s.analyses_at_ordering + kShrinkPatience;
  if (keep && !shrunk) {
    s.symbolic.analyze(pattern, s.order, kStrip<Real>, s.tree);
    if (s.tree.flops > kReorderFactor * s.flops_at_ordering) reorder();
  } else {
    reorder();
  }
  ++s.analyses;
  s.slot_count = pattern.slot_count();
  s.plan.build(s.tree, kStrip<Real>, kTile);
}

template <typename Real>
void Cholesky<Real>::analyze(const BlockPattern& pattern) {
  ThreadPool alone(1);
  analyze(pattern, alone);
}

template <typename Real>
void Cholesky<Real>::begin_sequence() {
  implementation_->new_sequence = true;
  implementation_->analyses_at_ordering = implementation_->analyses;
}

template <typename Real>
void Cholesky<Real>::keep_analysis() {
  implementation_->new_sequence = false;
  --implementation_->analyses_at_ordering;
}

template <typename Real>
uint64_t Cholesky<Real>::ordered_pattern() const {
  return implementation_->ordered_pattern;
}

template <typename Real>
FactorStatus Cholesky<Real>::factor(const BlockMatrix& matrix, ThreadPool& pool) {
  Implementation& s = *implementation_;
  STARK_CHECK(s.slot_count == matrix.pattern.slot_count() &&
              s.tree.block_count == matrix.pattern.block_count);
  STARK_CHECK(static_cast<int64_t>(matrix.values.size()) == 9 * s.slot_count);
  const int threads = pool.thread_count();
  if (static_cast<int>(s.assemblies.size()) < threads) {
    s.assemblies.resize(threads);
    s.thread_arenas.resize(threads);
  }
  s.factor_storage.reserve(s.plan.factor_offset.back());
  s.shared_arena.reserve(s.plan.shared_arena_size);
  s.thread_arenas[0].reserve(s.plan.thread_arena_size);
  // Subtrees after one that has failed need not be tried: the first failure in elimination order is reported.
  std::atomic<int32_t> first_failure{kNoFailure};
  pool.for_each_task(static_cast<int64_t>(s.plan.subtrees.size()), [&](int64_t task, int thread) {
    const FrontPlan::Subtree& subtree = s.plan.subtrees[task];
    if (first_failure.load() < s.tree.first[subtree.begin]) return;
    s.thread_arenas[thread].reserve(s.plan.thread_arena_size);
    for (int32_t node = subtree.begin; node < subtree.end; ++node) {
      const int32_t failed = s.factor_front(matrix, node, thread);
      if (failed == kNoFailure) continue;
      int32_t seen = first_failure.load();
      while (failed < seen && !first_failure.compare_exchange_weak(seen, failed)) {
      }
      return;
    }
  });
  int32_t failure = first_failure.load();
  for (size_t k = 0; k < s.plan.top.size() && failure == kNoFailure; ++k)
    failure = s.factor_shared_front(matrix, s.plan.top[k], pool);
  if (failure == kNoFailure) return {};
  return {false, s.tree.order[failure]};
}

// Solves with the pivots of supernode s; leaves in w what its update rows owe. shared: for fronts above the
// subtrees.
template <typename Real>
void Cholesky<Real>::Implementation::forward(int32_t s, Real* scratch, ThreadPool* shared) {
  constexpr int kS = kStrip<Real>;
  const Front<Real> f = front_of(s, 0);
  Real* const x = scratch;
  Real* const rows = scratch + f.pivot_strips * kS;
  std::fill(x, rows + f.border_strips * kS, Real(0));
  Real* const own = y.data() + 3 * static_cast<int64_t>(tree.first[s]);
  std::copy(own, own + f.columns, x);
  for (int32_t c = tree.child_start[s]; c < tree.child_start[s + 1]; ++c) {
    const int32_t child = tree.child[c];
    for (int64_t k = tree.row_start[child]; k < tree.row_start[child + 1]; ++k) {
      const Real* from = w.data() + 3 * k;
      const int row = 3 * tree.relative[k];
      if (row < f.columns) {
        for (int r = 0; r < 3; ++r) x[row + r] -= from[r];
      } else {
        for (int r = 0; r < 3; ++r) rows[row - f.columns + r] += from[r];
      }
    }
  }
  front::solve_lower(f.pivot, f.padded_columns, x);
  for_each_range(shared, f.border_strips, strips_per_task<Real>(f.padded_columns),
                 [&](int64_t from, int64_t to) {
                   for (auto strip = static_cast<int>(from); strip < to; ++strip)
                     front::multiply_strip(f.border_strip(strip), x, f.padded_columns, rows + strip * kS);
                 });
  std::copy(x, x + f.columns, own);
  std::copy(rows, rows + f.rows, w.data() + 3 * tree.row_start[s]);
}

template <typename Real>
void Cholesky<Real>::Implementation::backward(int32_t s, Real* scratch, ThreadPool* shared) {
  constexpr int kS = kStrip<Real>;
  const Front<Real> f = front_of(s, 0);
  Real* const x = scratch;
  Real* const rows = scratch + f.pivot_strips * kS;
  std::fill(x, rows + f.border_strips * kS, Real(0));
  Real* const own = y.data() + 3 * static_cast<int64_t>(tree.first[s]);
  std::copy(own, own + f.columns, x);
  const int32_t* row = tree.row.data() + tree.row_start[s];
  for (int32_t k = 0; k < f.rows / 3; ++k)
    for (int r = 0; r < 3; ++r) rows[3 * k + r] = y[3 * static_cast<int64_t>(row[k]) + r];
  if (shared != nullptr)
    shared->for_each_range(f.pivot_strips, strips_per_task<Real>(f.border_strips * kS),
                           [&](int64_t from, int64_t to) {
                             front::subtract_border(f.border, f.padded_columns, f.border_strips,
                                                    static_cast<int>(from), static_cast<int>(to), x, rows);
                           });
  front::solve_upper(f.pivot, f.border, f.padded_columns, shared != nullptr ? 0 : f.border_strips, x, rows);
  std::copy(x, x + f.columns, own);
}

template <typename Real>
void Cholesky<Real>::solve(const double* b, double* x, ThreadPool& pool) {
  Implementation& s = *implementation_;
  const int32_t n = s.tree.block_count;
  s.y.resize(3 * static_cast<size_t>(n));
  s.w.resize(3 * s.tree.row.size());
  if (static_cast<int>(s.local.size()) < pool.thread_count()) s.local.resize(pool.thread_count());
  for (auto& scratch : s.local) scratch.resize(s.plan.max_rows);
  pool.for_each_range(n, kRowsGrain, [&](int64_t begin, int64_t end) {
    for (int64_t p = begin; p < end; ++p)
      for (int r = 0; r < 3; ++r)
        s.y[3 * p + r] = static_cast<Real>(b[3 * static_cast<int64_t>(s.tree.order[p]) + r]);
  });
  const auto subtrees = static_cast<int64_t>(s.plan.subtrees.size());
  pool.for_each_task(subtrees, [&](int64_t task, int thread) {
    for (int32_t node = s.plan.subtrees[task].begin; node < s.plan.subtrees[task].end; ++node)
      s.forward(node, s.local[thread].data(), nullptr);
  });
  for (const int32_t node : s.plan.top) s.forward(node, s.local[0].data(), &pool);
  for (size_t k = s.plan.top.size(); k-- > 0;) s.backward(s.plan.top[k], s.local[0].data(), &pool);
  pool.for_each_task(subtrees, [&](int64_t task, int thread) {
    for (int32_t node = s.plan.subtrees[task].end; node-- > s.plan.subtrees[task].begin;)
      s.backward(node, s.local[thread].data(), nullptr);
  });
  pool.for_each_range(n, kRowsGrain, [&](int64_t begin, int64_t end) {
    for (int64_t p = begin; p < end; ++p)
      for (int r = 0; r < 3; ++r)
        x[3 * static_cast<int64_t>(s.tree.order[p]) + r] = static_cast<double>(s.y[3 * p + r]);
  });
}

template <typename Real>
void Cholesky<Real>::solve(const double* b, double* x) {
  ThreadPool alone(1);
  solve(b, x, alone);
}

template <typename Real>
double Cholesky<Real>::flops() const {
  return implementation_->tree.flops;
}
template <typename Real>
int64_t Cholesky<Real>::factor_nonzeros() const {
  return implementation_->tree.factor_nonzeros;
}
template <typename Real>
int64_t Cholesky<Real>::ordering_count() const {
  return implementation_->orderings;
}
template <typename Real>
int64_t Cholesky<Real>::analysis_count() const {
  return implementation_->analyses;
}

template class Cholesky<double>;
template class Cholesky<float>;

}  // namespace stark
