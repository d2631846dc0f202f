// Conjugate gradients in the variables of a preconditioner (Hestenes and Stiefel 1952; Saad, Iterative
// Methods for Sparse Linear Systems, sections 9.2 and 9.5). Phase: linear solve of a Newton step.
#pragma once

#include <cstdint>
#include <span>

#include <stark/base/aligned.h>
#include <stark/base/thread_pool.h>
#include <stark/linalg/block_matrix.h>
#include <stark/linalg/expanded_matrix.h>

namespace stark {

/// A matrix A and its preconditioner M: what an iteration asks of them. Vectors have `size` numbers, in
/// variables of its own: it may solve B^-1 A B^-T y = B^-1 b for y = B^T x.
class PreconditionedMatrix {
 public:
  virtual ~PreconditionedMatrix() = default;

  /// Copies `matrix`. Structure is redone only if the pattern changed. False if a diagonal block is not
  /// positive definite.
  virtual bool prepare(const BlockMatrix& matrix, PcgStorage storage, ThreadPool& pool) = 0;
  virtual int32_t block_count() const = 0;
  /// First block whose diagonal block is not positive definite, -1 if all are.
  virtual int32_t failed_block() const = 0;

  virtual int64_t size() const = 0;
  /// r = b and z = M^-1 r, or a part of it whose rest multiply() adds. Returns r^T M^-1 r.
  virtual double start(const double* b, double* r, double* z, ThreadPool& pool) = 0;
  /// p = M^-1 r + beta p, q = A p. Returns p^T q.
  virtual double multiply(const double* z, double beta, double* p, double* q, ThreadPool& pool) = 0;
  /// y += alpha p, r -= alpha q, z as start() leaves it. Returns r^T M^-1 r.
  virtual double update(double alpha, const double* p, const double* q, double* y, double* r, double* z,
                        ThreadPool& pool) = 0;
  /// x of y.
  virtual void finish(const double* y, double* x, ThreadPool& pool) = 0;
};

struct PcgReport {
  bool converged = false;
  bool indefinite = false;    // p^T A p <= 0 was met, or a diagonal block is not positive definite
  int32_t failed_block = -1;  // the first block row whose diagonal block is not positive definite
  int iterations = 0;
  double relative_residual = 1.0;  // |b - A x| / |b| in the norm of the inverse preconditioner, as recurred
};

class Pcg {
 public:
  /// Solves A x = b from x = 0 until the residual, in the norm of the inverse preconditioner, falls below
  /// `tolerance` times that of b, and what k iterations like the last, the k-th, would lower the quadratic
  /// model x^T A x / 2 - b^T x by is below tolerance^2 of what all have [Nash and Sofer 1990]: residuals say
  /// little of soft modes. On indefiniteness x holds the last iterate, which is still a descent
  /// direction (b^T x > 0) unless it is the first iteration, where x is the preconditioned b.
  PcgReport solve(PreconditionedMatrix& matrix, std::span<const double> b, std::span<double> x,
                  double tolerance, int max_iterations, ThreadPool& pool);

  /// The direction of the last iteration, that of negative curvature where the matrix was indefinite.
  void get_direction(PreconditionedMatrix& matrix, std::span<double> out, ThreadPool& pool) const {
    matrix.finish(p_.data(), out.data(), pool);
  }

 private:
  AlignedVector<double> y_, r_, z_, p_, q_;
};

}  // namespace stark
