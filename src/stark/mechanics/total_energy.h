// An energy of totals: E = f(T_1, ..., T_m), where a total T_k = sum of s_k over all elements is the volume
// inside a closed surface, the length of a cable, the area of a sheet. [theory eq. 15h]
//
// A batch evaluates the plane that touches E at the totals of an iterate,
//   sum over elements of (c + sum_k f_k s_k),   f_k = df/dT_k,
// with E's value and gradient there. E's Hessian has, beside that of the plane, f_kl grad T_k grad T_l^T,
// which couples all points with each other: the solver takes it as a term of low rank (solve/low_rank.h).
// Phase: model building; evaluated in every assembly.
#pragma once

#include <span>
#include <vector>

#include <stark/mechanics/potential.h>

namespace stark {

class TotalEnergy {
 public:
  /// `energy` is an expression of the builder's graph that has totals. Throws InvalidArgument where positions
  /// or numbers of elements occur outside of them, or totals within totals.
  TotalEnergy(const PotentialBuilder& builder, const symbolic::Scalar& energy, symbolic::Backend backend);

  int count() const { return static_cast<int>(measures_.size()); }
  /// s_k of an element.
  const symbolic::Kernel& measure(int k) const { return measures_[k]; }
  /// What an element has of the touching plane. Its uniforms are those of the potential, f_1 ... f_m, and c.
  const symbolic::Kernel& plane() const { return plane_; }
  /// Hash of the formula.
  uint64_t fingerprint() const;

  /// f and its derivatives.
  struct Value {
    double energy = 0.0;
    std::vector<double> slopes{};     ///< [m]
    std::vector<double> curvature{};  ///< [m][m]
  };
  /// At totals [m], with the uniforms of the potential.
  Value evaluate(std::span<const double> totals, std::span<const double> uniforms) const;

 private:
  std::vector<symbolic::Kernel> measures_;
  symbolic::Kernel plane_, outer_;
};

}  // namespace stark
