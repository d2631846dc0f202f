// Supernodal multifrontal Cholesky factorisation A = L L^T of a block matrix, in double or single precision
// (Duff and Reid 1983; Liu 1992; Davis, Rajamanickam and Sid-Lakhdar 2016 for a survey). Symbolic work is
// done on the graph of 3x3 blocks. The bits of the result do not depend on the number of threads. Phase:
// linear solve of a Newton step.
#pragma once

#include <cstdint>
#include <memory>

#include <stark/base/thread_pool.h>
#include <stark/linalg/block_matrix.h>

namespace stark {

/// Outcome of a factorisation. A failed pivot is a value, not an error: the caller modifies the matrix and
/// tries again.
struct FactorStatus {
  bool positive_definite = true;
  int32_t failed_block = -1;  // block row of the first pivot that is not positive, -1 if there is none
};

template <typename Real>
class Cholesky {
 public:
  Cholesky();
  ~Cholesky();
  Cholesky(Cholesky&&) noexcept;
  Cholesky& operator=(Cholesky&&) noexcept;

  /// Symbolic phase for a pattern. The fill-reducing ordering is kept while the number of block rows is
  /// unchanged and the predicted flops stay below twice those at the last ordering; it is also redone
  /// some time after a good part of the couplings has gone.
  void analyze(const BlockPattern& pattern);
  /// The same order, found by the threads of `pool`.
  void analyze(const BlockPattern& pattern, ThreadPool& pool);

  /// The next analyze() orders anew, unless its pattern is the one that the present ordering was made for:
  /// what follows then depends on the patterns from here on only.
  void begin_sequence();
  /// Stands for analyze() of the present pattern, whose ordering is its own, at the start of a sequence: what
  /// follows must not depend on whether the pattern had been analysed before.
  void keep_analysis();
  /// Hash of the pattern that the present ordering was made for, 0 before the first.
  uint64_t ordered_pattern() const;

  /// Factorises `matrix`, whose pattern must be the analysed one.
  FactorStatus factor(const BlockMatrix& matrix, ThreadPool& pool);

  /// Solves A x = b with the last factor, which must have been positive definite. b and x may be the same
  /// array.
  void solve(const double* b, double* x);
  /// The same bits, with the independent subtrees shared among the threads of `pool`.
  void solve(const double* b, double* x, ThreadPool& pool);

  double flops() const;             // of one factorisation, multiplications and additions, without padding
  int64_t factor_nonzeros() const;  // scalar entries of L, including explicit zeros of merged supernodes
  int64_t ordering_count() const;   // orderings computed so far
  int64_t analysis_count() const;   // symbolic phases so far, with or without a new ordering

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

extern template class Cholesky<double>;
extern template class Cholesky<float>;

}  // namespace stark
