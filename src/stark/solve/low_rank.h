// Terms of low rank beside a matrix of blocks: A + sum of c_k b_k b_k^T with full columns b_k, as an energy
// of totals has them (mechanics/total_energy.h), and systems with both [Woodbury 1950]:
//   x = y - Z (C^-1 + B^T Z)^-1 B^T y,   A y = r,   A Z = B.                        [theory eq. 22b]
// Its residual is that of y less that of Z times numbers, whatever the size of C.
// Phase: linear solve of a Newton step.
#pragma once

#include <functional>
#include <span>
#include <vector>

namespace stark {

struct LowRank {
  std::vector<std::vector<double>> columns{};  ///< b_k, [3 block_count] each
  std::vector<double> factors{};               ///< c_k, none of them zero

  bool empty() const { return factors.empty(); }
  void clear() { columns.clear(), factors.clear(); }
  /// Adds B C B^T with the symmetric C [m][m] by its eigenvalues; `project` leaves out negative ones.
  void add(const std::vector<std::vector<double>>& B, std::vector<double> C, bool project);
};

/// Corrects solutions of systems with A for the terms of low rank beside it.
class LowRankCorrection {
 public:
  /// x of A x = b; false where that has none.
  using Solve = std::function<bool(std::span<const double> b, std::span<double> x)>;
  /// False where a solve failed, or where the sum is not positive definite, given that A is.
  bool begin(const LowRank& terms, const Solve& solve);
  /// Subtracts from r what it has along the columns, which begin() has solved for; returns how much of each.
  std::vector<double> take_out(std::span<double> r) const;
  /// Adds the solution for what was taken out to that for the rest.
  void put_back(std::span<const double> taken, std::span<double> y) const;
  /// From A y = r to (A + B C B^T) y = r.
  void apply(std::span<double> y) const;

 private:
  const LowRank* terms_ = nullptr;
  std::vector<std::vector<double>> solved_;  ///< Z
  std::vector<double> inverse_;              ///< of C^-1 + B^T Z, [k][k]
};

}  // namespace stark
