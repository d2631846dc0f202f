#include <stark/linalg/pcg.h>

#include <algorithm>
#include <cmath>

#include <stark/base/error.h>

namespace stark {

namespace {

constexpr double kSurely = 1e-2;  // of the squared residual that is asked: then decreases do not matter

}  // namespace

PcgReport Pcg::solve(PreconditionedMatrix& matrix, std::span<const double> b, std::span<double> x,
                     double tolerance, int max_iterations, ThreadPool& pool) {
  const size_t unknowns = 3 * static_cast<size_t>(matrix.block_count());
  STARK_CHECK(b.size() == unknowns && x.size() == unknowns);
  PcgReport report;
  std::ranges::fill(x, 0.0);
  if (matrix.failed_block() >= 0) {
    report.indefinite = true;
    report.failed_block = matrix.failed_block();
    return report;
  }
  for (auto* vector : {&y_, &r_, &z_, &p_, &q_}) vector->assign(matrix.size(), 0.0);
  double rz = matrix.start(b.data(), r_.data(), z_.data(), pool);
  const double rz_start = rz;
  if (!(rz > 0.0)) {  // b = 0, or not finite
    report.converged = rz == 0.0;
    report.relative_residual = rz == 0.0 ? 0.0 : 1.0;
    return report;
  }
  const double rz_stop = tolerance * tolerance * rz_start;
  double beta = 0.0, total = 0.0;
  while (report.iterations < max_iterations) {
    const double pq = matrix.multiply(z_.data(), beta, p_.data(), q_.data(), pool);
    ++report.iterations;
    if (!(pq > 0.0)) {
      report.indefinite = true;
      if (report.iterations == 1) y_ = p_;
      break;
    }
    const double alpha = rz / pq, decrease = alpha * rz;
    total += decrease;
    const double rz_next = matrix.update(alpha, p_.data(), q_.data(), y_.data(), r_.data(), z_.data(), pool);
    beta = rz_next / rz;
    rz = rz_next;
    if (!(rz > rz_stop)) {
      const bool is_settled = report.iterations * decrease <= tolerance * tolerance * total;
      if (is_settled || !(rz > kSurely * rz_stop)) {
        report.converged = rz <= rz_stop;
        break;
      }
    }
  }
  matrix.finish(y_.data(), x.data(), pool);
  report.relative_residual = std::sqrt(rz / rz_start);
  return report;
}

}  // namespace stark
